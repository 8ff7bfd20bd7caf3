"""The swings of a motion: its largest values between zero crossings, and how fast each was.

Norms that limit a peak by its frequency need both. The frequency of a swing is that of the half period between the zero
crossings around it, one of the two methods that DIN 4150-3 has for it; the other, the spectrum of the whole event,
knows one frequency only. Where an end of the record cuts a swing, the time from its one crossing to its largest value
counts as a quarter period.
"""

from typing import NamedTuple, Self

import numpy as np

from ehamj.arrays import Array

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
        parts = [_of_one(column, rate) for column in np.asarray(motion, float).reshape(len(motion), -1).T]
        return cls(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def _of_one(motion: Array, rate: float) -> tuple[Array, Array]:
    if not motion.size:
        return np.empty(0), np.empty(0)
    up = motion >= 0.0
    before = np.flatnonzero(up[1:] != up[:-1])  # last sample before each crossing
    peak = np.maximum.reduceat(np.abs(motion), np.concatenate([[0], before + 1]))
    if not before.size:
        return peak, np.array([np.nan])
    crossing = before + motion[before] / (motion[before] - motion[before + 1])
    first, last = np.abs(motion[: before[0] + 1]), np.abs(motion[before[-1] + 1 :])
    cut = 2.0 * (crossing[0] - np.argmax(first)), 2.0 * (before[-1] + 1 + np.argmax(last) - crossing[-1])
    half = np.concatenate([cut[:1], np.diff(crossing), cut[1:]]) / rate
    return peak, 0.5 / np.maximum(half, SHORTEST)
