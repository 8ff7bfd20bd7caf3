"""Everything physical that is simulated, as one value."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Final, Literal, Self

import numpy as np

from ehamj.isolator.actuator import Actuator
from ehamj.isolator.supply import Supply
from ehamj.plant.layout import Layout
from ehamj.plant.machine import Machine
from ehamj.plant.mounts import MOUNTS, UP, UPRIGHT
from ehamj.plant.slide import Slide, places_of
from ehamj.settings import Vector3

STANDARD_GRAVITY: Final = 9.80665
"""[m/s²]: membranes are as stiff without gravity."""

STIFF: Final = 1e-4
"""How far the weight may compress membranes that count as stiff [m]."""


@dataclass(frozen=True)
class Plant:
    """Everything physical that is simulated: the machine, its isolators in the order of the mounts, the supply."""

    machine: Machine
    """All that is rigid: the frame with the parts on it, and the slides where they stand at the start."""
    positions: tuple[Vector3, ...]
    """x, y, z of each mount [m]."""
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

    directions: tuple[Vector3, ...] = ()
    """Unit vectors along which the mounts act, towards the machine; up without."""
    heights: tuple[float, ...] = ()
    """Shims below the mounts, along their directions [m]; none without."""
    slides: tuple[Slide, ...] = ()
    """What moves on the machine; linear models know none, see `locked`."""
    carrier: Machine | None = None
    """The machine without its slides, where it has any."""

    def __post_init__(self) -> None:
        for name, value in (("directions", UP), ("heights", 0.0)):
            if not getattr(self, name):
                object.__setattr__(self, name, (value,) * len(self.positions))

    @cached_property
    def layout(self) -> Layout:
        """What the mounts can do together."""
        active = tuple(not actuator.passive for actuator in self.actuators)
        return Layout(np.array(self.positions), np.array(self.directions), active)

    @cached_property
    def central(self) -> Layout:
        """`layout` with rotations about the height of the centre of gravity, above the mount plane's centre, where its
        motions are hardly coupled; of upright mounts it is the same."""
        return self.layout.raised(self.machine.cg[2])

    @cached_property
    def obeying(self) -> Self:
        """The plant with its active mounts alone: what laws command."""
        kept = [k for k, actuator in enumerate(self.actuators) if not actuator.passive]
        if len(kept) == len(self.actuators):
            return self
        each = ("positions", "actuators", "mounts", "directions", "heights")
        own: dict[str, Any] = {name: tuple(getattr(self, name)[k] for k in kept) for name in each}
        return replace(self, **own)

    @property
    def flat(self) -> bool:
        """Whether all mounts are upright and in the mount plane: their strokes are then linear to third order."""
        upright = all(direction[2] > 1.0 - UPRIGHT for direction in self.directions)
        return upright and all(position[2] == 0.0 for position in self.positions)

    @property
    def level_enough(self) -> bool:
        """Whether constant levers serve: `flat`, on membranes so stiff that the machine hardly turns.

        With constant levers, what happens across flat mounts errs by the tilt's share of one; on stiff membranes tilts
        are of the order of what the weight compresses, over the machine's size: 15 µm, or 1e-5, of the default.
        """
        weight = self.total_mass * STANDARD_GRAVITY
        return self.flat and weight < STIFF * sum(actuator.static_stiffness for actuator in self.actuators)

    def with_actuator(self, mount: str, values: dict[str, Any]) -> Self:
        """The plant with other values of the actuator at one mount."""
        changed = [
            actuator.with_values(values) if name == mount else actuator
            for name, actuator in zip(self.mounts, self.actuators, strict=True)
        ]
        return replace(self, actuators=tuple(changed))

    def locked(self, places: Mapping[str, float] | None = None) -> Self:
        """The plant with its slides as parts of the machine, at coordinates [m] by name, or where they start.

        Raises:
            InputError: if a name is unknown, or a place off its rail.
        """
        at = places_of(self.slides, places)
        if self.carrier is None:
            return self
        bodies = [slide.body(place) for slide, place in zip(self.slides, at, strict=True)]
        return replace(self, machine=self.carrier.with_bodies(bodies), slides=(), carrier=None)

    @property
    def total_mass(self) -> float:
        """Machine with all that is on it, and plates [kg]."""
        return self.machine.mass + sum(actuator.plate_mass for actuator in self.actuators)
