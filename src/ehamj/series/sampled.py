"""A signal through samples."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.series.held import BLOCK, Held, Recent, is_whole
from ehamj.signals import Sample

DEGREE: Final = 5
"""Degree of the spline through samples."""

MARGIN: Final = 64
"""Samples beside a block that its spline goes through as well: it forgets its ends by 0.43 per sample."""


@dataclass(frozen=True)
class Sampled:
    """A quintic spline through uniform samples, so that its two derivatives belong to it exactly.

    ``values`` (n,) at ``start`` + k/``rate``; the samples should be at least four times as dense as the highest
    frequency needs. Outside the samples the first and last value hold. The spline of many is made a block at a time.
    """

    rate: float
    values: Held[np.float64] = field(repr=False)
    start: float = 0.0

    @cached_property
    def _blocks(self) -> "Recent[tuple[int, Array, Array]]":
        return Recent(self._block)

    @property
    def _span(self) -> int:
        return self.values.size if is_whole(self.values.size) else BLOCK // 4  # coefficients are many

    def _block(self, number: int) -> tuple[int, Array, Array]:
        """First sample of a block's spline, its breaks and coefficients."""
        first = max(0, number * self._span - MARGIN)
        values = self.values[first : (number + 1) * self._span + MARGIN]
        times = self.start + np.arange(first, first + values.size) / self.rate
        spline = scipy.interpolate.PPoly.from_spline(scipy.interpolate.make_interp_spline(times, values, k=DEGREE))
        return first, spline.x, spline.c

    def sample(self, time: Array, left: bool = False) -> Sample:
        end = self.start + (self.values.size - 1) / self.rate
        inside = (time >= self.start) & (time <= end)
        clipped = np.clip(time, self.start, end)
        sample = ((clipped - self.start) * self.rate).astype(np.int64)
        found = np.empty((3, time.size))
        blocks = sample // self._span
        for number in np.unique(blocks):
            here = blocks == number
            found[:, here] = self._in_block(int(number), sample[here], clipped[here])
        return Sample(found[0], np.where(inside, found[1], 0.0), np.where(inside, found[2], 0.0))

    def _in_block(self, number: int, sample: NDArray[np.int64], time: Array) -> tuple[Array, Array, Array]:
        # All three at once from the pieces' coefficients: several times faster than a spline evaluated thrice.
        first, breaks, coefficients = self._blocks[number]
        # Knots are the samples but for the second, third and their like at the end, with five empty pieces at each end.
        piece = np.clip(sample - first + DEGREE - 2, DEGREE, breaks.size - DEGREE - 2)
        s = time - breaks[piece]
        a, b, c, d, e, f = coefficients[:, piece]
        return (
            ((((a * s + b) * s + c) * s + d) * s + e) * s + f,
            (((5.0 * a * s + 4.0 * b) * s + 3.0 * c) * s + 2.0 * d) * s + e,
            ((20.0 * a * s + 12.0 * b) * s + 6.0 * c) * s + 2.0 * d,
        )
