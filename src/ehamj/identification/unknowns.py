"""What a fit looks for: parameters of the scenario by key, and each test's own unknowns (offsets, gains, delays)."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

Values = Mapping[str, float]
"""A point: the value of every parameter by the scenario's key, and of tests' own unknowns by their names; SI."""

SPAN: Final = 2.0
"""Ratio of the bounds from which a positive parameter is looked for by its logarithm."""


@dataclass(frozen=True)
class Prior:
    """What is known of a value before the tests: normal about a ``mean``, with a standard ``deviation``."""

    mean: float
    deviation: float


@dataclass(frozen=True)
class Unknown:
    """One unknown: a parameter (``test`` is None), or one of a ``test``'s own, which is fitted beside them
    (a nuisance). Bounds may be infinite for those of a test, not for parameters."""

    name: str
    unit: str
    start: float
    low: float
    high: float
    prior: Prior | None = None
    test: str | None = None
    size: float = 0.0
    """Change that matters, in ``unit``; 0: a quarter of the bounds' distance."""
    closed: bool = False
    """Whether the test gives the prediction's derivative in it (`ehamj.identification.residual.Compared.slopes`), so
    that it is not differenced."""

    @property
    def log(self) -> bool:
        """Whether it is looked for by its logarithm."""
        return self.low > 0.0 and self.high / self.low >= SPAN and math.isfinite(self.high)

    @property
    def level(self) -> bool:
        """Whether it is a channel's offset, of which predictions are a linear function without bounds."""
        return self.closed and self.prior is None and not math.isfinite(self.high - self.low)

    @property
    def scale(self) -> float:
        """What one unit of the scaled unknown is, in ``unit`` (of the logarithm: 1)."""
        if self.log:
            return 1.0
        return self.size or 0.25 * (self.high - self.low)

    def scaled(self, value: float) -> float:
        """A value as the fit has it, of order one; 0 at the start."""
        return math.log(value / self.start) if self.log else (value - self.start) / self.scale

    def value(self, scaled: float) -> float:
        """Back, within the bounds."""
        found = self.start * math.exp(scaled) if self.log else self.start + self.scale * scaled
        return float(np.clip(found, self.low, self.high))

    def slope(self, value: float) -> float:
        """Derivative of the value in the scaled unknown."""
        return value if self.log else self.scale

    @property
    def held_near_start(self) -> "Unknown":
        """The same, with its bounds as what is known before, where nothing else is."""
        spread = (self.high - self.low) / math.sqrt(12.0)
        if self.prior is not None or not math.isfinite(spread):
            return self
        return replace(self, prior=Prior(self.start, spread))

    @property
    def limits(self) -> tuple[float, float]:
        """Bounds of the scaled unknown."""
        if self.log:
            return self.scaled(self.low), self.scaled(self.high)
        return (self.low - self.start) / self.scale, (self.high - self.start) / self.scale
