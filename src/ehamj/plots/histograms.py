"""Spreads of quantities within tolerances: histograms with the band that most lie in, and limits."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from ehamj.plots import style
from ehamj.plots.axes import linear_axis
from ehamj.plots.style import Artist, Axes, Figure

PANEL: Final = 105.0
"""Height of a panel [pt]."""


@dataclass(frozen=True)
class Spread:
    """Values of one quantity, its name with unit; limits, and where it is as designed, where there are such."""

    axis: str
    values: ArrayLike
    at_least: float | None = None
    at_most: float | None = None
    designed: float | None = None
    said: str = ""
    """What stands above the panel, such as the yield."""


@style.styled()
def spreads_chart(title: str, spreads: Sequence[Spread], what: str = "designs") -> Figure:
    """A histogram of each, below each other: 5 to 95 % shaded, what limits forbid hatched.

    Args:
        title: of the figure.
        spreads: each with at least one finite value.
        what: is counted.
    """
    figure, axes = style.new_figure(title, len(spreads))
    entries: dict[str, Artist] = {}
    for one, spread in zip(axes, spreads, strict=True):
        entries |= _panel(one, spread)
        one.set(xlabel=spread.axis, ylabel=f"{what} [-]")
        linear_axis(one.xaxis, 6)
        linear_axis(one.yaxis, 4)
        if spread.said:
            one.set_title(spread.said, loc="left", fontsize=8.8, pad=3.0)
    style.arrange(figure, [(one, PANEL) for one in axes], entries, gap=60.0, head=16.0)
    return figure


def _panel(axes: Axes, spread: Spread) -> dict[str, Artist]:
    """Draw one; what it shows for the legend."""
    values = np.asarray(spread.values, float)
    known = values[np.isfinite(values)]
    marks = [mark for mark in (spread.at_least, spread.at_most, spread.designed) if mark is not None]
    low, high = float(min(known.min(), *marks, known.max())), float(max(known.max(), *marks, known.min()))
    reach = (high - low) or max(abs(high), 1.0) * 1e-3
    low, high = low - 0.06 * reach, high + 0.06 * reach
    bins = int(np.clip(np.sqrt(known.size) * reach / (np.ptp(known) or reach), 8, 60))
    axes.hist(known, bins=np.linspace(low, high, bins + 1).tolist(), color=style.BLUE, alpha=0.45,
              edgecolor=style.BLUE, linewidth=0.7, zorder=2)  # fmt: skip
    five, most = np.percentile(known, [5.0, 95.0])
    axes.axvspan(five, most, color="#E6EBF0", zorder=0.5, linewidth=0.0)
    entries: dict[str, Artist] = {"5 to 95 %": style.patch_key(color="#E6EBF0")}
    median = axes.axvline(float(np.median(known)), color=style.INK, linewidth=1.2, linestyle=(0, (5, 2)), zorder=3)
    entries["median"] = median
    for limit, (begin, end) in ((spread.at_least, (low, spread.at_least)), (spread.at_most, (spread.at_most, high))):
        if limit is not None and begin is not None and end is not None:
            axes.axvspan(begin, end, facecolor="none", edgecolor=style.LIMIT_COLOR, hatch="////", linewidth=0.0,
                         alpha=0.35, zorder=0.8)  # fmt: skip
            axes.axvline(limit, color=style.LIMIT_COLOR, linewidth=1.6, zorder=3)
            look = {"facecolor": "white", "edgecolor": style.LIMIT_COLOR, "hatch": "////"}
            entries["beyond a limit"] = style.patch_key(**look)
    if spread.designed is not None:
        (entries["as designed"],) = axes.plot(
            [spread.designed], [0.0], marker="^", markersize=8.0, color=style.VERMILLION, markerfacecolor="white",
            markeredgewidth=1.5, linestyle="none", clip_on=False, zorder=6,
        )  # fmt: skip
    axes.set_xlim(low, high)
    return entries
