"""A sensor that is dead: it reads nothing any more, or for ever what it read last."""

from typing import Literal

from pydantic import Field

from ehamj.faults.sensor import SensorFault


class SensorDead(SensorFault):
    """Readings that no longer follow what they measure."""

    kind: Literal["sensor-dead"]
    reads: Literal["nothing", "last"] = Field(
        "nothing", description="what the law reads from then on: zero, or the last value"
    )

    @property
    def what(self) -> str:
        return f"{self.whose} dead: " + ("nothing is read" if self.reads == "nothing" else "the last value stays")

    def reading(self, last: float) -> tuple[float, float]:
        return 0.0, last if self.reads == "last" else 0.0
