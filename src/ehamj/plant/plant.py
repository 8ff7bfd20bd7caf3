"""Everything physical that is simulated, as one value."""

from dataclasses import dataclass, replace
from typing import Any, Literal, Self

from ehamj.isolator.actuator import Actuator
from ehamj.isolator.supply import Supply
from ehamj.plant.machine import Machine
from ehamj.plant.mounts import MOUNTS
from ehamj.settings import Position2


@dataclass(frozen=True)
class Plant:
    """Everything physical that is simulated: the machine, its four isolators in the order of the mounts, the supply."""

    machine: Machine
    positions: tuple[Position2, ...]
    """x and y of each mount [m]."""
    actuators: tuple[Actuator, ...]
    supply: Supply
    gravity: float
    """Gravitational acceleration, downwards positive [m/s²]."""
    plates: Literal["sliding", "tied"]
    """``sliding``: each plate on a joint of its own; ``tied``: the plate's inertia on the stroke coordinate."""
    mounts: tuple[str, ...] = MOUNTS
    """Names of the mounts, in the order of everything that has one entry per mount."""
    bookkeeping: bool = False
    """Whether oil and energy are balanced in the simulation's own states."""
    cut_off: tuple[str, ...] = ()
    """Mounts whose branch has lost the supply: their valves are fed at the tank's pressure."""

    def with_actuator(self, mount: str, values: dict[str, Any]) -> Self:
        """The plant with other values of the actuator at one mount."""
        changed = [
            actuator.with_values(values) if name == mount else actuator
            for name, actuator in zip(self.mounts, self.actuators, strict=True)
        ]
        return replace(self, actuators=tuple(changed))

    @property
    def total_mass(self) -> float:
        """Machine and plates [kg]."""
        return self.machine.mass + sum(actuator.plate_mass for actuator in self.actuators)
