"""Which measured mode is which computed one: by likeness of shape and frequency, all of them at once."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from ehamj.arrays import Array

LEAST = 0.1
"""Likeness below which two modes are not the same."""
NOTHING = 1e-12
"""Likeness that stands for none."""


def likeness(alike: Array, found: Array, computed: Array, near: float) -> Array:
    """How likely each found mode is each computed one, (k, m), from 0 to 1: MAC · exp(−(ln f/f')²/near²).

    Args:
        alike: MAC of their shapes, (k, m).
        found: frequencies (k,) [Hz].
        computed: frequencies (m,) [Hz].
        near: relative distance in frequency at which it becomes unlikely [-].
    """
    apart = np.log(np.asarray(found, float)[:, None] / np.asarray(computed, float)).reshape(alike.shape)
    return np.asarray(alike * np.exp(-((apart / near) ** 2)))


def likely_pairs(like: Array) -> dict[int, int]:
    """Computed mode of each found one, so that the sum of the likeness (k, m) is greatest; those below `LEAST` have
    none."""
    pairs = zip(*linear_sum_assignment(-like), strict=True)
    return {int(row): int(column) for row, column in pairs if like[row, column] > LEAST}


def best_pairs(like: Array, count: int) -> dict[int, int]:
    """Those ``count`` pairs, at most min(k, m), of which the product of the likeness (k, m) is greatest.

    Rows and columns that are left over go to one another's stand-ins, which cost nothing.
    """
    k, m = like.shape
    cost = np.zeros((k + m - count, m + k - count))
    cost[:k, :m] = -np.log(np.maximum(like, NOTHING))
    cost[k:, m:] = np.inf  # stand-ins do not pair with each other
    rows, columns = linear_sum_assignment(cost)
    return {int(row): int(column) for row, column in zip(rows, columns, strict=True) if row < k and column < m}
