"""The double-acting cylinder: areas, chamber volumes, and the oil's force."""

from typing import Any, ClassVar, NamedTuple

from pydantic import Field

from ehamj.compiled import kernel
from ehamj.isolator.component import Component
from ehamj.settings import quantity


class CylinderValues(NamedTuple):
    """A_1, A_2 [m²]; V_1, V_2 at stroke 0 [m³]; 1: volumes follow the stroke."""

    piston_area: float
    piston_area_2: float
    volume_1: float
    volume_2: float
    moving_volume: float


class Cylinder(Component):
    """Areas and volumes of the two chambers."""

    piston_area: float = quantity(3.18e-2, "m²", "A_p", "active area of the piston annulus", "paper", gt=0)
    chamber_volume: float = quantity(5.39e-4, "m³", "V_t", "oil volume of both chambers together", "paper", gt=0)
    moving_volume: bool = Field(True, description="chamber volumes follow the stroke (false: constant)")
    area_ratio: float = quantity(1.0, "-", "A_2/A_1", "area of chamber 2 over that of chamber 1", "paper", gt=0)
    volume_share: float = quantity(0.5, "-", "V_1/V_t", "share of chamber 1 in the oil volume", "paper", gt=0, lt=1)

    Values: ClassVar[Any] = CylinderValues

    def derived(self) -> dict[str, float]:
        """Area of chamber 2 and volumes of both."""
        return {
            "piston_area_2": self.area_ratio * self.piston_area,
            "volume_1": self.volume_share * self.chamber_volume,
            "volume_2": (1.0 - self.volume_share) * self.chamber_volume,
        }

    @property
    def maximum_stroke(self) -> float:
        """Stroke at which one chamber is empty [m]."""
        volume_1 = self.volume_share * self.chamber_volume
        return min(volume_1, (self.chamber_volume - volume_1) / self.area_ratio) / self.piston_area


@kernel
def chamber_volumes(stroke: float, own: CylinderValues) -> tuple[float, float]:
    """Volumes of both chambers, walls unstretched [m³]."""
    moved = own.moving_volume * stroke
    return own.volume_1 + own.piston_area * moved, own.volume_2 - own.piston_area_2 * moved


@kernel
def swept_flows(speed: float, own: CylinderValues) -> tuple[float, float]:
    """Rates of both volumes at a stroke's speed [m³/s], whether the volumes follow it or not."""
    return own.piston_area * speed, -own.piston_area_2 * speed


@kernel
def oil_force(pressure_1: float, pressure_2: float, own: CylinderValues) -> float:
    """Force of the oil on the piston, up positive [N]: A_1 P_1 − A_2 P_2 (paper eq. 7)."""
    return own.piston_area * pressure_1 - own.piston_area_2 * pressure_2
