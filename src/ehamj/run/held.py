"""Inputs that are held between two instants: commands, ground accelerations, a force on the machine."""

from collections.abc import Sequence
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.memory import COMMAND
from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.levers import lever
from ehamj.plant.plant import Plant
from ehamj.run.drive import Driving
from ehamj.settings import Vector3


class Held(NamedTuple):
    """What is held from an instant on, beside what the scenario itself does."""

    commands: Array
    """Of each mount's valve, added to the law's behind its converter (mount,) [V]; the valve limits their sum to its
    range."""
    ground: Array
    """Acceleration of the ground below each mount (mount, axis) [m/s²]."""
    force: Array
    """Force and moment at the machine's centre of gravity, in the axes of the ground (6,) [N, N m]."""

    @classmethod
    def nothing(cls, mounts: int) -> Self:
        """No command, no motion, no force."""
        return cls(np.zeros(mounts), np.zeros((mounts, len(AXES))), np.zeros(len(DOFS)))

    def changed(self, mounts: Sequence[str], **given: ArrayLike | None) -> Self:
        """With other values; None: as before.

        Raises:
            InputError: if a value is not finite, or they are not as many as they must be.
        """
        stated = {name: value for name, value in given.items() if value is not None}
        return self._replace(
            **{name: _checked(name, value, getattr(self, name), mounts) for name, value in stated.items()}
        )


def _checked(name: str, given: Any, like: Array, mounts: Sequence[str]) -> Array:
    """Finite numbers of the shape that they must have, as a copy."""
    try:
        value = np.array(given, dtype=np.float64)
    except (TypeError, ValueError):
        value = np.full(0, np.nan)
    if value.shape != like.shape or not np.isfinite(value).all():
        order = {
            "commands": f"one command per mount [V], {', '.join(mounts)}",
            "ground": f"x, y, z [m/s^2] of the ground below each of {', '.join(mounts)}",
            "force": "force x, y, z [N] and moment x, y, z [N m] at the centre of gravity",
        }[name]
        raise InputError(f"{name} = {np.asarray(given, object).tolist()}: must be {order}, all finite: {like.shape}")
    return value


class Moved(NamedTuple):
    """Where held accelerations have taken the ground at an instant, (mount, axis) each."""

    displacement: Array
    """[m]"""
    velocity: Array
    """[m/s]"""

    @classmethod
    def at_rest(cls, mounts: int) -> Self:
        """Nowhere."""
        return cls(*np.zeros((2, mounts, len(AXES))))

    def after(self, seconds: float | Array, acceleration: Array) -> Self:
        """After so many seconds, (…, 1, 1) or one number, under an acceleration (mount, axis) [m/s²]: exact."""
        gained = acceleration * seconds
        return type(self)(self.displacement + self.velocity * seconds + 0.5 * gained * seconds, self.velocity + gained)


def about_carrier(plant: Plant) -> Array:
    """What takes force and moment at the machine's centre of gravity to that of the engine's body, which slides are
    left out of, (6, 6)."""
    body: Vector3 = (plant.carrier or plant.machine).cg
    arm = np.array(plant.machine.cg) - np.array(body)
    found = np.eye(len(DOFS))
    found[len(AXES) :, : len(AXES)] = lever(arm)[:, len(AXES) :].T  # (r − r_body) × F
    return found


def add(driving: Driving, held: Held, moved: Moved, ahead: int, timestep: float, carried: Array) -> Driving:
    """What drives a machine, with what is held added.

    Args:
        driving: of some steps; its arrays are added to.
        held: in all of them.
        moved: where held accelerations had taken the ground at the instant from which they are held.
        ahead: steps from that instant to the first of these.
        timestep: of each [s].
        carried: force and moment as the engine takes them (6,).
    """
    mounts, (starts, ends) = len(held.commands), driving.inputs
    seconds = timestep * (ahead + np.arange(len(starts) + 1, dtype=np.float64))[:, None, None]
    ground = moved.after(seconds, held.ground)
    slopes = timestep * ground.velocity
    for points, part in ((starts, slice(None, -1)), (ends, slice(1, None))):
        points[:, :mounts, :COMMAND, 0] += ground.displacement[part]
        points[:, :mounts, :COMMAND, 1] += slopes[part]
        points[:, :mounts, :COMMAND, 2] += held.ground
        points[:, :mounts, COMMAND, 0] += held.commands
    for force in driving.load[:2]:
        force[:, :, 0] += carried
    return driving
