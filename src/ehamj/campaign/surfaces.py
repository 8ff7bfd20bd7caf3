"""Response surfaces: merits over the two parameters that do most to them, by a quadratic fit."""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Final

import numpy as np

from ehamj.campaign.analysis.regression import Surface, response_surface
from ehamj.campaign.influence import Influence, rank_correlations
from ehamj.campaign.names import axis_of
from ehamj.campaign.plans.grids import OneAtATime
from ehamj.campaign.studied import Studied
from ehamj.plots import Figure, Line, map_chart
from ehamj.studies.outcome import Drawing

MERITS: Final = 4
"""Merits of which there is a surface."""
PARAMETERS: Final = 10
"""Parameters that a surface has at most: the strongest."""
POINTS: Final = 41
"""Of the map to each side."""
LEAST: Final = 0.5
"""Share of the variance that a surface must predict of designs that it was not made of, to be drawn."""


def surface_drawings(studied: Studied, influences: Sequence[Influence]) -> Iterator[tuple[str, Drawing]]:
    """A map of each of the first merits whose surface predicts."""
    if isinstance(studied.file.plan, OneAtATime):  # it never changes two values together
        return
    drawn = 0
    for name in studied.file.wanted:
        found = surface_of(studied, name, influences)
        if found is None or found.predicted < LEAST:
            continue
        others = ", all others at their means" if len(found.keys) > 2 else ""
        caption = (
            f"A quadratic fitted to {found.used:,} designs, over the two parameters that do most{others}. It explains "
            f"{100 * found.explained:.1f} % of the variance, {100 * found.predicted:.1f} % of designs left out."
        )
        yield f"surface-{name.replace('.', '-')}", Drawing(caption, partial(_map, studied, name, found))
        drawn += 1
        if drawn == MERITS:
            return


def surface_of(studied: Studied, merit: str, influences: Sequence[Influence]) -> Surface | None:
    """The fit over the parameters that do most, as many as there are designs for; the strongest two first."""
    designs = studied.done[np.isfinite(studied.done[merit])]
    own = next((one for one in influences if one.merit == merit), None) or rank_correlations(studied, merit)
    if own is None or designs[merit].nunique() < 2:
        return None
    ranked = [own.parameters[k] for k in own.order if own.parameters[k] in studied.numeric]
    keys = [key for key in ranked if designs[key].nunique() > 2][:PARAMETERS]
    while len(keys) > 2 and len(designs) < 2 * (1 + len(keys) + len(keys) * (len(keys) + 1) // 2):
        keys.pop()
    if len(keys) < 2 or len(designs) < 12:
        return None
    return response_surface(keys, designs[keys].to_numpy(float), designs[merit].to_numpy(float))


def _map(studied: Studied, merit: str, surface: Surface) -> Figure:
    x, y = surface.keys[:2]
    across, up = (np.linspace(studied.done[key].min(), studied.done[key].max(), POINTS) for key in (x, y))
    values = np.tile(surface.middle, (POINTS, POINTS, 1))
    values[..., 0], values[..., 1] = np.meshgrid(across, up)
    field = axis_of(studied.short[merit], studied.unit(merit), surface.at(values))
    places = [studied.design(row) for row in studied.best]
    own = [axis_of(studied.short[key], studied.unit(key), [*grid, *(float(one[key]) for one in places)])
           for key, grid in ((x, across), (y, up))]  # fmt: skip
    points = [Line("best designs", own[0][1][POINTS:], own[1][1][POINTS:], 1, marker="s")] if places else []
    (name_x, of_x), (name_y, of_y) = own
    title = f"Response surface: {studied.short[merit]}"
    return map_chart(title, (name_x, of_x[:POINTS]), (name_y, of_y[:POINTS]), field, points=points)
