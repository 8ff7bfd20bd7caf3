"""A cylinder that leaks: across its piston, or from a chamber to outside."""

from typing import Any, Final, Literal

from pydantic import Field, model_validator

from ehamj.arrays import Array
from ehamj.faults.fault import MountFault
from ehamj.isolator.actuator import Actuator
from ehamj.plant.plant import Plant
from ehamj.settings import Positive

FACTORS: Final = {"piston": 100.0, "outside": 0.05}
"""Conductance of a leak over K_C unless it is stated: a worn seal, and a loose fitting that loses half a litre a minute
of the default supply."""


class ChamberLeak(MountFault):
    """Oil passes where it should not."""

    kind: Literal["chamber-leak"]
    path: Literal["piston", "outside"] = Field("piston", description="where the oil goes")
    chamber: Literal[1, 2] = Field(1, description="chamber that leaks to outside; chamber 1 lifts")
    factor: Positive = Field(
        FACTORS["piston"],
        description="across the piston: by which the flow-pressure coefficient K_C is multiplied; to outside: "
        f"conductance of the leak over K_C, {FACTORS['outside']:g} where it is left out [-]",
    )

    @model_validator(mode="before")
    @classmethod
    def _own_factor(cls, table: Any) -> Any:
        path = table.get("path") if isinstance(table, dict) else None
        return {"factor": FACTORS[path], **table} if isinstance(path, str) and path in FACTORS else table

    @property
    def what(self) -> str:
        if self.path == "piston":
            return f"oil passes the piston {self.factor:g} times as easily"
        return f"chamber {self.chamber} leaks to outside, {self.factor:g} times K_C"

    def after(self, plant: Plant, spools: Array) -> Plant:
        own = plant.actuators[plant.mounts.index(self.mount)]
        return plant.with_actuator(self.mount, self.leaking(own))

    def leaking(self, own: Actuator) -> dict[str, Any]:
        """Values of the actuator that differ; leakage over the valve's edges stays."""
        if self.path == "piston":
            share = own.edge_leakage_share / self.factor
            return {"flow_pressure": self.factor * own.flow_pressure, "edge_leakage_share": min(share, 1.0)}
        name = f"outside_leakage_{self.chamber}"
        return {name: getattr(own, name) + self.factor * own.flow_pressure}
