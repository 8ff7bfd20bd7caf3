"""What a floor does to the machine, linear, with or without a law."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.control import LinearController
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.linear.machine import LinearModel
from ehamj.linear.response import ground_response, slab_pattern
from ehamj.plant.axes import AXES
from ehamj.plant.mounts import N_MOUNTS
from ehamj.plant.plant import Plant
from ehamj.scenario.model import Scenario

ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True)
class Loop:
    """A law with the instruments that it reads, drawn from ``seed``."""

    law: LinearController
    sensors: Sensors = IDEAL
    seed: int = 0

    @classmethod
    def of(cls, scenario: Scenario) -> Self | None:
        """The scenario's own loop, if it has a controller."""
        law = scenario.controller()
        return None if law is None else cls(law, scenario.sensors, scenario.seed)


def ground_to(
    model: LinearModel, loop: Loop | None, hertz: NDArray[np.float64], outputs: Sequence[str]
) -> ComplexArray:
    """Response to the displacement of the ground at each mount and axis, (frequency, output, mount·axis)."""
    if loop is None:
        return ground_response(model, hertz, outputs)
    return ground_response(model, hertz, outputs, loop.law, loop.sensors, loop.seed)


def floor_response(
    model: LinearModel, loop: Loop | None, hertz: ArrayLike, outputs: Sequence[str], motion: ComplexArray
) -> ComplexArray:
    """Response of channels to a ground displacement, (frequency, output); without a loop, with held valves.

    Args:
        model: linearised machine.
        loop: closes the sampled loop.
        hertz: frequencies (n,) [Hz].
        outputs: channels (`ehamj.control.channels`).
        motion: complex amplitude of the ground, (mount, axis) or (frequency, mount, axis) [m].
    """
    f = np.atleast_1d(np.asarray(hertz, float))
    ground = np.broadcast_to(motion, (f.size, N_MOUNTS, len(AXES))).reshape(f.size, -1)
    return np.asarray(np.einsum("fog,fg->fo", ground_to(model, loop, f, outputs), ground))


def rigid_floor(plant: Plant, dof: str) -> ComplexArray:
    """Displacement of each mount's ground, (mount, axis), for one unit of a rigid slab's degree of freedom [m, rad].

    Raises:
        InputError: if there is no such degree of freedom.
    """
    return slab_pattern(plant, (dof,))[:, 0].reshape(N_MOUNTS, len(AXES)).astype(complex)
