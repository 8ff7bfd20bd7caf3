"""A periodic signal made of lines."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ehamj.arrays import Array
from ehamj.series.grid import Grid
from ehamj.series.held import Held
from ehamj.signals import Sample


@dataclass(frozen=True)
class Lines:
    """A periodic signal, the real part of Σ ``lines``[k]·exp(2πi k t/``period``), k = 0, 1, …

    The sum and its two derivatives are known on a grid of `ehamj.series.grid.LINE_SAMPLES` per period of the highest
    line; the quintic that takes all six values at the two ends of a step lies between, so that the derivatives belong
    to the value exactly.
    """

    period: float
    """[s]"""
    lines: Held[np.complex128] = field(repr=False)
    """Complex amplitudes, shape (n,)."""

    @cached_property
    def _grid(self) -> Grid:
        return Grid(self.lines)

    def sample(self, time: Array, left: bool = False) -> Sample:
        rate = self._grid.size / self.period
        steps = time * rate
        whole = np.floor(steps)
        s = steps - whole
        (a, b, c), (value, slope, curvature) = self._grid.ends(whole.astype(np.int64) % self._grid.size)
        c = 0.5 * c
        # What is left at the other end after the parabola a + b s + c s², for the terms of third to fifth order.
        value = value - (a + b + c)
        slope = slope - (b + 2.0 * c)
        curvature = 0.5 * curvature - c
        d = 10.0 * value - 4.0 * slope + curvature
        e = -15.0 * value + 7.0 * slope - 2.0 * curvature
        f = 6.0 * value - 3.0 * slope + curvature
        return Sample(
            ((((f * s + e) * s + d) * s + c) * s + b) * s + a,
            ((((5.0 * f * s + 4.0 * e) * s + 3.0 * d) * s + 2.0 * c) * s + b) * rate,
            (((20.0 * f * s + 12.0 * e) * s + 6.0 * d) * s + 2.0 * c) * rate**2,
        )
