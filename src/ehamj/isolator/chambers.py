"""What the chambers of many isolators hold over time, from recorded states: the kernels of `ehamj.isolator.fluid`."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple, Self

import numba
import numpy as np
from numpy.typing import NDArray

from ehamj.compiled import compiled_here
from ehamj.isolator.actuator import Actuator
from ehamj.isolator.cylinder import Cylinder, CylinderValues, chamber_volumes
from ehamj.isolator.fluid import Fluid, FluidValues, contents

Array = NDArray[np.float64]


class Held(NamedTuple):
    """What chambers hold over time (time, mount, chamber); see `ehamj.isolator.fluid.Contents`."""

    void: Array
    mass: Array
    energy: Array


@dataclass(frozen=True)
class Chambers:
    """The chambers of isolators, as their kernels know them."""

    cylinders: tuple[CylinderValues, ...]
    oils: tuple[FluidValues, ...]

    @classmethod
    def of(cls, actuators: Sequence[Actuator]) -> Self:
        """The chambers of these isolators."""
        return cls(*(tuple(part.values_of(actuator) for actuator in actuators) for part in (Cylinder, Fluid)))

    @property
    def area(self) -> Array:
        """Areas (mount, chamber) [m²]."""
        return np.array([[own.piston_area, own.piston_area_2] for own in self.cylinders])

    def pressure(self, states: Array) -> Array:
        """Pressure of the oil [Pa] from the pressure states (time, mount, chamber)."""
        return np.maximum(states, np.array([oil.vapour_pressure for oil in self.oils])[:, None])

    def contents(self, states: Array, stroke: Array) -> Held:
        """What they hold.

        Args:
            states: pressure states (time, mount, chamber) [Pa].
            stroke: (time, mount) [m].
        """
        found = np.empty((3, *states.shape))
        for mount, (cylinder, oil) in enumerate(zip(self.cylinders, self.oils, strict=True)):
            _contents()(
                np.ascontiguousarray(states[:, mount]), stroke[:, mount].copy(), cylinder, oil, found[:, :, mount]
            )
        return Held(*found)


@cache
def _contents() -> Any:
    def of_one(states, stroke, cylinder, oil, found):  # type: ignore[no-untyped-def]
        for k in range(stroke.size):
            volumes = chamber_volumes(stroke[k], cylinder)
            for chamber in range(2):
                held = contents(states[k, chamber], volumes[chamber], oil)
                found[0, k, chamber], found[1, k, chamber], found[2, k, chamber] = held

    with compiled_here() as kept:
        return numba.njit(nogil=True, error_model="numpy", cache=kept)(of_one)
