"""Plane waves: every mount sees the same motion, each at its own time."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from ehamj.ground.motion import GroundSample, Motion, Slab, Start
from ehamj.layout import AXES
from ehamj.parameters import Settings
from ehamj.signals import Faded, Sample, Signal

Array = NDArray[np.float64]


class Wave(Settings):
    """A plane wave that passes below the machine."""

    speed: Annotated[float, Field(gt=0)] = Field(200.0, description="apparent wave speed c [m/s]")
    direction: float = Field(0.0, description="direction of travel, from +x towards +y [deg]")

    def delays(self, positions: Array) -> Array:
        """Arrival at each mount after the mount plane's centre, r·n/c [s]."""
        angle = np.radians(self.direction)
        return positions @ np.array([np.cos(angle), np.sin(angle)]) / self.speed


@dataclass(frozen=True)
class Travelling:
    """Translations of the ground that reach each mount with a delay of its own.

    ``signals`` maps x, y, z to the motion [m] at the mount plane's centre; ``delays`` (mount,) [s]. A motion that
    fades in does so at all mounts together.
    """

    signals: dict[str, Signal]
    delays: Array
    fade_in: float = 0.0
    notes: tuple[str, ...] = ()
    usable_to: float = float("inf")

    @property
    def at_rest(self) -> bool:
        return not self.signals

    @cached_property
    def _at_mounts(self) -> list[tuple[int, int, Signal]]:
        found: list[tuple[int, int, Signal]] = []
        for axis, signal in self.signals.items():
            for mount, delay in enumerate(self.delays):
                own: Signal = Delayed(signal, float(delay))
                found.append((mount, AXES.index(axis), Faded(own, self.fade_in) if self.fade_in > 0 else own))
        return found

    def sample(self, time: Array) -> GroundSample:
        motion = np.zeros((3, time.size, self.delays.size, len(AXES)))
        for mount, axis, signal in self._at_mounts:
            motion[:, :, mount, axis] = signal.sample(time)
        return GroundSample(*motion)


@dataclass(frozen=True)
class Delayed:
    """A signal that comes ``delay`` [s] later (earlier, where negative)."""

    signal: Signal
    delay: float

    def sample(self, time: Array, left: bool = False) -> Sample:
        return self.signal.sample(time - self.delay, left)


def spread(
    start: Start, signals: Mapping[str, Signal], wave: Wave | None, fade_in: float, notes: tuple[str, ...] = ()
) -> Motion:
    """Motion of all mounts from signals per degree of freedom: a rigid slab, or a plane wave of translations.

    Raises:
        ValueError: if a wave is asked to carry rotations.
    """
    if wave is None:
        faded = {dof: Faded(signal, fade_in) if fade_in > 0 else signal for dof, signal in signals.items()}
        return Slab(start.positions, faded, notes)
    turning = [dof for dof in signals if dof not in AXES]
    if turning:
        raise ValueError(f"ground.dof = {turning[0]!r}: a wave carries x, y or z; leave ground.wave out for a slab")
    return Travelling(dict(signals), wave.delays(start.positions), fade_in, notes)
