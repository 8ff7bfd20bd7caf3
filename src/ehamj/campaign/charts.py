"""Figures of a study: what matters, what is best, how it spreads."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Final

import numpy as np

from ehamj.campaign.influence import Influence, rank_correlations
from ehamj.campaign.names import axis_of
from ehamj.campaign.plans.grids import OneAtATime
from ehamj.campaign.studied import DataFrame, Row, Studied
from ehamj.campaign.yields import Yield, groups
from ehamj.plots import Figure
from ehamj.plots.clouds import Cloud, Pair, pairs_chart, scatter_matrix
from ehamj.plots.effects import Effects, effects_chart
from ehamj.plots.histograms import Spread, spreads_chart
from ehamj.studies.outcome import Drawing

COLUMNS: Final = 5
"""Of a scatter matrix: more are too small to be read."""
MERITS: Final = 6
"""Merits of which there is a figure each."""
NUMBERS: Final = 14
"""Designs of the front whose numbers are drawn."""
PANELS: Final = 4
"""Panels of a figure."""
SPREADS: Final = 2
"""Best designs, and designs with a name, whose machines within tolerances are drawn; all are in the table."""
LITTLE: Final = 0.01
"""Share of the strongest influence below which another one is not drawn."""
CAUSES: Final = 12
"""Parameters that a figure of influences shows."""


def axis(studied: Studied, name: str, designs: DataFrame) -> tuple[str, "np.ndarray[tuple[int], np.dtype[np.float64]]"]:
    """A parameter or merit of designs as an axis has it."""
    return axis_of(studied.short[name], studied.unit(name), designs[name].to_numpy(float))


def clouds_of(studied: Studied) -> list[Cloud]:
    """The plan's designs that are done (good ones, others, the best) and those with a name; rows count those of
    `drawn_designs`."""
    good, done = studied.good(studied.search), np.asarray(studied.search["status"] == "done")
    special = studied.front or studied.best
    plain = np.ones(len(done), bool)
    plain[special] = False
    count = len(done)
    found = [Cloud("designs that keep all limits" if studied.file.limits else "designs", np.flatnonzero(good & plain))]
    found.append(Cloud("limits not kept", np.flatnonzero(done & ~good & plain), 1))
    found.append(Cloud("Pareto front" if studied.front else "best designs", np.array(special, int), 2))
    found.append(Cloud(" and ".join(_shown_names(studied)), np.arange(count, count + len(studied.named)), 3))
    return [cloud for cloud in found if len(cloud.rows)]


def _shown_names(studied: Studied) -> list[str]:
    return [f"“{name}”" for name in list(studied.named)[:2]] + (
        [f"{len(studied.named) - 2} more"] if len(studied.named) > 2 else []
    )


def drawn_designs(studied: Studied) -> DataFrame:
    """Designs that are drawn as points: the plan's, then those with a name."""
    import pandas as pd

    return pd.concat([studied.search, pd.DataFrame(list(studied.named.values()))], ignore_index=True)


def front_drawing(studied: Studied) -> Iterator[tuple[str, Drawing]]:
    """The Pareto front, two objectives at a time, numbers at its designs."""
    if not studied.front:
        return
    names = list(studied.file.objectives)
    pairs = [(0, 1)] if len(names) == 2 else [(i, j) for j in range(len(names)) for i in range(j)]
    caption = (
        f"{len(studied.front)} designs that no other one beats in every objective, of {len(studied.done)}; numbers "
        "and names are those of designs."
    )
    if len(pairs) > PANELS:
        caption += f" {PANELS} of the {len(pairs)} pairs of objectives are drawn."

    def draw() -> Figure:
        designs, count = drawn_designs(studied), len(studied.search)
        few = np.unique(np.linspace(0, len(studied.front) - 1, NUMBERS).round().astype(int))
        numbered = [*studied.best, *(studied.front[k] for k in few)]
        numbers = {row: str(designs["number"][row]) for row in numbered[:1]}
        numbers |= {count + k: name for k, name in enumerate(studied.named)}
        numbers |= {row: str(designs["number"][row]) for row in numbered[1:]}
        panels = []
        for i, j in pairs[:PANELS]:
            ways = [
                side[studied.file.objectives[names[k]] == "highest"]
                for k, side in ((i, ("left", "right")), (j, ("down", "up")))
            ]
            line = studied.front if len(names) == 2 else ()
            panels.append(
                Pair(axis(studied, names[i], designs), axis(studied, names[j], designs), numbers, line,
                     f"better: {' and '.join(ways)}")
            )  # fmt: skip
        return pairs_chart("Pareto front", panels, clouds_of(studied))

    yield "pareto-front", Drawing(caption, draw)


def matrix_drawing(studied: Studied, influences: Sequence[Influence]) -> Iterator[tuple[str, Drawing]]:
    """Parameters and merits against each other, the few that say most; none of one parameter at a time."""
    columns = chosen_columns(studied, influences)
    if len(columns) < 2 or len(studied.done) < 3 or isinstance(studied.file.plan, OneAtATime):
        return

    def draw() -> Figure:
        found = dict(axis(studied, name, drawn_designs(studied)) for name in columns)
        return scatter_matrix("Parameters and figures of merit of the designs", found, clouds_of(studied))

    caption = "Above the diagonal: rank correlation (Spearman) of the two, bold from ±0.5 on."
    left = len(studied.numeric) + len(studied.merits) - len(columns)
    yield (
        "scatter-matrix",
        Drawing(caption + (f" What else varies, {left} more, is in designs.csv." if left > 0 else ""), draw),
    )


def chosen_columns(studied: Studied, influences: Sequence[Influence]) -> list[str]:
    """The objectives, then merits with limits, then all others, at most three; and the parameters that do most to
    them, each merit's strongest in turn."""
    moved = [name for name in studied.file.wanted if studied.done[name].nunique() > 1]
    merits = moved[:3]
    influences = influences or [one for name in merits if (one := rank_correlations(studied, name))]
    ranks = [[one.parameters[k] for k in one.order] for one in influences if one.merit in merits]
    turns = (keys[k] for k in range(max(map(len, ranks), default=0)) for keys in ranks if k < len(keys))
    keys = list(dict.fromkeys([*turns, *studied.numeric]))
    return [*[key for key in keys if key in studied.numeric][: COLUMNS - len(merits)], *merits]


def influence_drawings(studied: Studied, influences: Sequence[Influence]) -> Iterator[tuple[str, Drawing]]:
    """Bars of each merit's influences, the strongest first."""
    for one in influences[:MERITS]:
        drawing = Drawing(_influence_caption(one), partial(_influence_chart, studied, one))
        yield f"influence-{one.merit.replace('.', '-')}", drawing


def shown_causes(one: Influence) -> list[int]:
    """The strongest parameters, but for those that do next to nothing beside the first."""
    least = LITTLE * one.size.max()
    return [k for k in one.order[:CAUSES] if one.size[k] > least] or one.order[:1]


def _influence_caption(one: Influence) -> str:
    left = len(one.parameters) - len(shown_causes(one))
    more = f" {left} that do little or nothing are in the table." if left else ""
    return f"What each parameter does to {one.merit}, the strongest first.{more}"


def _influence_chart(studied: Studied, one: Influence) -> Figure:
    order = shown_causes(one)
    sets = [
        Effects(m.label, m.values[order], *(None if end is None else end[order] for end in (m.low, m.high)))
        for m in one.measures
    ]
    title = f"{one.title[0].upper()}{one.title[1:]}: {studied.short[one.merit]}"
    causes = [studied.short[one.parameters[k]] for k in order]
    return effects_chart(title, one.axis, causes, sets, one.base, one.base_name)


def spread_drawings(studied: Studied, yields: Sequence[Yield]) -> Iterator[tuple[str, Drawing]]:
    """Histograms of machines within tolerances, a figure for each design that they are around."""
    around = groups(studied)
    whose_shown = [*[whose for whose in around if whose not in studied.named][:SPREADS],
                   *[whose for whose in around if whose in studied.named][:SPREADS]]  # fmt: skip
    for whose in whose_shown:
        machines = around[whose]
        names = [name for name in studied.file.wanted if np.isfinite(machines[name]).any()][:PANELS]
        if names:
            about = f"around {whose}" if whose else "of the study"
            caption = f"{len(machines)} machines {about}; what lies beyond a limit is hatched."
            drawing = Drawing(caption, partial(_spreads, studied, whose, machines, names, yields))
            yield f"spread-{whose or 'all'}".replace(" ", "-"), drawing


def _spreads(
    studied: Studied, whose: str, machines: DataFrame, names: Sequence[str], yields: Sequence[Yield]
) -> Figure:
    designed = parent_of(studied, whose)
    spreads = []
    for name in names:
        limit = studied.file.limits.get(name)
        ends = (None, None) if limit is None else (limit.at_least, limit.at_most)
        own = np.nan if designed is None else float(designed[name])
        marks = [np.nan if end is None else end for end in (*ends, own)]
        label, values = axis_of(studied.short[name], studied.unit(name), [*machines[name].to_numpy(float), *marks])
        low, high, nominal = (None if np.isnan(mark) else float(mark) for mark in values[-3:])
        limited = list(studied.file.limits) == [name]
        found = next((y for y in yields if y.whose == whose and y.limit == ("" if limited else name)), None)
        said = "" if found is None else f"yield {found.said}: {studied.bounds_said(name)}"
        spreads.append(Spread(label, values[:-3], low, high, nominal, said))
    title = f"Within tolerances: {whose}" if whose else "Spread of the machines"
    return spreads_chart(title, spreads, "machines")


def parent_of(studied: Studied, whose: str) -> Row | None:
    """The design that machines are around, as designed; of those around none, the scenario's own."""
    if not whose:
        return next(iter(studied.named.values()), None)
    if whose in studied.named:
        return studied.named[whose]
    return next((one for one in map(studied.design, studied.best) if f"design {one['number']}" == whose), None)
