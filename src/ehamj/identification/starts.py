"""Where a fit begins: points within the bounds, ranked by a part of the data, the best of them polished there."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.file import FitSettings
from ehamj.identification.fit import Fitted, Told, fitted
from ehamj.identification.problem import Problem
from ehamj.identification.residual import Compared, Failed, real

DRAWN: Final = 8
"""Points that are drawn for each start that is polished."""
LADDER: Final = (1 / 16, 1 / 4)
"""Shares of the beginnings of records that are fitted one after the other."""
CLIMBED: Final = 6
"""Steps on each of them, at most."""
POLISHED: Final = 12
"""Steps of the part of the data that a start takes, at most."""


@dataclass(frozen=True)
class Starts:
    """Scaled unknowns, the most promising first, and what each cost on a part of the data."""

    points: list[Array]
    costs: list[float]
    runs: int


def begun(problem: Problem, settings: FitSettings, told: Told) -> Starts:
    """Where to begin.

    Args:
        problem: tests and unknowns.
        settings: how many starts.
        told: called with what is done.
    """
    rough = Problem(problem.tests, problem.parameters, 1.0, problem.held)
    if settings.starts == 1:
        points = _climbed(problem, problem.start, told)
        costs = [_misfit(one, problem) for one in rough.compared(points)]
        order = np.argsort(costs, kind="stable").tolist()
        return Starts([points[k] for k in order], [costs[k] for k in order], rough.runs)
    told(f"ranking {DRAWN * settings.starts} starts")
    drawn = [problem.start, *_drawn(problem, DRAWN * settings.starts, settings.seed)]
    ranked = [_misfit(one, problem) for one in rough.compared(drawn)]
    order = [0, *(k for k in np.argsort(ranked, kind="stable").tolist() if k != 0 and np.isfinite(ranked[k]))]
    polished: list[tuple[float, Array]] = []
    for number, k in enumerate(order[: settings.starts], 1):
        told(f"start {number} of {settings.starts}")
        for point in _climbed(problem, drawn[k], told)[:1]:
            found = fitted(rough, point, POLISHED, coloured=False, roughly=True)
            if isinstance(found, Fitted):
                polished.append((found.cost, found.point))
    polished.sort(key=lambda one: one[0])
    points = [point for _, point in polished]
    return Starts([*points, problem.start], [cost for cost, _ in polished], rough.runs)


def _climbed(problem: Problem, point: Array, told: Told) -> list[Array]:
    """Where fits of ever longer beginnings end, the longest first, and at last the point itself: over the whole of a
    record, motions of little damping that are a period off look no better a little nearer; over its beginning they do.
    """
    last, size = point, 0
    (at,) = Problem(problem.tests, problem.parameters, 1.0, problem.held).compared([point])
    whole = 0 if isinstance(at, Failed) else sum(one.error.size for one in at)
    for share in LADDER:
        part = Problem(problem.tests, problem.parameters, share, problem.held)
        (at,) = part.compared([last])
        if isinstance(at, Failed) or not size < (samples := sum(one.error.size for one in at)) < whole:
            continue  # it says nothing that was not said, or all there is
        told(f"beginnings, {100 * share:g} %")
        found, size = fitted(part, last, CLIMBED, coloured=False, roughly=True), samples
        last = found.point if isinstance(found, Fitted) else last
    return [last, point]


def _drawn(problem: Problem, number: int, seed: int) -> list[Array]:
    """Points that fill the bounds evenly (Sobol); the tests' own unknowns stay at their start."""
    from scipy.stats.qmc import Sobol

    count = len(problem.parameters)
    low, high = (side[:count] for side in problem.limits)
    shares = Sobol(count, rng=np.random.default_rng(seed)).random(number)
    rest = problem.start[count:]
    return [np.concatenate([low + share * (high - low), rest]) for share in shares]


def _misfit(found: tuple[Compared, ...] | Failed, problem: Problem) -> float:
    """What the data cost at a point, offsets and the like fitted; each channel by its size."""
    if isinstance(found, Failed):
        return float("inf")
    total = 0.0
    for one in found:
        error = one.error
        if one.slopes:
            own = np.column_stack([real(slope) for slope in one.slopes.values()])
            error = error - own @ np.linalg.lstsq(own, error, rcond=None)[0]
        stated = ~np.isnan(one.deviation).any()
        size = np.tile(one.deviation, error.size // len(one.at)) if stated else 1.0
        total += error.size * float(np.log(np.mean((error / size) ** 2) + 1e-30))
    return total
