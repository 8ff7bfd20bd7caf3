"""Fisher information: what a test tells of the unknowns, and what is known after several of them.

Everything is in the unknowns as a fit has them, of order one (`ehamj.identification.unknowns.Unknown`). A test whose
errors are white and of unit variance after whitening tells JᵀJ, with J the derivatives of its whitened outputs; what
tests and priors tell adds up, and its inverse is the covariance that no unbiased fit goes below (Cramér and Rao).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
import scipy

from ehamj.arrays import Array

Criterion = Literal["d", "a"]
"""Volume of the uncertainty's ellipsoid; sum of the squared deviations, each over what it was."""

TOLD: Final = 2.0
"""Factor by which a test must sharpen a parameter to be said to tell it."""
REMOVED: Final = 1e-12
"""Share of the largest information on a test's own unknowns below which one of them is not told at all."""


def without(information: Array, kept: int) -> Array:
    """What is left for the first ``kept`` unknowns when the others, a test's own, are fitted beside them, (k, k).

    The Schur complement: what of the outputs' derivatives is no combination of the nuisances' ones.
    """
    own = information[kept:, kept:]
    if not own.size or not own.any():
        return information[:kept, :kept]
    scale = np.sqrt(np.maximum(np.diagonal(own), REMOVED * np.diagonal(own).max()))
    inverse = np.linalg.pinv(own / np.outer(scale, scale), rcond=REMOVED, hermitian=True) / np.outer(scale, scale)
    return np.asarray(information[:kept, :kept] - information[:kept, kept:] @ inverse @ information[kept:, :kept])


@dataclass(frozen=True)
class Knowledge:
    """Information on k unknowns, (k, k), positive definite: of priors, and of tests."""

    information: Array

    @classmethod
    def before(cls, spreads: Array) -> "Knowledge":
        """Of independent unknowns with these standard deviations, (k,)."""
        return cls(np.diag(1.0 / np.asarray(spreads, float) ** 2))

    def after(self, *tests: Array) -> "Knowledge":
        """With what tests tell beside it, (k, k) each."""
        return Knowledge(self.information + sum(tests, np.zeros_like(self.information)))

    @property
    def covariance(self) -> Array:
        """(k, k)."""
        return np.asarray(scipy.linalg.inv(self._scaled) / np.outer(self._sizes, self._sizes))

    @property
    def deviations(self) -> Array:
        """Standard deviation of each unknown, the others unknown too, (k,)."""
        return np.asarray(np.sqrt(np.diagonal(self.covariance)))

    @property
    def _sizes(self) -> Array:
        return np.asarray(np.sqrt(np.diagonal(self.information)))

    @property
    def _scaled(self) -> Array:
        return np.asarray(self.information / np.outer(self._sizes, self._sizes))

    def cost(self, criterion: Criterion, of: Sequence[int], spreads: Array) -> float:
        """What a best test makes smallest, of some unknowns, the others fitted beside them.

        ``d``: logarithm of their ellipsoid's volume, per unknown; ``a``: mean of (deviation/spread)², with the
        ``spreads`` (k,) before all tests.
        """
        covariance = self.covariance[np.ix_(of, of)]
        own = spreads[list(of)]
        if criterion == "a":
            return float(np.mean(np.diagonal(covariance) / own**2))
        return float(0.5 * np.linalg.slogdet(covariance / np.outer(own, own))[1]) / len(of)


def best_sequence(
    known: Knowledge, tests: Sequence[Array], cost: Callable[[Knowledge], float], longest: int, least: float
) -> list[int]:
    """Numbers of the tests that lower a cost fastest, one after the other; one may come again.

    Greedy: what is told adds up, so that the best next test after any others is at most as good as alone, and a
    sequence found so is for ``d`` within 1 − 1/e of the best one of its length (Nemhauser, Wolsey & Fisher 1978).

    Args:
        known: before.
        tests: information of each, (k, k).
        cost: of what is known.
        longest: tests at most.
        least: by how much a further test must lower the cost.
    """
    chosen: list[int] = []
    while len(chosen) < longest and tests:
        costs = [cost(known.after(test)) for test in tests]
        best = int(np.argmin(costs))
        if not cost(known) - costs[best] > least:
            break
        chosen.append(best)
        known = known.after(tests[best])
    return chosen
