"""What drawn designs tell by regression: standardised coefficients, and a quadratic surface that predicts a merit."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.errors import InputError

CONFIDENCE: Final = 0.95


@dataclass(frozen=True)
class Regression:
    """A merit as a sum of parameters, all in their standard deviations."""

    keys: tuple[str, ...]
    coefficients: Array
    """Deviations of the merit by one of the parameter (parameter,) [-]."""
    reach: Array
    """Half the width of their 95 % intervals (parameter,) [-]."""
    explained: float
    """R²: share of the variance that the sum explains [-]; where it is low, the coefficients say little."""
    used: int
    """Designs that have the merit."""


@dataclass(frozen=True)
class Surface:
    """A merit as a quadratic polynomial of parameters, by least squares."""

    keys: tuple[str, ...]
    middle: Array
    """Mean of each parameter over the designs (parameter,), in its unit."""
    width: Array
    """Standard deviation of each (parameter,), in its unit."""
    coefficients: Array
    """Of the terms (term,), in the merit's unit: 1, z_i, z_i z_j with i ≤ j; z in deviations from the mean."""
    explained: float
    """R²: share of the variance that it explains of the designs that it was made of [-]."""
    predicted: float
    """The same of designs that it was not made of, each left out in turn (Q², by PRESS) [-]; below 0 it is worse than
    the mean."""
    error: float
    """Root mean square of what each design is off when it is left out, in the merit's unit."""
    used: int
    """Designs that have the merit."""

    def at(self, values: Array) -> Array:
        """The merit at values (…, parameter), in its unit."""
        scores = (np.asarray(values, float) - self.middle) / self.width
        return np.asarray(_terms(scores.reshape(-1, len(self.keys))) @ self.coefficients).reshape(scores.shape[:-1])


def regression(keys: Sequence[str], values: Array, merit: Array) -> Regression:
    """Standardised regression coefficients (SRC), with the intervals of ordinary least squares.

    Args:
        keys: parameters whose values are numbers.
        values: of designs (design, parameter).
        merit: of each (design,), NaN where it has none.

    Raises:
        InputError: if a parameter, or the merit, is the same in all designs, or there are too few of them.
    """
    from scipy.stats import t

    scores, target, deviation = _scores(keys, values, merit, len(keys) + 2)
    target = target / deviation
    coefficients = np.asarray(np.linalg.lstsq(scores, target, rcond=None)[0], float)
    rest = target - scores @ coefficients
    freedom = len(target) - len(keys) - 1
    spread = np.sqrt(rest @ rest / freedom * np.diag(np.linalg.pinv(scores.T @ scores)))
    reach: Array = t.ppf(0.5 + CONFIDENCE / 2, freedom) * spread
    return Regression(tuple(keys), coefficients, reach, _share(rest, target), len(target))


def response_surface(keys: Sequence[str], values: Array, merit: Array) -> Surface:
    """A quadratic surface, and how well it predicts.

    Args:
        keys: parameters whose values are numbers.
        values: of designs (design, parameter).
        merit: of each (design,), NaN where it has none.

    Raises:
        InputError: as `regression`; there must be more designs than terms, 1 + k + k (k + 1)/2.
    """
    count = 1 + len(keys) + len(keys) * (len(keys) + 1) // 2
    scores, target, _ = _scores(keys, values, merit, count + 1)
    known = np.isfinite(merit)
    terms = _terms(scores)
    left, sizes, right = np.linalg.svd(terms, full_matrices=False)
    kept = sizes > sizes[0] * len(target) * np.finfo(float).eps  # two values of a parameter leave its square no say
    left, sizes, right = left[:, kept], sizes[kept], right[kept]
    shift = np.asarray(merit, float)[known].mean()
    coefficients = right.T @ ((left.T @ target) / sizes)
    rest = target - terms @ coefficients
    with np.errstate(divide="ignore", invalid="ignore"):
        without = rest / (1.0 - (left**2).sum(axis=1))  # of a fit without this design
    without = np.where(np.isfinite(without), without, 0.0)
    coefficients[0] += shift
    middle, width = np.asarray(values, float)[known].mean(axis=0), np.asarray(values, float)[known].std(axis=0)
    quality = (_share(rest, target), _share(without, target), float(np.sqrt(np.mean(without**2))))
    return Surface(tuple(keys), middle, width, coefficients, *quality, len(target))


def _terms(scores: Array) -> Array:
    """1, z_i, z_i z_j of designs (design, term)."""
    count = scores.shape[1]
    pairs = [scores[:, i] * scores[:, j] for i, j in combinations_with_replacement(range(count), 2)]
    return np.column_stack([np.ones(len(scores)), scores, *pairs])


def _scores(keys: Sequence[str], values: Array, merit: Array, fewest: int) -> tuple[Array, Array, float]:
    """Parameters in deviations from their means (design, parameter), the merit about its mean, and its deviation."""
    values, merit = np.asarray(values, float), np.asarray(merit, float)
    known: NDArray[np.bool_] = np.isfinite(merit)
    if known.sum() < fewest:
        raise InputError(f"{int(known.sum())} designs have the merit; at least {fewest} are needed")
    values, merit = values[known], merit[known]
    for name, column in [*zip(keys, values.T, strict=True), ("the merit", merit)]:
        if not np.ptp(column) > 0.0:
            raise InputError(f"{name} is {column[0]:g} in all designs; leave it out")
    return (values - values.mean(axis=0)) / values.std(axis=0), merit - merit.mean(), float(merit.std())


def _share(rest: Array, target: Array) -> float:
    return float(1.0 - rest @ rest / (target @ target))
