"""What was measured, as a signal: straight or held between samples, and replayed with a factor and a delay."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.signals import SLACK, Sample, Signal


@dataclass(frozen=True)
class Straight:
    """Straight lines through uniform samples, ``values`` (n,) at ``start`` + k/``rate``; outside the ends hold."""

    rate: float
    values: Array = field(repr=False)
    start: float = 0.0

    def sample(self, time: Array, left: bool = False) -> Sample:
        piece = _piece(self, time, left)
        inside = (piece >= 0) & (piece < self.values.size - 1)
        first = np.clip(piece, 0, max(0, self.values.size - 2))
        last = np.minimum(first + 1, self.values.size - 1)
        along = np.clip((time - self.start) * self.rate - first, 0.0, 1.0)
        rise = self.values[last] - self.values[first]
        return Sample(self.values[first] + along * rise, np.where(inside, rise * self.rate, 0.0), np.zeros_like(along))


@dataclass(frozen=True)
class Stairs:
    """Each sample held until the next, as a converter holds it; ``values`` (n,) at ``start`` + k/``rate``."""

    rate: float
    values: Array = field(repr=False)
    start: float = 0.0

    def sample(self, time: Array, left: bool = False) -> Sample:
        value = self.values[np.clip(_piece(self, time, left), 0, self.values.size - 1)]
        return Sample(value, np.zeros_like(value), np.zeros_like(value))


@dataclass(frozen=True)
class Replayed:
    """A signal times ``scale``, later by ``delay`` [s]."""

    signal: Signal
    scale: float = 1.0
    delay: float = 0.0

    def sample(self, time: Array, left: bool = False) -> Sample:
        found = self.signal.sample(time - self.delay, left)
        return Sample(*(self.scale * part for part in found))


def _piece(signal: Straight | Stairs, time: Array, left: bool) -> NDArray[np.int64]:
    """Number of the sample that a time follows, or that it follows at once where it is asked for ``left`` of it."""
    at = (time - signal.start + (-SLACK if left else SLACK)) * signal.rate
    return np.asarray(np.floor(at)).astype(np.int64)
