"""What every force on the machine has, a place, a direction and signals along it; and all of them as one wrench."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.plant.axes import DOFS
from ehamj.settings import Fade, Settings, Vector3
from ehamj.signals import Array, Signal, faded

PER_PERIOD = 20
"""Steps per period, or per rise, with which a force is still followed to some 1e-4."""


class ForceSettings(Settings):
    """What a user writes in [[force]] of some ``kind``; ``ehamj.forces.kinds`` lists them."""

    kind: str

    point: str | Vector3 = Field(
        "cg", description="a name in [points], 'cg', or a place from the mount plane's centre [m]"
    )
    direction: Vector3 = Field((0.0, 0.0, 1.0), description="direction of the force (any length)")

    @model_validator(mode="after")
    def _directed(self) -> Self:
        if not any(self.direction):
            raise ValueError("direction = [0, 0, 0] must not be zero")
        return self

    @property
    def axis(self) -> Array:
        """The direction, of length one."""
        axis = np.array(self.direction)
        return np.asarray(axis / np.linalg.norm(axis))

    @property
    @abstractmethod
    def longest_step(self) -> float:
        """Step with which the force is still followed [s]."""

    @abstractmethod
    def parts(self, duration: float, random: np.random.Generator) -> list[tuple[Array, Signal]]:
        """Directions and forces along them [N]."""


class ContinuousForce(ForceSettings):
    """A force that lasts, up to a highest frequency."""

    fade_in: Fade = Field(0.0, description="time over which the force fades in [s]")

    @property
    @abstractmethod
    def _highest(self) -> float:
        """Highest frequency [Hz]."""

    @property
    def longest_step(self) -> float:
        return 1.0 / (self._highest * PER_PERIOD)

    @abstractmethod
    def signal(self, duration: float, random: np.random.Generator) -> Signal:
        """Force over time [N], unfaded."""

    def parts(self, duration: float, random: np.random.Generator) -> list[tuple[Array, Signal]]:
        return [(self.axis, faded(self.signal(duration, random), self.fade_in))]


@dataclass(frozen=True)
class Load:
    """Force [N] and moment [N m] at the centre of gravity, in the axes of the ground: a sum of patterns times signals.

    ``patterns`` (forces, 6) per newton of each signal. Directions stay those of the ground; the machine's own turning,
    some µrad, is left out.
    """

    patterns: Array
    signals: tuple[Signal, ...]
    longest_step: float = float("inf")
    """Step with which the shortest of them is still followed [s]."""

    @property
    def absent(self) -> bool:
        """Whether there is none."""
        return not self.signals

    def sample(self, time: Array, left: bool = False) -> tuple[Array, Array]:
        """The wrench and its rate at ``time`` [s], (n, 6) each; ``left``: limit from the left where it jumps."""
        value, slope = np.zeros((2, time.size, len(DOFS)))
        for pattern, signal in zip(self.patterns, self.signals, strict=True):
            sample = signal.sample(time, left)
            value += np.multiply.outer(sample.value, pattern)
            slope += np.multiply.outer(sample.slope, pattern)
        return value, slope
