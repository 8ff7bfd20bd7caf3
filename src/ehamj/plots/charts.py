"""Charts of studies: lines in panels, maps of two parameters, directions."""

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
LONGEST: Final = 50
"""Letters of a name in the legend."""
UNSTABLE: Final = "#F3D9D5"
HEIGHT: Final = 190.0
"""Height of a single panel [pt]."""


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


def _draw(axes: Axes, lines: Sequence[Line]) -> None:
    for line in lines:
        look: dict[str, Any] = {"color": line.hue, "label": line.label or "_"}
        if line.marker:
            look |= {"marker": line.marker, "linestyle": "none", "markerfacecolor": "white", "markersize": 5.5}
            look |= {"markeredgewidth": 1.4, "zorder": 4}
        else:
            look |= {"linestyle": DASHES[line.dash % len(DASHES)], "linewidth": line.width}
        axes.plot(np.asarray(line.x, float), np.asarray(line.y, float), **look)


def _entries(axes: Sequence[Axes]) -> dict[str, Artist]:
    """What has a name, once."""
    entries: dict[str, Artist] = {}
    for one in axes:
        handles, names = one.get_legend_handles_labels()
        entries |= {style.shown(name, LONGEST): handle for handle, name in zip(handles, names, strict=True)}
    return entries


def _scales(axes: Axes, wanted: str) -> None:
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
        _draw(one, lines)
        one.set(xlabel=x, ylabel=quantity, **{f"{name}scale": "log" for name in logarithmic})
        if limits and quantity in limits:
            one.set_ylim(*limits[quantity])
        for place in (marks or {}).values():
            one.axvline(place, color=style.GREY, linewidth=1.1, linestyle=(0, (1, 1.5)), zorder=1.5)
    last = axes[-1]
    last.margins(x=0.03 if any(line.marker for lines in panels.values() for line in lines) else 0.0)
    for one in axes:
        _scales(one, logarithmic)
    for name, place in (marks or {}).items():
        side, offset = ("left", 3) if _share(last, place) < 0.6 else ("right", -3)
        axes[0].annotate(
            name, (place, 1.0), (offset, -2), xycoords=("data", "axes fraction"), textcoords="offset points",
            ha=side, va="top", fontsize=8.8, color=style.GREY,
        )  # fmt: skip
    style.share(axes)
    height = HEIGHT if len(axes) == 1 else 0.65 * HEIGHT
    style.arrange(figure, [(one, height) for one in axes], _entries(axes), gap=12.0)
    return figure


def _share(axes: Axes, place: float) -> float:
    low, high = axes.get_xlim()
    if axes.get_xscale() == "log":
        return float(np.log(place / low) / np.log(high / low))
    return (place - low) / (high - low)


@style.styled()
def map_chart(
    title: str,
    x: tuple[str, ArrayLike],
    y: tuple[str, ArrayLike],
    values: tuple[str, ArrayLike],
    boundary: tuple[str, ArrayLike] | None = None,
    points: Sequence[Line] = (),
    levels: Sequence[float] | None = None,
    logarithmic: str = "",
) -> Figure:
    """A quantity over two parameters as filled contours, with the boundary of stability.

    Args:
        title: of the figure.
        x: name with unit, and values (n,).
        y: name with unit, and values (m,).
        values: name with unit, and values (m, n); NaN where there are none.
        boundary: name, and a function (m, n) that is positive where designs are unstable: hatched.
        points: designs marked.
        levels: of the contours; round ones without.
        logarithmic: "x", "y" or "xy".
    """
    from matplotlib import colormaps
    from matplotlib.ticker import MaxNLocator

    across, up = np.asarray(x[1], float), np.asarray(y[1], float)
    field = np.ma.masked_invalid(np.asarray(values[1], float))
    reach = np.full(field.shape, -1.0) if boundary is None else np.asarray(boundary[1], float)
    field = np.ma.masked_where(reach > 0.0, field)
    figure, (axes,) = style.new_figure(title)
    if levels is None:
        levels = MaxNLocator(10, steps=[1, 2, 2.5, 5, 10]).tick_values(float(field.min()), float(field.max()))
    steps = np.asarray(levels, float)
    colors = colormaps["viridis"](np.linspace(0.12, 0.98, len(steps) - 1))
    axes.contourf(across, up, field, levels=steps, colors=colors, extend="neither", zorder=0.5)
    drawn = axes.contour(across, up, field, levels=steps, colors="white", linewidths=0.6, zorder=0.6)
    axes.clabel(drawn, fontsize=8, fmt=plain, colors=style.INK)
    entries = {values[0]: style.line_key(color=colors[len(colors) // 2], linewidth=6.0)}
    if boundary is not None and reach.max() > 0.0:
        axes.contourf(across, up, reach, levels=[0.0, np.inf], colors=[UNSTABLE], zorder=0.7)
        axes.contour(across, up, reach, levels=[0.0], colors=[style.LIMIT_COLOR], linewidths=2.0, zorder=0.8)
        entries[boundary[0]] = style.patch_key(facecolor=UNSTABLE, edgecolor=style.LIMIT_COLOR)
    _draw(axes, points)
    axes.grid(False)
    axes.set(xlabel=x[0], ylabel=y[0], xlim=(across.min(), across.max()), ylim=(up.min(), up.max()))
    _scales(axes, logarithmic)
    style.arrange(figure, [(axes, 1.15 * HEIGHT)], entries | _entries([axes]))
    return figure


@style.styled()
def direction_chart(title: str, radius: str, degrees: ArrayLike, lines: Sequence[Line]) -> Figure:
    """Quantities over the direction of travel, seen from above: +x (front) is up, +y (left) is left.

    Args:
        title: of the figure.
        radius: what the distance from the middle is, with unit.
        degrees: directions [deg], (n,), of every line's ``y``.
        lines: their ``x`` is not used.
    """
    angle = np.radians(np.asarray(degrees, float))
    axes: Any
    figure, (axes,) = style.new_figure(title, subplot_kw={"projection": "polar"})
    axes.set_theta_zero_location("N")
    axes.set_theta_direction(1)
    axes.set_thetagrids(range(0, 360, 45), ["front", "45°", "left", "135°", "rear", "225°", "right", "315°"])
    around = np.append(angle, angle[0] + 2 * np.pi)
    _draw(axes, [replace(line, x=around, y=np.append(line.y, np.ravel(line.y)[:1])) for line in lines])
    axes.set_rlabel_position(22.5)
    axes.tick_params(labelsize=8.5)
    axes.set_xlabel(radius)
    style.arrange(figure, [(axes, 1.3 * HEIGHT)], _entries([axes]), head=14.0)  # room for the name of the front
    return figure
