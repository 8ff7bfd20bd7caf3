"""The kinds of force there are, and all forces of a scenario together."""

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ehamj.errors import InputError, did_you_mean
from ehamj.forces.force import ForceSettings, Load
from ehamj.forces.recorded import RecordedForce
from ehamj.forces.transients import AxisJerk, Hammer
from ehamj.forces.vibrations import MultisineForce, RandomForce, SineForce, Unbalance
from ehamj.plant.axes import DOFS
from ehamj.plant.levers import lever
from ehamj.settings import Vector3, one_of

FORCES: tuple[type[ForceSettings], ...] = (
    Hammer,
    AxisJerk,
    Unbalance,
    SineForce,
    MultisineForce,
    RandomForce,
    RecordedForce,
)
"""Every kind of force; a table [[force]] holds one of them."""

if TYPE_CHECKING:
    Force = ForceSettings
else:
    Force = one_of(FORCES)

STREAM = 20_000
"""Keeps the random numbers of forces apart from those of the floor."""


def check_forces(forces: Sequence[ForceSettings], points: Mapping[str, Vector3]) -> None:
    """Refuse forces at places that do not exist.

    Raises:
        ValueError: naming the key, the value and what is allowed.
    """
    for k, force in enumerate(forces):
        if isinstance(force.point, str) and force.point != "cg" and force.point not in points:
            known = ", ".join(map(repr, (*points, "cg")))
            near = did_you_mean(force.point, points)
            raise ValueError(f"force.{k}.point = {force.point!r}: {near}must be one of {known}, or a place [x, y, z]")


def load_of(
    forces: Sequence[ForceSettings],
    points: Mapping[str, Vector3],
    cg: Vector3,
    duration: float,
    seed: int,
    about: Vector3 | None = None,
) -> Load:
    """All forces together, with moments ``about`` a point of the machine, the centre of gravity without [m].

    Raises:
        InputError: if a force cannot be made for this duration.
    """
    patterns, signals = [], []
    for k, force in enumerate(forces):
        at = cg if force.point == "cg" else points[force.point] if isinstance(force.point, str) else force.point
        try:
            parts = force.parts(duration, np.random.default_rng([seed, STREAM, k]))
        except InputError as error:
            raise InputError(re.sub(r"^force(?=[.:])|\bforce(?=\.[a-z])", f"force.{k}", str(error))) from error
        except MemoryError:
            raise InputError(f"force.{k}: {duration:g} s of it do not fit in memory") from None
        arm = lever(np.array(at) - np.array(about or cg))
        for direction, signal in parts:
            patterns.append(arm.T @ direction)  # d and (r − r_CG) × d
            signals.append(signal)
    longest_step = min((force.longest_step for force in forces), default=float("inf"))
    return Load(np.array(patterns).reshape(-1, len(DOFS)), tuple(signals), longest_step)
