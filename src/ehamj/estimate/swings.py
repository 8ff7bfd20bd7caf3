"""The swings of a motion: its largest values between zero crossings, and how fast each was.

Norms that limit a peak by its frequency need both. The frequency of a swing is that of the half period between the zero
crossings around it, one of the two methods that DIN 4150-3 has for it; the other, the spectrum of the whole event,
knows one frequency only. Where an end of the record cuts a swing, the time from its one crossing to its largest value
counts as a quarter period.
"""

from collections.abc import Iterable
from typing import NamedTuple, Self

import numpy as np

from ehamj.arrays import Array
from ehamj.columns import columns

SHORTEST = 1e-9
"""Least time between two crossings [s], so that none is infinitely fast."""


class Swings(NamedTuple):
    """Swings of one motion, or of several together."""

    peak: Array
    """Largest absolute value of each (swings,), in the motion's unit."""
    frequency: Array
    """Of each [Hz], (swings,); NaN where a motion never crosses zero."""

    @classmethod
    def of(cls, motion: Array, rate: float) -> Self:
        """Swings of samples at a rate.

        Args:
            motion: (n,), or (n, motions), whose swings are taken together.
            rate: sampling rate [Hz].
        """
        return cls.together(cls(*_of_one(one, rate)) for one in columns(motion))

    @classmethod
    def together(cls, parts: "Iterable[Swings]") -> Self:
        """All swings of several."""
        return cls(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def _of_one(motion: Array, rate: float) -> tuple[Array, Array]:
    if not motion.any():
        return np.zeros(min(motion.size, 1)), np.full(min(motion.size, 1), np.nan)
    sign, size = np.sign(motion), np.abs(motion)
    edges = np.flatnonzero(sign[1:] != sign[:-1]) + 1
    starts, stops = np.concatenate([[0], edges]), np.concatenate([edges, [motion.size]])
    peak, moves = np.maximum.reduceat(size, starts), sign[starts] != 0.0  # rest is no swing
    # Where the sign changes the motion crosses zero between two samples, or at one of them.
    crossing = edges - 1 + motion[edges - 1] / (motion[edges - 1] - motion[edges])
    begin, end = np.concatenate([[np.nan], crossing]), np.concatenate([crossing, [np.nan]])
    if np.isfinite(end[0]):
        begin[0] = 2.0 * np.argmax(size[: stops[0]]) - end[0]
    if np.isfinite(begin[-1]):
        end[-1] = 2.0 * (starts[-1] + np.argmax(size[starts[-1] :])) - begin[-1]
    half = (end - begin)[moves] / rate
    return peak[moves], 0.5 / np.maximum(half, SHORTEST)
