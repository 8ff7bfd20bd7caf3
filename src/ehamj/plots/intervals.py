"""Values with their intervals, a row each: where each began, where it came out, and how far it may be off."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ehamj.plots import style
from ehamj.plots.axes import linear_axis
from ehamj.plots.charts import LONGEST
from ehamj.plots.style import Artist, Axes, Figure

ROW: Final = 25.0
"""Height of a row [pt]: a line for its name and one for its value."""
AT: Final = 18.0
"""Where a row's value lies below its upper edge [pt]."""


@dataclass(frozen=True)
class Interval:
    """One value on the common axis, with the interval and the bounds that it is in; ``value`` is None where it is not
    known."""

    name: str
    value: float | None
    low: float
    high: float
    bounds: tuple[float, float]
    said: str = ""
    """What stands at the row's right."""


@style.styled()
def intervals_chart(title: str, axis: str, rows: Sequence[Interval], within: str = "95 % interval") -> Figure:
    """A row for each value, the first on top; the start is at 0.

    Args:
        title: of the figure.
        axis: what the values are, with unit.
        rows: at least one.
        within: what the intervals are, for the legend.
    """
    figure, (axes,) = style.new_figure(title)
    known = [row for row in rows if row.value is not None]
    ends = [0.0, *(end for row in known for end in (row.low, row.high)), *(end for row in rows for end in row.bounds)]
    low, high = min(ends), max(ends)
    reach = (high - low) or 1.0
    for place, row in enumerate(rows):
        _row(axes, place * ROW, row)
    axes.axvline(0.0, color=style.INK, linewidth=1.1, zorder=1.5)
    axes.set(xlabel=axis, yticks=[], xlim=(low - 0.03 * reach, high + 0.03 * reach), ylim=(ROW * len(rows), 0.0))
    linear_axis(axes.xaxis, 6)
    axes.grid(visible=False, axis="y")
    style.arrange(figure, [(axes, ROW * len(rows))], _entries(rows, within))
    return figure


def _row(axes: Axes, top: float, row: Interval) -> None:
    across = axes.get_yaxis_transform()
    look: dict[str, Any] = {"facecolor": "#EEF1F4", "edgecolor": style.FAINT, "linewidth": 0.7}
    if row.value is None:
        look |= {"facecolor": "white", "hatch": "////"}
    axes.barh(top + AT, np.diff(row.bounds), left=row.bounds[0], height=8.0, zorder=1.0, **look)
    if row.value is not None:
        for end in (row.low, row.high):
            axes.vlines(end, top + AT - 4.0, top + AT + 4.0, color=style.BLUE, linewidth=1.4, zorder=3)
        axes.hlines(top + AT, row.low, row.high, color=style.BLUE, linewidth=1.6, zorder=3)
        axes.plot([row.value], [top + AT], marker="o", markersize=5.0, color=style.BLUE, markerfacecolor="white",
                  markeredgewidth=1.5, zorder=4)  # fmt: skip
    for at, text, side in ((0.004, style.shown(row.name, LONGEST), "left"), (0.996, row.said, "right")):
        axes.text(at, top + 6.5, text, transform=across, ha=side, va="center", fontsize=8.8, zorder=5)


def _entries(rows: Sequence[Interval], within: str) -> dict[str, Artist]:
    entries: dict[str, Artist] = {}
    if any(row.value is not None for row in rows):
        entries[f"value and {within}"] = style.line_key(
            color=style.BLUE, linewidth=1.6, marker="o", markerfacecolor="white", markersize=5.0
        )
    entries["bounds"] = style.patch_key(facecolor="#EEF1F4", edgecolor=style.FAINT)
    if any(row.value is None for row in rows):
        entries["not told by the data"] = style.patch_key(facecolor="white", edgecolor=style.FAINT, hatch="////")
    entries["start"] = style.line_key(color=style.INK, linewidth=1.1)
    return entries
