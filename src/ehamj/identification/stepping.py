"""Whether the steps of runs are short enough: how far values would move with shorter ones, beside what is stated."""

from collections.abc import Iterator, Mapping
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.fit import Fitted
from ehamj.identification.outcome import Identified
from ehamj.identification.problem import Problem
from ehamj.identification.residual import Failed, real
from ehamj.identification.tests.timed import TimeResiduals

COUNTS: Final = 0.3
"""Of a value's deviation: a bias of it makes errors over deviations 1.04 times as large."""
REST: Final = 16.0 / 15.0
"""Error of a step over how much half of it changes, of a method of fourth order."""


def coarse(problem: Problem, fit: Fitted, found: Mapping[str, Identified]) -> Iterator[str]:
    """Notes on values that errors of integration move.

    Args:
        problem: fitted tests and unknowns.
        fit: where it ended.
        found: the parameters.
    """
    moved = moved_by_steps(problem, fit)
    shares = {}
    for one, own in zip(problem.parameters, moved, strict=False):
        known = found[one.name]
        if known.status == "identified" and known.value is not None and known.deviation:
            shares[one.name] = abs(own) * one.slope(known.value) / known.deviation
    key = max(shares, key=lambda name: shares[name], default="")
    if key and shares[key] > COUNTS:
        yield (
            f"errors of integration move {key} by {shares[key]:.2g} of its deviation: state a shorter timestep "
            "(set = { timestep = … }) where that matters"
        )


def moved_by_steps(problem: Problem, fit: Fitted) -> Array:
    """How far each scaled unknown is from where runs without errors of integration would have it, to first order, (k,);
    runs that fail at half the step, and tests that step nothing, say nothing."""
    values, pull = problem.values(fit.point), np.zeros(len(problem.unknowns))
    for test in problem.tests:
        near = test.finer(values) if isinstance(test, TimeResiduals) else None
        if near is None or isinstance(near, Failed):
            continue
        own = [k for k, name in enumerate(fit.at.tests) if name == test.name]
        for k, fine in zip(own, near, strict=True):
            off = REST * real(fit.at.compared[k].predicted - fine.predicted)
            pull -= fit.noise[k].whitened(fit.at.slopes[k]).T @ fit.noise[k].whitened(off)
    told = np.zeros(len(problem.unknowns))
    for k, one in enumerate(problem.unknowns):
        if one.prior is not None:
            told[k] = (one.slope(one.value(float(fit.point[k]))) / one.prior.deviation) ** 2
    white = [of.whitened(slope) for of, slope in zip(fit.noise, fit.at.slopes, strict=True)]
    known = np.diag(told) + sum(slope.T @ slope for slope in white)
    size = np.sqrt(np.where(np.diag(known) > 0.0, np.diag(known), 1.0))
    return np.asarray(np.linalg.pinv(known / np.outer(size, size), rcond=1e-13, hermitian=True) @ (pull / size) / size)
