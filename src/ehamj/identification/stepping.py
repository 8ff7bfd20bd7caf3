"""Steps of the runs that are short enough: how far values move with shorter ones, beside their deviations.

Many steps of many runs are taken on the way; what is left of errors of integration is taken out at the end, by single
runs of shorter steps, as far as it moves values at all.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.fit import Fitted, Told, cost_of
from ehamj.identification.problem import Problem
from ehamj.identification.residual import Compared, Failed
from ehamj.identification.tests.timed import TimeResiduals

COUNTS: Final = 0.3
"""Of a value's deviation, from which a note tells of it: errors over deviations are 1.04 times as large then."""
ENOUGH: Final = 0.1
"""Of a value's deviation, up to which steps are short enough."""
FIRST, LAST = 4, 16
"""Steps in one: with which it is asked, and the most that are taken. Where valves have a hysteresis or an overlap,
errors fall as the square of the step, else as its fourth power."""
ROUNDS: Final = 5
"""Corrections, at most, of which each leaves a few hundredths of the one before."""
STAYS: Final = 0.03
"""Correction over the deviation at which values stay."""


def short_enough(problem: Problem, fit: Fitted, told: Told) -> Fitted:
    """The fit with shorter steps, where these move a value and the scenario does not state its own; else itself."""
    if any(isinstance(test, TimeResiduals) and test.stated for test in problem.tests):
        return fit
    shares = moved_by_steps(problem, fit)
    worst = float(np.abs(shares).max(initial=0.0))
    if worst <= ENOUGH:
        return fit
    factor = FIRST if worst / FIRST**2 <= ENOUGH else LAST
    told(f"shorter steps, {factor} in one")
    spread, inverse = _spread(problem, fit)
    low, high = problem.limits
    point, compared = fit.point, fit.at.compared
    for _ in range(ROUNDS):
        near = _finer(problem, point, factor)
        if near is None:
            return fit
        step = np.clip(point + inverse @ _pull(problem, fit, point, near), low, high) - point
        point = point + step
        compared = tuple(
            replace(one, predicted=one.predicted + _complex(slope @ step, one))
            for one, slope in zip(near, fit.at.slopes, strict=True)
        )
        if float(np.abs(step / spread)[: len(problem.parameters)].max()) < STAYS:
            break
    at = replace(fit.at, point=point, compared=compared)
    return replace(fit, at=at, cost=cost_of(compared, fit.noise))


def coarse(problem: Problem, fit: Fitted) -> Iterator[str]:
    """Notes on values that errors of integration move, where the scenario states its step."""
    if not any(isinstance(test, TimeResiduals) and test.stated for test in problem.tests):
        return
    shares = np.abs(moved_by_steps(problem, fit))
    worst = int(np.argmax(shares))
    if shares[worst] > COUNTS:
        yield (
            f"errors of integration move {problem.parameters[worst].name} by {shares[worst]:.2g} of its deviation: "
            "state a shorter timestep, or none, so that it is chosen"
        )


def moved_by_steps(problem: Problem, fit: Fitted) -> Array:
    """How far each parameter is from where runs of shorter steps would have it, to first order, over its deviation,
    (k,); runs that fail then, and tests that step nothing, say nothing."""
    near = _finer(problem, fit.point, FIRST)
    if near is None:
        return np.zeros(len(problem.parameters))
    spread, inverse = _spread(problem, fit)
    pull = np.zeros(len(problem.unknowns))
    for one, fine, noise, slope in zip(fit.at.compared, near, fit.noise, fit.at.slopes, strict=True):
        off = noise.whitened(replace(one, predicted=fine.predicted).error - one.error)
        pull -= noise.whitened(slope).T @ off
    return np.asarray((inverse @ pull / spread)[: len(problem.parameters)])


def _finer(problem: Problem, point: Array, factor: int) -> tuple[Compared, ...] | None:
    """All channels at a point, of runs with so many steps in one; of tests that step nothing as they are there."""
    values = problem.values(point)
    found: list[Compared] = []
    for test in problem.tests:
        at = test.finer(values, factor) if isinstance(test, TimeResiduals) else test.compared([values])[0]
        if isinstance(at, Failed):
            return None
        found += at
    return tuple(found)


def _pull(problem: Problem, fit: Fitted, point: Array, at: Sequence[Compared]) -> Array:
    """Slope of the log likelihood at a point, what was known before with it, (k,)."""
    pull = np.zeros(len(problem.unknowns))
    for one, noise, slope in zip(at, fit.noise, fit.at.slopes, strict=True):
        pull += noise.whitened(slope).T @ noise.whitened(one.error)
    for k, unknown in enumerate(problem.unknowns):
        if unknown.prior is not None:
            value = unknown.value(float(point[k]))
            pull[k] += (unknown.prior.mean - value) / unknown.prior.deviation**2 * unknown.slope(value)
    return pull


def _spread(problem: Problem, fit: Fitted) -> tuple[Array, Array]:
    """Standard deviation of each scaled unknown, (k,), and their covariance, (k, k), what was known before with it."""
    white = [noise.whitened(slope) for noise, slope in zip(fit.noise, fit.at.slopes, strict=True)]
    known = np.asarray(sum(slope.T @ slope for slope in white))
    for k, one in enumerate(problem.unknowns):
        if one.prior is not None:
            known[k, k] += (one.slope(one.value(float(fit.point[k]))) / one.prior.deviation) ** 2
    size = np.sqrt(np.where(np.diag(known) > 0.0, np.diag(known), 1.0))
    inverse = np.linalg.pinv(known / np.outer(size, size), rcond=1e-13, hermitian=True) / np.outer(size, size)
    return np.sqrt(np.maximum(np.diag(inverse), 1e-300)), inverse


def _complex(change: Array, one: Compared) -> Array:
    """Real numbers of a change as the channel has them (`ehamj.identification.residual.real`)."""
    if not np.iscomplexobj(one.predicted):
        return change
    half = change.size // 2
    return np.asarray(change[:half] + 1j * change[half:])
