"""A valve whose null drifts, as of a torque motor that warms up or a feedback spring that gives way."""

from typing import Literal, Self

from pydantic import Field, model_validator

from ehamj.arrays import Array
from ehamj.faults.fault import MountFault
from ehamj.plant.plant import Plant
from ehamj.settings import Positive


class SpoolDrift(MountFault):
    """The opening with the spool centred grows at a steady rate, up to a bound."""

    kind: Literal["spool-drift"]
    rate: float = Field(0.1, description="rate at which the opening drifts, of either sign [mA/s]")
    limit: Positive = Field(1.0, description="drift at which it ends [mA]")

    @model_validator(mode="after")
    def _drifts(self) -> Self:
        if self.rate == 0.0:
            raise ValueError("rate = 0 mA/s must not be zero")
        return self

    @property
    def what(self) -> str:
        return f"the valve's null drifts by {self.rate:g} mA/s, up to {self.limit:g} mA"

    @property
    def lasts(self) -> float:
        return self.limit / abs(self.rate) + self.settling

    def after(self, plant: Plant, spools: Array) -> Plant:
        values = {"null_drift": self.rate, "null_drift_from": self.time, "null_drift_limit": self.limit}
        return plant.with_actuator(self.mount, values)

    def settled(self, plant: Plant, spools: Array, elapsed: float) -> Plant:
        own = plant.actuators[plant.mounts.index(self.mount)]
        share = min(elapsed * abs(self.rate) / self.limit, 1.0)
        drifted = share * self.limit * (1.0 if self.rate > 0.0 else -1.0)
        return plant.with_actuator(self.mount, {"null_offset": own.null_offset + drifted})
