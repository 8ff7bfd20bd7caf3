"""Which designs are best: the one objective's best, or of the Pareto front those that are nearest to the best of all."""

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.campaign.studied import Studied


def front_of(objectives: Array) -> NDArray[np.bool_]:
    """Which designs no other one beats: none is as good in every objective and better in one.

    Args:
        objectives: (design, objective), all to be small; a design with NaN is on no front.
    """
    on_front = np.isfinite(objectives).all(axis=1)
    left = np.flatnonzero(on_front)
    left = left[np.lexsort(objectives[left].T[::-1])]
    kept: list[int] = []
    while left.size:
        first, rest = left[0], left[1:]
        kept.append(int(first))  # what beats a design stands before it
        beaten = (objectives[rest] >= objectives[first]).all(axis=1) & (objectives[rest] > objectives[first]).any(axis=1)
        left = rest[~beaten]
    found = np.zeros(len(objectives), bool)
    found[kept] = True
    return found


def ranked(objectives: Array) -> NDArray[np.int_]:
    """Designs of the front, the best first: nearest to the best value of every objective at once, each counted in
    shares of its range over the front. Equal ones stand in order of their numbers."""
    rows = np.flatnonzero(front_of(objectives))
    on_front = objectives[rows]
    if on_front.shape[1] == 1 or not rows.size:
        return rows
    low, reach = on_front.min(axis=0), np.ptp(on_front, axis=0)
    far = np.linalg.norm((on_front - low) / np.where(reach > 0.0, reach, 1.0), axis=1)
    return np.asarray(rows[np.argsort(far, kind="stable")])


def best_rows(studied: Studied) -> list[int]:
    """Rows of `Studied.search` of the best designs that keep all limits, the best first; none without objectives."""
    if not studied.file.objectives or studied.search.empty:
        return []
    objectives = studied.objectives(studied.search)
    objectives[~studied.good(studied.search)] = np.nan
    if objectives.shape[1] == 1:
        order = np.argsort(objectives[:, 0], kind="stable")  # NaN last
        return [int(row) for row in order[: studied.file.best] if np.isfinite(objectives[row, 0])]
    return [int(row) for row in ranked(objectives)[: studied.file.best]]


def front_rows(studied: Studied) -> list[int]:
    """Rows of `Studied.search` on the Pareto front of the designs that keep all limits, by the first objective."""
    if len(studied.file.objectives) < 2 or studied.search.empty:
        return []
    objectives = studied.objectives(studied.search)
    objectives[~studied.good(studied.search)] = np.nan
    rows = np.flatnonzero(front_of(objectives))
    return [int(row) for row in rows[np.argsort(objectives[rows, 0], kind="stable")]]
