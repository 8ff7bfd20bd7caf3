"""What the chambers of many isolators hold over time, from recorded states: the kernels of `ehamj.isolator.fluid`."""

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ehamj.arrays import Array
from ehamj.compiled.kept import compiled
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.cylinder import Cylinder, chamber_volumes, oil_force
from ehamj.isolator.fluid import Fluid, actual_pressure, contents


class Held(NamedTuple):
    """What chambers hold over time (time, mount, chamber); see `ehamj.isolator.fluid.Contents`."""

    pressure: Array
    """Of the oil [Pa]."""
    void: Array
    mass: Array
    energy: Array
    force: Array
    """Of the oil on the piston, towards the machine positive [N], (time, mount)."""


def held(actuators: Sequence[Actuator], states: Array, stroke: Array) -> Held:
    """What the chambers of these isolators hold.

    Args:
        actuators: one per mount.
        states: pressure states (time, mount, chamber) [Pa].
        stroke: (time, mount) [m].
    """
    found, force = np.empty((4, *states.shape)), np.empty(stroke.shape)
    states, stroke = np.ascontiguousarray(states), np.ascontiguousarray(stroke)
    for mount, actuator in enumerate(actuators):
        own = Cylinder.values_of(actuator), Fluid.values_of(actuator)
        _held()(states[:, mount], stroke[:, mount], *own, found[:, :, mount], force[:, mount])
    return Held(found[0], found[1], found[2], found[3], force)


@cache
def _held() -> Any:
    def of_one(states, stroke, cylinder, oil, found, force):  # type: ignore[no-untyped-def]
        for k in range(stroke.size):
            volumes = chamber_volumes(stroke[k], cylinder)
            for chamber in range(2):
                found[0, k, chamber] = actual_pressure(states[k, chamber], oil.vapour_pressure)
                own = contents(states[k, chamber], volumes[chamber], oil)
                found[1, k, chamber], found[2, k, chamber], found[3, k, chamber] = own
            force[k] = oil_force(found[0, k, 0], found[0, k, 1], cylinder)

    return compiled(of_one)
