"""Global sensitivity of a merit, from the plans that were made for it (SALib), with 95 % intervals."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.campaign.plans.indices import Morris, Sobol, unit_cube
from ehamj.errors import InputError

CONFIDENCE: Final = 0.95
RESAMPLES: Final = 200
"""Bootstrap samples of an interval: its width is then known to 5 %."""
FEWEST: Final = 2
"""Groups or paths of which an interval can be made."""


@dataclass(frozen=True)
class SobolIndices:
    """Shares of a merit's variance, each (parameter,) and with half the width of its 95 % interval.

    NaN where they are not defined: the merit is the same in all designs, or fewer than two groups are whole.
    """

    keys: tuple[str, ...]
    first: Array
    """S_i, of a parameter alone [-]."""
    first_reach: Array
    total: Array
    """S_Ti, of a parameter with all that it has to do with others [-]."""
    total_reach: Array
    second: Array | None
    """S_ij, of two parameters together beyond both alone (parameter, parameter), above the diagonal [-]."""
    second_reach: Array | None
    used: int
    """Groups of designs that are whole."""
    dropped: int
    """Groups that were left out, as a design of them has no such merit."""


@dataclass(frozen=True)
class MorrisEffects:
    """Elementary effects of each parameter (parameter,), in the merit's unit over the parameter's whole range."""

    keys: tuple[str, ...]
    mean: Array
    """μ: their mean."""
    size: Array
    """μ*: the mean of their magnitudes."""
    size_reach: Array
    """Half the width of its 95 % interval."""
    scatter: Array
    """σ: their standard deviation, of a merit that is not linear or in which parameters act on each other."""
    used: int
    """Paths that are whole."""
    dropped: int
    """Paths that were left out, as a design of them has no such merit."""


def sobol_indices(plan: Sobol, keys: Sequence[str], merit: Array) -> SobolIndices:
    """Sobol's indices of first and total order (Saltelli 2010), of second order where the plan has pairs.

    Args:
        plan: whose designs they are.
        keys: its parameters, in order.
        merit: of its designs in order, (design,); NaN of what failed, with which its whole group goes; the last
            ones may not be there yet.

    Raises:
        InputError: if these are more than the plan's designs.
    """
    from SALib.analyze import sobol

    groups, whole = _whole(merit, plan.groups, plan.size(len(keys)), "group")
    used = int(whole.sum())
    found: dict[str, Any] = {}
    if used >= FEWEST and np.ptp(groups[whole]) > 0.0:
        found = sobol.analyze(
            unit_cube(tuple(keys)),
            groups[whole].ravel(),
            calc_second_order=plan.second_order,
            num_resamples=RESAMPLES,
            conf_level=CONFIDENCE,
            seed=plan.seed + 1,  # with 0 it would draw from NumPy's common generator
        )

    def of(name: str, *shape: int) -> Array:
        return np.asarray(found[name], float) if found else np.full(shape, np.nan)

    count = len(keys)
    return SobolIndices(
        keys=tuple(keys),
        first=of("S1", count),
        first_reach=of("S1_conf", count),
        total=of("ST", count),
        total_reach=of("ST_conf", count),
        second=of("S2", count, count) if plan.second_order else None,
        second_reach=of("S2_conf", count, count) if plan.second_order else None,
        used=used,
        dropped=plan.groups - used,
    )


def morris_effects(plan: Morris, keys: Sequence[str], merit: Array) -> MorrisEffects:
    """Morris' measures: μ, μ* (Campolongo) and σ of the elementary effects.

    Args:
        plan: whose designs they are.
        keys: its parameters, in order.
        merit: of its designs in order, (design,); NaN of what failed, with which its whole path goes; the last
            ones may not be there yet.

    Raises:
        InputError: if these are more than the plan's designs.
    """
    from SALib.analyze import morris

    count = len(keys)
    paths, whole = _whole(merit, plan.paths, count + 1, "path")
    used = int(whole.sum())
    found: dict[str, Any] = {}
    if used >= FEWEST:
        found = morris.analyze(
            unit_cube(tuple(keys)),
            plan.points(tuple(keys)).reshape((*paths.shape, count))[whole].reshape(-1, count),
            paths[whole].ravel(),
            num_resamples=RESAMPLES,
            conf_level=CONFIDENCE,
            num_levels=plan.levels,
            seed=plan.seed,
        )

    def of(name: str) -> Array:
        return np.asarray(found[name], float) if found else np.full(count, np.nan)

    return MorrisEffects(
        keys=tuple(keys),
        mean=of("mu"),
        size=of("mu_star"),
        size_reach=of("mu_star_conf"),
        scatter=of("sigma"),
        used=used,
        dropped=plan.paths - used,
    )


def _whole(merit: Array, number: int, size: int, what: str) -> tuple[Array, NDArray[np.bool_]]:
    """A plan's designs by groups (group, design), and which of these have all of them."""
    merit = np.asarray(merit, float)
    if merit.ndim != 1 or merit.size > number * size:
        raise InputError(
            f"merit: has shape {merit.shape}; must be ({number * size},), {size} designs in each {what} of {number}"
        )
    groups = np.full((number, size), np.nan)
    groups.flat[: merit.size] = merit
    return groups, np.asarray(np.isfinite(groups).all(axis=1))
