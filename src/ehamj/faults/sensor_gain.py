"""A sensor whose gain changes, as of an amplifier that fails or a cable that comes loose."""

from typing import Literal

from pydantic import Field

from ehamj.faults.sensor import SensorFault


class SensorGain(SensorFault):
    """Readings that are too large, too small, or reversed."""

    kind: Literal["sensor-gain"]
    factor: float = Field(0.5, description="by which readings are multiplied; negative: reversed [-]")

    @property
    def what(self) -> str:
        return f"{self.whose} read {self.factor:g} times what is there"

    def reading(self, last: float) -> tuple[float, float]:
        return self.factor, 0.0
