"""What a test compares: measured beside predicted, channel by channel, at one or many points at once."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.identification.unknowns import Unknown, Values

Axis = Literal["time", "frequency", "number"]
"""What the samples of a channel stand at: [s], [Hz], or one after the other."""


@dataclass(frozen=True)
class Compared:
    """One channel of a test at one point."""

    name: str
    """ehamj's name of the channel; of a response "OUTPUT / INPUT"."""
    unit: str
    axis: Axis
    at: Array
    """Times [s], frequencies [Hz] or numbers, (n,)."""
    measured: Array | ComplexArray
    """(n,)"""
    predicted: Array | ComplexArray
    """(n,)"""
    deviation: Array
    """Standard deviation of each sample's error (of a complex one √E|error|²), (n,); NaN: to be estimated, one for the
    channel."""
    slopes: Mapping[str, Array | ComplexArray] = field(default_factory=dict)
    """Derivative of the prediction in those of the test's own unknowns that have one in closed form, (n,) each; the
    others are differenced."""
    coherence: Array | None = None
    """Of a measured response, (n,)."""

    @property
    def error(self) -> Array:
        """Measured − predicted as real numbers, (n,), of complex ones real parts then imaginary ones, (2n,)."""
        return real(self.measured - self.predicted)


def real(values: Array | ComplexArray) -> Array:
    """Complex numbers as real ones, (n,) → (2n,); real ones as they are."""
    if np.iscomplexobj(values):
        return np.concatenate([values.real, values.imag])
    return np.asarray(values, float)


def fit_percent(measured: Array | ComplexArray, predicted: Array | ComplexArray) -> float:
    """100·(1 − |measured − predicted|/|measured − mean|) [%]; NaN of a constant."""
    spread = float(np.linalg.norm(measured - np.mean(measured)))
    return 100.0 * (1.0 - float(np.linalg.norm(measured - predicted)) / spread) if spread > 0.0 else float("nan")


class Failed(Exception):
    """No prediction at this point: the run stopped, or there is no equilibrium; the message says why."""


class Residuals(Protocol):
    """What a test says of a point: how far the model is from what was measured."""

    name: str
    """Of the test."""
    held_out: bool
    """Whether it is not fitted, and only validates."""
    unknowns: tuple[Unknown, ...]
    """The test's own (nuisances)."""

    def compared(self, batch: Sequence[Values]) -> list[tuple[Compared, ...] | Failed]:
        """All channels at each of many points, which an engine may step side by side; each point has the same channels
        with the same samples."""
        ...

    def rough(self, batch: Sequence[Values], share: float = 1.0) -> list[tuple[Compared, ...] | Failed]:
        """The same in a fraction of the time, to choose where to start, or of a ``share`` of that: its beginning, which
        tells roughly what the whole tells finely; may be `compared` itself, as where a test does not say."""
        return self.compared(batch)

    def found(self, values: Values) -> Mapping[str, Any]:
        """What else the test says at the end, for page and JSON (paired modes); usually nothing."""
        return {}
