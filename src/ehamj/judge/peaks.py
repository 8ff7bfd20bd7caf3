"""Peaks of a run beyond those of velocity, and the swings that they belong to, as far as norms limit them."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.columns import column, places
from ehamj.criteria.curves import Kind, Norm
from ehamj.estimate.swings import Swings
from ehamj.judge.levels import LEAST_ROWS, motions_of
from ehamj.plant.axes import AXES
from ehamj.records.units import Quantity


@dataclass(frozen=True)
class Peaks:
    """Largest values and swings of each place; of floor and feet those of the worst mount, and of all mounts."""

    levels: dict[str, dict[Kind, Array]] = field(default_factory=dict)
    """By kind, (1, axis) [SI]."""
    swings: dict[str, dict[str, dict[Quantity, Swings]]] = field(default_factory=dict)
    """By axis."""


def peaks_of(dataset: xr.Dataset, rate: float, norms: Iterable[Norm]) -> Peaks:
    """What the norms limit of peaks; displacements count from their mean.

    Args:
        dataset: of a result, all of it.
        rate: recording rate [Hz].
        norms: which judge.
    """
    chosen = list(norms)
    wanted = {quantity for norm in chosen for quantity, statistic in norm.kinds if statistic == "peak"}
    swinging = frozenset[Quantity]().union(*(norm.swinging for norm in chosen))
    found = Peaks()
    for quantity in sorted(wanted):
        for place, motion in motions_of(dataset, quantity).items():
            enough = motion.shape[0] >= LEAST_ROWS
            level = np.full(len(AXES), -np.inf if enough else np.nan)
            found.levels.setdefault(place, {})[quantity, "peak"] = level[None]
            if not enough:
                continue
            swings: dict[int, list[Swings]] = {}
            for at in places(motion):
                moved, k = column(motion, *at), at[-1]
                moved = moved - moved.mean() if quantity == "displacement" else moved
                level[k] = np.maximum(level[k], np.abs(moved).max())
                if quantity in swinging:
                    swings.setdefault(k, []).append(Swings.of(moved, rate))
            for k, parts in swings.items():
                by_axis = found.swings.setdefault(place, {}).setdefault(AXES[k], {})
                by_axis[quantity] = Swings.together(parts)
    return found
