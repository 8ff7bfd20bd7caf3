"""What every force on the machine has: a place, a direction, and signals along it."""

from abc import abstractmethod
from typing import Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.settings import Settings, Vector3
from ehamj.signals import Array, Faded, Signal

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

    fade_in: float = Field(0.0, ge=0, description="time over which the force fades in [s]")

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
        signal = self.signal(duration, random)
        return [(self.axis, Faded(signal, self.fade_in) if self.fade_in > 0.0 else signal)]
