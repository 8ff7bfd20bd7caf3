"""Which measure of influence a plan's designs allow, and that of every merit."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ehamj.arrays import Array
from ehamj.campaign.analysis.effects import Effect, one_at_a_time
from ehamj.campaign.analysis.sensitivity import morris_effects, sobol_indices
from ehamj.campaign.influence import Influence, Measure, rank_correlations
from ehamj.campaign.names import unit_text
from ehamj.campaign.plans.grids import OneAtATime
from ehamj.campaign.plans.indices import Morris, Sobol
from ehamj.campaign.plans.optimise import Optimise
from ehamj.campaign.studied import Studied


def influences_of(studied: Studied) -> list[Influence]:
    """How much the parameters do to each merit, objectives first; of a search none, whose designs are not drawn."""
    plan: Any = studied.file.plan
    if isinstance(plan, Optimise) or studied.done.empty:
        return []
    measured: Callable[[Studied, str], Influence | None] = rank_correlations
    if isinstance(plan, Sobol):
        measured = _sobol
    elif isinstance(plan, Morris):
        measured = _morris
    elif isinstance(plan, OneAtATime):
        measured = _one_at_a_time
    found = (measured(studied, name) for name in studied.file.wanted)
    return [one for one in found if one is not None and np.isfinite(one.size).all() and one.known]


def in_order(studied: Studied, merit: str) -> Array:
    """A merit of the plan's designs in their order; NaN of those that failed or are not there yet."""
    places = studied.search["number"].to_numpy(int) - studied.first
    found = np.full(int(places.max(initial=-1)) + 1, np.nan)
    found[places] = studied.search[merit].to_numpy(float)
    return found


def _sobol(studied: Studied, merit: str) -> Influence:
    found = sobol_indices(studied.file.plan, studied.parameters, in_order(studied, merit))
    measures = (
        Measure("first order", found.first, found.first - found.first_reach, found.first + found.first_reach),
        Measure("total index", found.total, found.total - found.total_reach, found.total + found.total_reach),
    )
    pairs: tuple[tuple[str, str, float, float], ...] = ()
    if found.second is not None and found.second_reach is not None:
        pairs = tuple(
            (found.keys[i], found.keys[j], float(found.second[i, j]), float(found.second_reach[i, j]))
            for j in range(len(found.keys))
            for i in range(j)
        )
    said = f"{found.used:,} groups of designs" + (f", {found.dropped:,} left out" if found.dropped else "")
    return Influence(
        merit,
        found.keys,
        "share of the variance",
        "Sobol index, share of the variance [-]",
        measures,
        said,
        pairs=pairs,
    )


def _morris(studied: Studied, merit: str) -> Influence:
    found = morris_effects(studied.file.plan, studied.parameters, in_order(studied, merit))
    axis = f"elementary effect over the whole range [{unit_text(studied.unit(merit))}]"
    size = Measure("μ*, mean size", found.size, found.size - found.size_reach, found.size + found.size_reach)
    said = f"{found.used:,} paths" + (f", {found.dropped:,} left out" if found.dropped else "")
    return Influence(
        merit, found.keys, "elementary effects", axis, (Measure("σ, scatter", found.scatter), size), said,
        unit=studied.unit(merit),
    )  # fmt: skip


def _one_at_a_time(studied: Studied, merit: str) -> Influence | None:
    designs = studied.search
    if int(designs["number"].iloc[0]) != studied.first:
        return None  # what the others are compared with is not there yet
    keys = studied.parameters
    effects = one_at_a_time(keys, designs[list(keys)].to_numpy(object).tolist(), designs[merit].to_numpy(float))
    low, high = np.array([_ends(one) for one in effects]).T
    own = float(designs[merit].iloc[0])
    return Influence(
        merit,
        keys,
        "one parameter at a time",
        f"{studied.short[merit]} [{unit_text(studied.unit(merit))}]",
        (Measure("at its lowest value", low), Measure("at its highest value", high)),
        base=own,
        base_name="all as they are",
        unit=studied.unit(merit),
        more=(Measure("relative sensitivity d ln f/d ln p", np.array([one.slope for one in effects])),),
    )


def _ends(effect: Effect) -> tuple[float, float]:
    """The merit at the least and the largest value; at both ends of its own range where values are no numbers."""
    if all(isinstance(value, int | float) for value in effect.values):
        return float(effect.merit[0]), float(effect.merit[-1])
    known = effect.merit[np.isfinite(effect.merit)]
    return (float(known.min()), float(known.max())) if known.size else (np.nan, np.nan)
