"""A valve that sticks: its spool stays where it is, or runs to an opening and stays there."""

from typing import Any, Literal

from pydantic import Field

from ehamj.arrays import Array
from ehamj.faults.fault import MountFault
from ehamj.plant.plant import Plant


class ValveStuck(MountFault):
    """The spool no longer follows the command."""

    kind: Literal["valve-stuck"]
    opening: float | None = Field(
        None, ge=-1, le=1, description="where it sticks, as share of its stroke [-]; without: where it is just then"
    )

    @property
    def what(self) -> str:
        if self.opening is None:
            return "the valve sticks where it is"
        return f"the valve sticks {100 * self.opening:g} % open" if self.opening else "the valve sticks centred"

    def after(self, plant: Plant, spools: Array) -> Plant:
        k = plant.mounts.index(self.mount)
        stroke = plant.actuators[k].spool_stroke
        here = min(max(float(spools[k]) / stroke, -1.0), 1.0)
        at = here if self.opening is None else self.opening
        return plant.with_actuator(self.mount, {"spool_stuck": True, "spool_stuck_at": at})

    def strike(self, states: Any) -> None:
        if self.opening is None:
            states[self.mount]["spool_rate"] = 0.0
