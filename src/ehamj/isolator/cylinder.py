"""The double-acting cylinder: areas, chamber volumes, and the oil's force."""

from typing import Any, ClassVar

from pydantic import Field

from ehamj.compiled import kernel
from ehamj.isolator.component import Component
from ehamj.settings import quantity


class Cylinder(Component):
    """Areas and volumes of the two chambers."""

    piston_area: float = quantity(3.18e-2, "m²", "A_p", "active area of the piston annulus", "paper", gt=0)
    chamber_volume: float = quantity(5.39e-4, "m³", "V_t", "oil volume of both chambers together", "paper", gt=0)
    moving_volume: bool = Field(True, description="chamber volumes follow the stroke (false: constant)")
    area_ratio: float = quantity(1.0, "-", "A_2/A_1", "area of chamber 2 over that of chamber 1", "paper", gt=0)
    volume_share: float = quantity(0.5, "-", "V_1/V_t", "share of chamber 1 in the oil volume", "paper", gt=0, lt=1)

    takes: ClassVar[Any] = ("piston_area", "piston_area_2", "volume_1", "volume_2", "moving_volume")

    @property
    def piston_area_2(self) -> float:
        """Area of chamber 2, A_2 [m²]."""
        return self.area_ratio * self.piston_area

    @property
    def volume_1(self) -> float:
        """Volume of chamber 1 at stroke 0, V_1 [m³]."""
        return self.volume_share * self.chamber_volume

    @property
    def volume_2(self) -> float:
        """Volume of chamber 2 at stroke 0, V_2 [m³]."""
        return (1.0 - self.volume_share) * self.chamber_volume

    @property
    def maximum_stroke(self) -> float:
        """Stroke at which one chamber is empty [m]."""
        return min(self.volume_1, (self.chamber_volume - self.volume_1) / self.area_ratio) / self.piston_area


@kernel
def chamber_volumes(stroke: float, own: "Cylinder") -> tuple[float, float]:
    """Volumes of both chambers, walls unstretched [m³]."""
    moved = own.moving_volume * stroke
    return own.volume_1 + own.piston_area * moved, own.volume_2 - own.piston_area_2 * moved


@kernel
def swept_flows(speed: float, own: "Cylinder") -> tuple[float, float]:
    """Rates of both volumes at a stroke's speed [m³/s], whether the volumes follow it or not."""
    return own.piston_area * speed, -own.piston_area_2 * speed


@kernel
def oil_force(pressure_1: float, pressure_2: float, own: "Cylinder") -> float:
    """Force of the oil on the piston, towards the machine positive [N]: A_1 P_1 − A_2 P_2 (paper eq. 7)."""
    return own.piston_area * pressure_1 - own.piston_area_2 * pressure_2
