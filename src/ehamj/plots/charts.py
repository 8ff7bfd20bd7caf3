"""Charts of studies: lines in panels, directions."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from ehamj.plots import style
from ehamj.plots.axes import log_axis, plain
from ehamj.plots.style import Artist, Axes, Figure

COLORS: Final = (
    style.BLUE,
    style.VERMILLION,
    style.GREEN,
    style.PURPLE,
    style.ORANGE,
    style.SKY,
    style.GREY,
    style.INK,
)
DASHES: Final[tuple[Any, ...]] = ("-", (0, (5, 2)), (0, (1, 1.2)), (0, (5, 1.5, 1, 1.5)))
LONGEST: Final = 60
"""Letters of a name in the legend."""
HEIGHT: Final = 190.0
"""Height of a single panel [pt]."""
ROW: Final = 11.0
"""Height of a row of names above the axes [pt]."""


@dataclass(frozen=True)
class Line:
    """A line, or points where ``marker`` is given; ``color`` may be one in `COLORS`, ``dash`` one in `DASHES`."""

    label: str
    x: ArrayLike
    y: ArrayLike
    color: int | str = 0
    dash: int = 0
    marker: str = ""
    width: float = 1.6

    @property
    def hue(self) -> str:
        """Its colour."""
        return self.color if isinstance(self.color, str) else COLORS[self.color % len(COLORS)]


def draw(axes: Axes, lines: Sequence[Line]) -> None:
    for line in lines:
        look: dict[str, Any] = {"color": line.hue, "label": line.label or "_"}
        if line.marker:
            look |= {"marker": line.marker, "linestyle": "none", "markerfacecolor": "white", "markersize": 5.5}
            look |= {"markeredgewidth": 1.4, "zorder": 4}
        else:
            look |= {"linestyle": DASHES[line.dash % len(DASHES)], "linewidth": line.width}
        axes.plot(np.asarray(line.x, float), np.asarray(line.y, float), **look)


def entries_of(axes: Sequence[Axes]) -> dict[str, Artist]:
    """What has a name, once."""
    entries: dict[str, Artist] = {}
    for one in axes:
        handles, names = one.get_legend_handles_labels()
        entries |= {style.shown(name, LONGEST): handle for handle, name in zip(handles, names, strict=True)}
    return entries


def set_scales(axes: Axes, wanted: str) -> None:
    """Make the axes logarithmic that ``wanted`` names: "x", "y" or "xy"."""
    for name, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
        if name in wanted:
            log_axis(axis)


@style.styled()
def lines_chart(
    title: str,
    x: str,
    panels: Mapping[str, Sequence[Line]],
    logarithmic: str = "",
    marks: Mapping[str, float] | None = None,
    limits: Mapping[str, tuple[float, float]] | None = None,
) -> Figure:
    """Lines over a common axis, one panel per quantity.

    Args:
        title: of the figure.
        x: what the axis is, with unit.
        panels: quantity with unit → its lines.
        logarithmic: "x", "y" or "xy".
        marks: name → place on the axis, drawn as a vertical line through all panels.
        limits: quantity → lowest and highest value shown.
    """
    figure, axes = style.new_figure(title, len(panels), sharex=True)
    for one, (quantity, lines) in zip(axes, panels.items(), strict=True):
        draw(one, lines)
        one.set(xlabel=x, ylabel=quantity, **{f"{name}scale": "log" for name in logarithmic})
        if limits and quantity in limits:
            one.set_ylim(*limits[quantity])
        for place in (marks or {}).values():
            one.axvline(place, color=style.GREY, linewidth=1.1, linestyle=(0, (1, 1.5)), zorder=1.5)
    last = axes[-1]
    last.margins(x=0.03 if any(line.marker for lines in panels.values() for line in lines) else 0.0)
    for one in axes:
        set_scales(one, logarithmic)
    style.share(axes)
    rows = _rows_of(last, marks or {})
    height = HEIGHT if len(axes) == 1 else 0.65 * HEIGHT
    head = ROW * (1 + max(rows.values())) if rows else 0.0
    style.arrange(figure, [(one, height) for one in axes], entries_of(axes), gap=12.0, head=head)
    for name, row in rows.items():
        _name(axes[0], name, (marks or {})[name], row, height)
    return figure


def _rows_of(axes: Axes, marks: Mapping[str, float]) -> dict[str, int]:
    """In which row above the axes each name stands: the lowest in which it lies on no other name, nor on its line."""
    width = style.WIDTH - style.LEFT - 14.0
    taken: list[list[tuple[float, float]]] = []
    rows: dict[str, int] = {}
    for name, place in sorted(marks.items(), key=lambda mark: -mark[1]):
        at = width * _share(axes, place)
        begin, end = _reach(at, name, width)
        row = next(
            (k for k, own in enumerate(taken) if all(end < left or begin > right for left, right in own)), len(taken)
        )
        if row == len(taken):
            taken.append([])
        taken[row].append((begin, end))
        for below in taken[:row]:  # its line passes them
            below.append((at - 2.0, at + 2.0))
        rows[name] = row
    return {name: rows[name] for name in marks}


def _reach(at: float, name: str, width: float) -> tuple[float, float]:
    """From where to where a name lies [pt]: right of its line, or left of it where there is no room."""
    long = 5.0 * len(name) + 5.0
    return (at, at + long) if at + long <= width + 12.0 else (at - long, at)


def _name(axes: Axes, name: str, place: float, row: int, height: float) -> None:
    """Write a mark's name above the axes, its line led up to it."""
    width = style.WIDTH - style.LEFT - 14.0
    right = _reach(at := width * _share(axes, place), name, width)[0] >= at
    above = 1.0 + ROW * row / height
    axes.plot(
        [place, place], [1.0, above + (ROW - 3.0) / height], transform=axes.get_xaxis_transform(), clip_on=False,
        color=style.GREY, linewidth=1.1, linestyle=(0, (1, 1.5)), label="_", scalex=False, scaley=False,
    )  # fmt: skip
    axes.annotate(
        name, (place, above), (3 if right else -3, 1), xycoords=("data", "axes fraction"), textcoords="offset points",
        ha="left" if right else "right", va="bottom", fontsize=8.8, color=style.GREY,
    )  # fmt: skip


def _share(axes: Axes, place: float) -> float:
    low, high = axes.get_xlim()
    if axes.get_xscale() == "log":
        return float(np.log(place / low) / np.log(high / low))
    return (place - low) / (high - low)


@style.styled()
def direction_chart(title: str, radius: str, degrees: ArrayLike, lines: Sequence[Line]) -> Figure:
    """Quantities over the direction of travel, seen from above: +x (front) is up, +y (left) is left.

    Args:
        title: of the figure.
        radius: what the distance from the middle is, with unit.
        degrees: directions [deg], (n,), of every line's ``y``.
        lines: their ``x`` is not used.
    """
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    angle = np.radians(np.asarray(degrees, float))
    axes: Any
    figure, (axes,) = style.new_figure(title, subplot_kw={"projection": "polar"})
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(1)
    names = ["front, 0°", "45°", "left\n90°", "135°", "rear, 180°", "225°", "right\n270°", "315°"]
    axes.set_thetagrids(range(0, 360, 45), names)
    around = np.append(angle, angle[0] + 2 * np.pi)
    draw(axes, [replace(line, x=around, y=np.append(line.y, np.ravel(line.y)[:1])) for line in lines])
    most = max((float(np.nanmax(line.y)) for line in lines), default=1.0)
    axes.set_ylim(0.0, 1.05 * most)
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10], prune="lower"))
    axes.yaxis.set_major_formatter(FuncFormatter(plain))
    axes.set_rlabel_position(292.5)  # between right and 315°, where a wave along an axis draws no peak
    axes.tick_params(labelsize=8.5)
    for name in axes.get_yticklabels():
        name.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8})
    axes.set_xlabel(radius)
    style.arrange(figure, [(axes, 1.5 * HEIGHT)], entries_of([axes]), head=14.0)  # room for the name of the front
    return figure
