"""A supply that is lost: for the whole machine, or for the branch of one mount."""

from dataclasses import replace
from typing import Final, Literal

from pydantic import Field

from ehamj.arrays import Array
from ehamj.faults.fault import FaultSettings
from ehamj.plant.plant import Plant

NEGLIGIBLE_AREA: Final = 1e-6
"""Area of a piston whose oil carries nothing [m²]: 7 N at the default supply's pressure."""
NOTHING: Final = 1e-12
"""Flow of a pump that stands still [m³/s]."""


class SupplyLost(FaultSettings):
    """Valves are no longer fed."""

    kind: Literal["supply-lost"]
    mount: str | None = Field(
        None,
        description="mount whose branch falls to the tank's pressure at once; without, the whole machine: a constant "
        "supply falls so too, of a dynamic one the pump stops and the accumulator empties",
    )

    @property
    def what(self) -> str:
        return "the supply is lost" if self.mount is None else "the branch of the supply is lost"

    def after(self, plant: Plant, spools: Array) -> Plant:
        if self.mount is None and plant.supply.dynamic:
            return replace(plant, supply=plant.supply.with_values({"pump_flow": NOTHING}))
        cut = {*plant.cut_off, *self._lost(plant)}
        return replace(plant, cut_off=tuple(name for name in plant.mounts if name in cut))

    def settled(self, plant: Plant, spools: Array, elapsed: float) -> Plant:
        supply = plant.supply.with_values({"dynamic": plant.supply.dynamic and self.mount is not None})
        cut = self.after(replace(plant, supply=supply), spools)
        for name in self._lost(plant):
            # At the tank's pressure oil that cavitates carries nothing: each swing draws a void, and none is filled.
            own = plant.actuators[plant.mounts.index(name)]
            if plant.supply.tank_pressure <= own.vapour_pressure:
                cut = cut.with_actuator(name, {"piston_area": NEGLIGIBLE_AREA})
        return cut

    def _lost(self, plant: Plant) -> tuple[str, ...]:
        return plant.mounts if self.mount is None else (self.mount,)
