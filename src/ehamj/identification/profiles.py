"""Profile likelihood of one value: how much worse the data fit where it is held elsewhere and all others follow.

A parabola where the deviation says it all (rise 1 at one deviation), flat where the data do not tell the value.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.fit import Fitted, errors, slopes
from ehamj.identification.problem import Linearised, Problem
from ehamj.identification.residual import Failed

WIDTHS: Final = (-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0)
"""Deviations from the value that was found."""
WITHIN: Final = 3.84
"""Rise within which a value goes with the data (95 %)."""
STEPS: Final = 4
"""In which the others follow, at most."""


def profile(problem: Problem, fit: Fitted, covariance: Array, k: int) -> Array:
    """Values of a parameter and the rise of −2·log likelihood there (priors among it), (n, 2).

    Args:
        problem: tests and unknowns.
        fit: where the fit ended.
        covariance: of the scaled unknowns, (k, k); others begin where it says that they go along.
        k: number of the parameter.
    """
    deviation, (low, high) = float(np.sqrt(covariance[k, k])), problem.unknowns[k].limits
    along, least = covariance[:, k] / covariance[k, k], _cost(problem, fit, fit.at)
    rows = []
    for width in WIDTHS:
        moved = float(np.clip(fit.point[k] + width * deviation, low, high))
        point = np.clip(fit.point + along * (moved - fit.point[k]), *problem.limits)
        point[k] = moved
        found = least if moved == fit.point[k] else _best(problem, fit, point, k)
        if np.isfinite(found):
            rows.append((problem.unknowns[k].value(moved), max(found - least, 0.0)))
    return np.array(sorted(set(rows))).reshape(-1, 2)


def interval(rows: Array) -> tuple[float | None, float | None]:
    """Ends of the 95 % interval of a profile (n, 2), rises between its points taken as parts of parabolas; None where
    it does not rise so far within what was looked at."""
    values, roots = rows[:, 0], np.sqrt(rows[:, 1])
    least = int(np.argmin(roots))
    return _crossing(values[least::-1], roots[least::-1]), _crossing(values[least:], roots[least:])


def _crossing(values: Array, roots: Array) -> float | None:
    """Where the root of the rise first reaches that of 95 %, outwards from its least."""
    limit = np.sqrt(WITHIN)
    beyond = np.flatnonzero(roots >= limit)
    if beyond.size == 0 or beyond[0] == 0:
        return None
    k = int(beyond[0])
    share = (limit - roots[k - 1]) / (roots[k] - roots[k - 1])
    return float(values[k - 1] + share * (values[k] - values[k - 1]))


def _best(problem: Problem, fit: Fitted, point: Array, k: int) -> float:
    """−2·log likelihood of the noise of the fit where one value is held; infinite where the model cannot be run."""
    from scipy.optimize import least_squares

    others: Sequence[int] = [j for j in range(len(point)) if j != k]
    known: dict[bytes, Linearised | Failed] = {}

    def at(part: Array) -> Linearised | Failed:
        if part.tobytes() not in known:
            whole = point.copy()
            whole[others] = part
            known[part.tobytes()] = problem.linearised(whole)
        return known[part.tobytes()]

    first = at(point[others])
    if isinstance(first, Failed) or not others:
        return np.inf if isinstance(first, Failed) else _cost(problem, fit, first)
    size = errors(first, fit.noise, problem.unknowns).size

    def error(part: Array) -> Array:
        found = at(part)
        if isinstance(found, Failed):
            return np.full(size, np.inf)
        return errors(found, fit.noise, problem.unknowns)

    def slope(part: Array) -> Array:
        found = at(part)
        assert isinstance(found, Linearised)
        return np.asarray(slopes(found, fit.noise, problem.unknowns)[:, others])

    limits = tuple(side[others] for side in problem.limits)
    inside = np.clip(point[others], np.nextafter(limits[0], np.inf), np.nextafter(limits[1], -np.inf))
    if inside.tobytes() not in known:
        first = at(inside)
        if isinstance(first, Failed):
            return np.inf
    fall = 1e-2 / max(_cost(problem, fit, first), 1.0)
    return 2.0 * float(least_squares(error, inside, slope, limits, ftol=fall, max_nfev=STEPS).cost)


def _cost(problem: Problem, fit: Fitted, at: Linearised) -> float:
    found = errors(at, fit.noise, problem.unknowns)
    return float(found @ found)
