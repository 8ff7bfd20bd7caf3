"""Bars of what each of several causes does, with intervals: indices of sensitivity, one-at-a-time changes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array
from ehamj.plots import style
from ehamj.plots.axes import linear_axis
from ehamj.plots.charts import LONGEST
from ehamj.plots.style import Axes, Figure

BAR: Final = 8.0
"""Height of a bar [pt]."""
NAME: Final = 13.0
"""Height of the line above a cause's bars, which holds its name [pt]."""
LOOKS: Final[tuple[dict[str, Any], ...]] = (
    {"facecolor": style.BLUE, "edgecolor": style.BLUE},
    {"facecolor": "#F6D9C4", "edgecolor": style.VERMILLION, "hatch": "////"},
    {"facecolor": "white", "edgecolor": style.GREY},
)
"""Of the bars of each set, told apart in grey too: dark, hatched, hollow."""


@dataclass(frozen=True)
class Effects:
    """A set of bars, one for each cause: ``values`` and their intervals ``low`` to ``high``, (causes,) each; NaN where
    there is none."""

    label: str
    values: ArrayLike
    low: ArrayLike | None = None
    high: ArrayLike | None = None


@style.styled()
def effects_chart(
    title: str, axis: str, causes: Sequence[str], sets: Sequence[Effects], base: float = 0.0, base_name: str = ""
) -> Figure:
    """Sets of horizontal bars beside each other, the first cause on top, its name above its bars.

    Args:
        title: of the figure.
        axis: what the bars show, with unit.
        causes: their names.
        sets: at most three, in the order in which they lie below each other.
        base: where bars begin.
        base_name: what the legend calls it; without, it has no entry.
    """
    figure, (axes,) = style.new_figure(title)
    room = NAME + BAR * len(sets) + 3.0
    entries = {}
    low, high = [base], [base]
    for k, (one, look) in enumerate(zip(sets, LOOKS, strict=False)):
        values: Array = np.asarray(one.values, float)
        places: Array = room * np.arange(len(causes), dtype=float) + NAME + BAR * (k + 0.5)
        known = np.isfinite(values)
        axes.barh(places[known], values[known] - base, left=base, height=0.86 * BAR, linewidth=0.8, alpha=0.75, **look)
        entries[style.shown(one.label, LONGEST)] = style.patch_key(**look)
        ends = [values[known]]
        if one.low is not None and one.high is not None:
            ends += _intervals(axes, places, np.asarray(one.low, float), np.asarray(one.high, float), BAR)
            entries["95 % interval"] = style.line_key(color=style.INK, linewidth=1.3, marker="|", markersize=6.0)
        low.append(min((float(part.min()) for part in ends if part.size), default=base))
        high.append(max((float(part.max()) for part in ends if part.size), default=base))
    for k, name in enumerate(causes):
        axes.text(
            0.008, room * k + 0.55 * NAME, style.shown(name, LONGEST), transform=axes.get_yaxis_transform(),
            ha="left", va="center", fontsize=8.8, zorder=5,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6},
        )  # fmt: skip
    key = axes.axvline(base, color=style.INK, linewidth=1.1)
    if base_name:
        entries[base_name] = key
    reach = (max(high) - min(low)) or abs(base) or 1.0
    axes.set(xlabel=axis, yticks=[], xlim=(min(low) - 0.03 * reach, max(high) + 0.03 * reach))
    axes.set_ylim(room * len(causes), 0.0)
    linear_axis(axes.xaxis, 6)
    axes.grid(visible=False, axis="y")
    style.arrange(figure, [(axes, room * len(causes))], entries)
    return figure


def _intervals(axes: Axes, places: Array, low: Array, high: Array, height: float) -> list[Array]:
    """Draw the intervals that are known, and give their ends."""
    known = np.isfinite(low) & np.isfinite(high)
    axes.hlines(places[known], low[known], high[known], color=style.INK, linewidth=1.3, zorder=3)
    for ends in (low[known], high[known]):
        axes.vlines(ends, places[known] - 0.3 * height, places[known] + 0.3 * height, color=style.INK, linewidth=1.3,
                    zorder=3)  # fmt: skip
    return [low[known], high[known]]
