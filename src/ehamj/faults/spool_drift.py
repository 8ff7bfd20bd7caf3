"""A valve whose null drifts, as of a torque motor that warms up or a feedback spring that gives way."""

from typing import Literal, Self

from pydantic import Field, model_validator

from ehamj.arrays import Array
from ehamj.faults.fault import FaultSettings, MountFault
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
        return self.ends - self.time + self.settling

    @property
    def ends(self) -> float:
        """When the opening stays [s]."""
        return self.time + self.limit / abs(self.rate)

    def check_beside(self, other: FaultSettings) -> None:
        if isinstance(other, SpoolDrift) and other.mount == self.mount and other.time <= self.time < other.ends:
            raise ValueError(
                f"time = {self.time:g} s: the null at {self.mount} drifts until {other.ends:g} s already; must be from "
                "then on, or one drift with both rates"
            )

    def after(self, plant: Plant, spools: Array) -> Plant:
        own = plant.actuators[plant.mounts.index(self.mount)]
        # A drift before this one, of an earlier fault or of the actuator itself, stays where it is.
        drifted = own.null_drift * max(self.time - own.null_drift_from, 0.0)
        offset = own.null_offset + min(max(drifted, -own.null_drift_limit), own.null_drift_limit)
        values = {
            "null_offset": offset, "null_drift": self.rate, "null_drift_from": self.time,
            "null_drift_limit": self.limit,
        }  # fmt: skip
        return plant.with_actuator(self.mount, values)

    def settled(self, plant: Plant, spools: Array, elapsed: float) -> Plant:
        own = plant.actuators[plant.mounts.index(self.mount)]
        share = min(elapsed * abs(self.rate) / self.limit, 1.0)
        drifted = share * self.limit * (1.0 if self.rate > 0.0 else -1.0)
        return plant.with_actuator(self.mount, {"null_offset": own.null_offset + drifted})
