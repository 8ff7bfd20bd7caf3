"""Which designs are best: by the one objective, or of the Pareto front those that are nearest to the best of all, first
of those that lose nothing beside designs with a name.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array

ENDLESS: Final = 1e15
"""What an objective without end counts as, such as the margin of a loop that never crosses."""


def front_of(objectives: Array) -> NDArray[np.bool_]:
    """Which designs no other one beats: none is as good in every objective and better in one.

    Args:
        objectives: (design, objective), all to be small; a design with NaN is on no front.
    """
    on_front = ~np.isnan(objectives).any(axis=1)
    left = np.flatnonzero(on_front)
    left = left[np.lexsort(objectives[left].T[::-1])]
    kept: list[int] = []
    while left.size:
        first, rest = left[0], left[1:]
        kept.append(int(first))  # what beats a design stands before it
        beaten = (objectives[rest] >= objectives[first]).all(axis=1) & (objectives[rest] > objectives[first]).any(
            axis=1
        )
        left = rest[~beaten]
    found = np.zeros(len(objectives), bool)
    found[kept] = True
    return found


def losing_nothing(objectives: Array, named: Array) -> NDArray[np.bool_]:
    """Which designs are worse in no objective than any of those with a name, (named, objective); one that failed counts
    for nothing, and where none is left no design is told."""
    known = named[~np.isnan(named).any(axis=1)]
    if not len(known):
        return np.zeros(len(objectives), bool)
    return np.asarray((objectives[:, None, :] <= known).all(axis=(1, 2)))


def best_of(objectives: Array, good: NDArray[np.bool_], most: int, named: Array | None = None) -> list[int]:
    """Rows of at most so many designs, the best first: by the one objective, or of the Pareto front those that are
    nearest to the best value of every objective at once, each counted in shares of its range over the front. Equal
    ones stand in their order. Those that lose nothing beside a design with a name come before all others.

    Args:
        objectives: (design, objective), all to be small; without any, no design is best.
        good: which designs keep all limits.
        most: how many.
        named: designs to compare with, (named, objective).
    """
    if not objectives.size:
        return []
    kept = np.clip(np.where(good[:, None], objectives, np.nan), -ENDLESS, ENDLESS)
    if kept.shape[1] == 1:
        order = np.argsort(kept[:, 0], kind="stable")  # NaN last
        return [int(row) for row in order[:most] if not np.isnan(kept[row, 0])]
    rows = np.flatnonzero(front_of(kept))
    low, reach = kept[rows].min(axis=0, initial=np.inf), np.ptp(kept[rows], axis=0) if rows.size else np.ones(1)
    far = np.linalg.norm((kept[rows] - low) / np.where(reach > 0.0, reach, 1.0), axis=1)
    behind = ~losing_nothing(kept[rows], np.clip(named, -ENDLESS, ENDLESS)) if named is not None else rows < 0
    return [int(row) for row in rows[np.lexsort((far, behind))][:most]]
