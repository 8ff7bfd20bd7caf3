"""Figures from plain arrays; they know no simulation.

Every figure is a `matplotlib.figure.Figure` of a phone's proportions, so that its text stays readable across a narrow
screen and two of them fit beside each other on paper. Matplotlib is imported when the first figure is drawn, and
pyplot never. Colours are those of Okabe and Ito, which most colour-blind people tell apart.
"""

import io
import itertools
import math
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Vector = tuple[float, float, float]

INCH: Final = 72.0
WIDTH: Final = 374.0
"""Width of every figure [pt]."""

LEFT, BELOW = 58.0, 40.0
"""Room left of and below every axes, for numbers and names [pt]."""

BLUE, VERMILLION, GREEN, PURPLE, SKY, ORANGE = "#0072B2", "#D55E00", "#00855F", "#B5578F", "#56B4E9", "#E69F00"
FLOOR_COLOR: Final = "#A3ACB5"
GREY: Final = "#6E7781"
INK: Final = "#1F2933"
FAINT: Final = "#C9CFD6"
LIMIT_COLOR: Final = "#B00020"
MARKERS: Final = {BLUE: "o", VERMILLION: "s", GREEN: "^", PURPLE: "D", SKY: "v", ORANGE: "P"}
MOUNT_STYLES: Final = ((PURPLE, 2.9), (ORANGE, 2.1), (GREEN, 1.3), ("#1A1A1A", 0.6))
"""Colour and line width of each mount: later ones are thinner, so that lines which coincide all show."""

STYLE: Final[Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.5,
    "figure.titlesize": 10.5,
    "figure.titleweight": "bold",
    "axes.labelsize": 9.5,
    "axes.labelcolor": INK,
    "axes.edgecolor": "#8A939C",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.formatter.useoffset": False,
    "grid.color": "#E4E7EB",
    "grid.linewidth": 0.7,
    "text.color": INK,
    "text.parse_math": False,  # names are the user's, and a dollar in them is a dollar
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.8,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.2,
    "legend.labelspacing": 0.3,
    "legend.borderpad": 0.2,
    "svg.fonttype": "none",
    "svg.hashsalt": "ehamj",
}

FONTS: Final = "'Segoe UI', Roboto, Helvetica, Arial, 'Liberation Sans', sans-serif"
"""Fonts of the text in an SVG: none is wider than the one that the layout is computed with."""

BAND_TICKS: Final = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)
STRETCHES: Final = 500
"""Stretches of time that a long record is drawn in."""

FAR_LIMIT: Final = 20.0
"""Limits further away than this many times the data's peak are named and not drawn."""

QUIETEST: Final = 0.01
"""Lowest velocity on a criterion plot [µm/s]."""


@dataclass(frozen=True)
class Levels:
    """A line over frequency bands: centres [Hz] and values, NaN where nothing is known, (bands,) each."""

    label: str
    frequency: Array
    values: Array
    color: str


@dataclass(frozen=True)
class Trace:
    """A line over time: times [s], (n,), and values, (n,), or (n, lines) of which the envelope is drawn."""

    label: str
    time: Array
    values: Array
    color: str
    width: float = 1.1
    dash: str = "-"


@dataclass(frozen=True)
class Limit:
    """Values that a quantity cannot or may not pass."""

    label: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Foot:
    """One mount of the drawing: its name, position [m] and what stands there."""

    name: str
    x: float
    y: float
    kind: str


# --- thinning ------------------------------------------------------------------------------------------------------


def envelope(time: Array, values: Array, most: int = STRETCHES) -> tuple[Array, Array, Array]:
    """Lowest and highest value in each of at most ``most`` stretches of a record; no peak is lost.

    Args:
        time: (n,) [s].
        values: (n,), or (n, lines), of which the lowest and highest line count; NaN is left out.
        most: number of stretches.

    Returns:
        Middle of each stretch [s], lowest and highest value, (stretches,) each.
    """
    columns = np.asarray(values, float).reshape(len(time), -1)
    low, high = np.fmin.reduce(columns, axis=1), np.fmax.reduce(columns, axis=1)
    if len(time) <= most:
        return np.asarray(time, float), low, high
    size = -(-len(time) // most)
    starts = np.arange(0, len(time), size)
    middle = time[np.minimum(starts + size // 2, len(time) - 1)]
    return middle, np.fmin.reduceat(low, starts), np.fmax.reduceat(high, starts)


def thinned(time: Array, values: Array, most: int = 3 * STRETCHES) -> tuple[Array, Array]:
    """A line of at most about ``2·most`` points that keeps every peak: lowest and highest value of each stretch.

    Args:
        time: (n,) [s].
        values: (n,).
        most: points up to which nothing is changed.
    """
    if len(time) <= most:
        return time, values
    middle, low, high = envelope(time, values, most)
    half = 0.25 * (middle[1] - middle[0])
    return np.column_stack([middle - half, middle + half]).ravel(), np.column_stack([low, high]).ravel()


# --- figures -------------------------------------------------------------------------------------------------------


@contextmanager
def _styled() -> Iterator[None]:
    import matplotlib

    with matplotlib.rc_context(STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # the reader's fonts draw the text, not these
        yield


def _figure(title: str) -> "Figure":
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH / INCH, WIDTH / INCH))
    figure.suptitle(title)
    return figure


def _arrange(
    figure: "Figure", panels: Sequence[tuple["Axes", float]], entries: Mapping[str, "Artist"], right: float = 14.0
) -> None:
    """Place title, legend and axes below each other, the same margins in every figure.

    Fixed places cost a quarter of what Matplotlib's own layouts do.

    Args:
        figure: whose height is set.
        panels: axes from top to bottom, each with its height [pt].
        entries: of the legend, which stands between title and axes, over no data.
        right: margin on the right [pt].
    """
    columns = _columns(list(entries), WIDTH - LEFT)
    rows = -(-len(entries) // columns)
    title, legend = 24.0, 12.0 * rows + 8.0
    height = title + legend + sum(panel for _, panel in panels) + BELOW * len(panels)
    figure.set_size_inches(WIDTH / INCH, height / INCH)
    figure.suptitle(figure.get_suptitle(), x=6.0 / WIDTH, y=1.0 - 6.0 / height, ha="left", va="top")
    if entries:
        place = (LEFT / WIDTH, 1.0 - title / height)
        handles, names = list(entries.values()), list(entries)
        figure.legend(handles, names, loc="upper left", bbox_to_anchor=place, ncols=columns, borderaxespad=0.0)
    top, width = height - title - legend, WIDTH - LEFT - right
    for axes, panel in panels:
        axes.set_position((LEFT / WIDTH, (top - panel) / height, width / WIDTH, panel / height))
        axes.yaxis.set_label_coords(-44.0 / width, 0.5)
        top -= panel + BELOW


def _columns(names: Sequence[str], room: float) -> int:
    """How many columns of a legend fit into ``room`` [pt]; it is filled column by column."""
    for columns in range(min(len(names), 4), 1, -1):
        widths = [max(map(len, part)) for part in np.array_split(np.array(names, object), columns)]
        if sum(5.3 * width + 32.0 for width in widths) <= room:
            return columns
    return 1


def shown(label: str) -> str:
    """A label as a legend can show it: not endless, and no underscore first, which would hide it."""
    label = label if len(label) <= 36 else label[:35] + "…"
    return f"\u2009{label}" if label.startswith("_") else label


def attenuation(title: str, curves: Sequence[Levels]) -> "Figure":
    """Attenuation [dB] over third-octave bands; up is quieter than the floor."""
    from matplotlib.lines import Line2D

    with _styled():
        figure = _figure(title)
        axes = figure.add_subplot()
        _band_axis(axes, curves)
        values = np.concatenate([curve.values[np.isfinite(curve.values)] for curve in curves] or [np.zeros(0)])
        bottom = min(-10.0, 10.0 * math.floor(float(values.min(initial=0.0)) / 10.0))
        top = max(10.0, 10.0 * math.ceil(float(values.max(initial=0.0)) / 10.0))
        axes.set_ylim(bottom, top)
        axes.axhspan(bottom, 0.0, color="#FBEDEA", zorder=0)
        axes.axhline(0.0, color=GREY, linewidth=1.2)
        axes.set_ylabel("attenuation [dB], up = quieter")
        entries = _band_lines(axes, curves)
        entries["as the floor (0 dB)"] = Line2D([], [], color=GREY, linewidth=1.2)
        _arrange(figure, [(axes, 150.0)], entries)
    return figure


def criterion(
    title: str, curves: Sequence[Levels], classes: Mapping[str, tuple[Array, Array]], known_to: float | None = None
) -> "Figure":
    """Third-octave RMS velocity [µm/s] over bands, with the curves of vibration classes.

    Args:
        title: of the figure.
        curves: levels [µm/s].
        classes: name → band centres [Hz] and limits [µm/s] of each class, drawn where they are in sight.
        known_to: frequency above which the ground is not known [Hz].
    """
    from matplotlib.patches import Patch
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    with _styled():
        figure = _figure(title)
        axes = figure.add_subplot()
        _band_axis(axes, curves)
        axes.set_yscale("log")
        parts = [curve.values[np.isfinite(curve.values) & (curve.values > 0)] for curve in curves]
        values = np.concatenate(parts or [np.zeros(0)])
        bottom = min(0.3, max(QUIETEST, float(values.min(initial=1.0)) / 1.5))
        top = max(100.0, 1.5 * float(values.max(initial=1.0)))
        axes.set_ylim(bottom, top)
        axes.yaxis.set_major_locator(LogLocator(10))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.set_ylabel("RMS velocity per band [µm/s]")
        for name, (frequency, limit) in classes.items():
            level = float(limit[-1])
            if not bottom * 1.1 < level < top:
                continue
            axes.plot(frequency, limit, color="#4B5563", linewidth=0.9, gid=f"class-{name}".replace(" ", "-"))
            axes.plot([frequency[-1], axes.get_xlim()[1]], [level] * 2, color=FAINT, linewidth=0.8, linestyle=":")
            place = (axes.get_xlim()[1], level)
            axes.annotate(name, place, (4, 0), textcoords="offset points", va="center", fontsize=8, color="#374151")
        entries = _band_lines(axes, [replace(curve, values=_positive(curve.values)) for curve in curves])
        if known_to is not None and known_to < axes.get_xlim()[1]:
            axes.axvspan(known_to, axes.get_xlim()[1], color="#EEF0F3", zorder=0)
            entries[f"floor not known above {known_to:.3g} Hz"] = Patch(color="#E3E6EA")
        _arrange(figure, [(axes, 190.0)], entries, right=76.0)
    return figure


def _positive(values: Array) -> Array:
    """Values that a logarithmic axis can show."""
    return np.where(values > 0, values, np.nan)


def _band_axis(axes: "Axes", curves: Sequence[Levels]) -> None:
    """A logarithmic axis of frequency that spans all bands, known or not."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    axes.set_xscale("log")
    frequency = np.concatenate([curve.frequency for curve in curves] or [np.array([1.0, 100.0])])
    axes.set_xlim(float(frequency.min()) / 1.12, float(frequency.max()) * 1.12)
    axes.xaxis.set_major_locator(FixedLocator(list(BAND_TICKS)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xlabel("third-octave band [Hz]")


def _band_lines(axes: "Axes", curves: Sequence[Levels]) -> "dict[str, Artist]":
    """Draw the curves, earlier ones thinner and on top, so that those which coincide all show. Returns the legend."""
    entries: dict[str, Artist] = {}
    for place, curve in enumerate(curve for curve in curves if curve.color != FLOOR_COLOR):
        (entries[shown(curve.label)],) = axes.plot(
            curve.frequency,
            curve.values,
            color=curve.color,
            linewidth=1.4 + 0.9 * place,
            marker=MARKERS.get(curve.color, "o"),
            markersize=3.4 + 1.6 * place,
            zorder=3.0 - 0.1 * place,
        )
    floors: dict[str, Artist] = {}
    for curve in curves:
        if curve.color == FLOOR_COLOR:
            (floors[shown(curve.label)],) = axes.plot(
                curve.frequency, curve.values, color=curve.color, linewidth=4.5, zorder=2.2, solid_capstyle="round"
            )
    return floors | entries


def history(
    title: str,
    quantity: str,
    whole: Sequence[Trace],
    detail: Sequence[Trace],
    limits: Sequence[Limit] = (),
    window: tuple[float, float] | None = None,
) -> "Figure":
    """Time histories: above, the envelope of the whole run with its limits; below, every line in a part of it.

    Args:
        title: of the figure.
        quantity: what the values are, with unit, such as ``command [V]``.
        whole: what is drawn over the whole run.
        detail: what is drawn in the window.
        limits: drawn in the upper part, unless they are further off than `FAR_LIMIT` peaks: then they are only named.
        window: from when to when the lower part goes [s]; without, there is no lower part and ``detail`` is drawn in
            the upper one.
    """
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    with _styled():
        figure = _figure(title)
        above, *below = figure.subplots(2 if window else 1, 1, squeeze=False)[:, 0]
        entries: dict[str, Artist] = {}
        if window:
            for trace in whole:
                entries.setdefault(shown(trace.label), _band_over_time(above, trace))
            above.axvspan(*window, color="#FFF3C4", zorder=0)
        for axes in below or (above,):
            for trace in detail:
                entries.setdefault(shown(trace.label), _line_over_time(axes, trace, window))
            if window:
                axes.set_xlim(*window)
        entries |= _limits(above, [*whole, *([] if window else detail)], limits)
        for axes in (above, *below):
            axes.set_ylabel(quantity)
            axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 2.5, 5, 10], min_n_ticks=3))
            axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}".replace("-", "−")))
        if window:
            above.set_xlabel("time [s], whole run")
            below[0].set_xlabel(f"time [s], the {window[1] - window[0]:.3g} s marked above")
            above.margins(x=0)
        else:
            above.set_xlabel("time [s]")
        _arrange(figure, [(axes, 92.0 if window else 140.0) for axes in (above, *below)], entries)
    return figure


def _finite(values: Array) -> Array:
    """Values that can be drawn: what is not finite, or of absurd size in a run that failed, is left out."""
    return np.where(np.abs(values) < 1e30, values, np.nan)


def _band_over_time(axes: "Axes", trace: Trace) -> "Artist":
    time, low, high = envelope(trace.time, _finite(trace.values))
    return axes.fill_between(time, low, high, facecolor=trace.color, edgecolor=trace.color, linewidth=0.6, alpha=0.85)


def _line_over_time(axes: "Axes", trace: Trace, window: tuple[float, float] | None) -> "Artist":
    inside = slice(None)
    if window:
        first, last = np.searchsorted(trace.time, window)
        inside = slice(max(int(first) - 1, 0), int(last) + 1)
    time, values = thinned(trace.time[inside], _finite(trace.values[inside]))
    (line,) = axes.plot(time, values, color=trace.color, linewidth=trace.width, linestyle=trace.dash)
    return line


def _limits(axes: "Axes", traces: Sequence[Trace], limits: Sequence[Limit]) -> dict[str, "Artist"]:
    """Draw limits that are near enough to matter, and name all."""
    from matplotlib.lines import Line2D

    values = [_finite(trace.values) for trace in traces]
    peak = max((float(np.nanmax(np.abs(part), initial=0.0)) for part in values if part.size), default=0.0)
    entries: dict[str, Artist] = {}
    for limit in limits:
        near = [value for value in limit.values if abs(value) <= FAR_LIMIT * peak]
        for value in near:
            axes.axhline(value, color=LIMIT_COLOR, linewidth=1.1, linestyle=(0, (5, 2)))
        if near:
            entries[limit.label] = Line2D([], [], color=LIMIT_COLOR, linewidth=1.1, linestyle=(0, (4, 2)))
        else:
            entries[f"{limit.label}: far outside"] = Line2D([], [], linestyle="none")
    return entries


# --- the machine ---------------------------------------------------------------------------------------------------


def machine_plan(size: Vector, cg: Vector, feet: Sequence[Foot], waves: Sequence[tuple[str, float]] = ()) -> "Figure":
    """The machine from above, to scale, origin at the mount plane's centre [m].

    Args:
        size: outline: length in x, width in y, height [m].
        cg: centre of gravity [m].
        feet: the four mounts.
        waves: label and direction of travel, from +x towards +y [deg], of each wave in the floor.
    """
    from matplotlib.patches import Rectangle

    length, width, _ = size
    with _styled():
        figure = _figure("The machine from above")
        axes, scale, room, foot_size = _view(figure, size)
        high = width + 2.0 * room
        axes.set_ylim(-0.5 * high, 0.5 * high)
        axes.add_patch(Rectangle((-length / 2, -width / 2), length, width, facecolor="#F3F4F6", edgecolor=INK))
        colors = _foot_colors(feet)
        for foot in feet:
            _square(axes, foot.x, foot.y - foot_size / 2, foot_size, colors[foot.kind])
            inward, outer = (-1 if foot.y > 0 else 1), (1 if foot.x > 0 else -1)
            place = (foot.x + outer * foot_size / 2, foot.y + inward * 0.7 * foot_size)
            axes.text(*place, foot.name, ha="right" if outer > 0 else "left", va="top" if inward < 0 else "bottom")
        right = sorted(sorted(feet, key=lambda foot: foot.y)[:2], key=lambda foot: foot.x)
        front = sorted(sorted(feet, key=lambda foot: foot.x)[2:], key=lambda foot: foot.y)
        _dimension(axes, (right[0].x, right[1].x), -width / 2 - foot_size, "x")
        _dimension(axes, (front[0].y, front[1].y), length / 2 + foot_size, "y")
        _dimension(axes, (-length / 2, length / 2), width / 2 + foot_size, "x")
        _waves(axes, waves[:3], room)
        _tripod(axes, "y", 2.2 * foot_size)
        entries: dict[str, Artist] = dict([_cg(axes, cg, 1, 0.4 * foot_size)])
        axes.set_ylabel("y [m]")
        _arrange(figure, [(axes, scale * high)], {**_foot_entries(feet), **entries})
    return figure


def machine_side(size: Vector, cg: Vector, feet: Sequence[Foot]) -> "Figure":
    """The machine from its right side, at the scale of `machine_plan` [m]; mounts are drawn of some height."""
    from matplotlib.patches import Rectangle

    length, _, height = size
    with _styled():
        figure = _figure("The machine from the right")
        axes, scale, room, foot_size = _view(figure, size)
        low, high = -2.2 * foot_size, height + 0.5 * room
        axes.set_ylim(low, high)
        axes.add_patch(Rectangle((-length / 2, 0.0), length, height, facecolor="#F3F4F6", edgecolor=INK))
        colors = _foot_colors(feet)
        for foot in sorted(feet, key=lambda foot: -foot.y):
            _square(axes, foot.x, -foot_size, foot_size, colors[foot.kind])
        ends = axes.get_xlim()
        ground = Rectangle((ends[0], -1.6 * foot_size), ends[1] - ends[0], 0.6 * foot_size, linewidth=0.0, hatch="////")
        ground.set(facecolor="white", edgecolor=GREY)
        axes.add_patch(ground)
        axes.plot(ends, [-foot_size] * 2, color=GREY, linewidth=1.4)
        _dimension(axes, (0.0, height), length / 2 + foot_size, "y")
        if cg[2] > 1.5 * foot_size:
            _dimension(axes, (0.0, cg[2]), -length / 2 - foot_size, "y")
        _tripod(axes, "z", 2.2 * foot_size)
        entries: dict[str, Artist] = dict([_cg(axes, cg, 2, 0.4 * foot_size)])
        axes.set_ylabel("z [m]")
        _arrange(figure, [(axes, scale * (high - low))], {**_foot_entries(feet), **entries})
    return figure


def _view(figure: "Figure", size: Vector) -> tuple["Axes", float, float, float]:
    """Axes of a drawing, its scale [pt/m], the room beside the machine [m], the side of a mount's square [m]."""
    length, width, height = size
    larger = max(length, width)
    room = 0.2 * larger
    across = WIDTH - LEFT - 14.0
    scale = min(across / (length + 2.0 * room), 300.0 / (max(width, height) + 2.0 * room))
    axes = figure.add_subplot()
    axes.set_xlim(-0.5 * across / scale, 0.5 * across / scale)
    axes.set_xlabel("x [m], front to the right")
    axes.grid(False)
    return axes, scale, room, 0.08 * larger


def _foot_colors(feet: Sequence[Foot]) -> dict[str, str]:
    kinds = dict.fromkeys(foot.kind for foot in feet)
    return dict(zip(kinds, itertools.cycle((BLUE, GREEN, PURPLE, ORANGE)), strict=False))


def _foot_entries(feet: Sequence[Foot]) -> dict[str, "Artist"]:
    from matplotlib.patches import Patch

    return {f"mount: {shown(kind)}": Patch(color=color) for kind, color in _foot_colors(feet).items()}


def _square(axes: "Axes", x: float, bottom: float, side: float, color: str) -> None:
    from matplotlib.patches import Rectangle

    axes.add_patch(Rectangle((x - side / 2, bottom), side, side, color=color))


def _cg(axes: "Axes", cg: Vector, up: int, radius: float) -> tuple[str, "Artist"]:
    """The draughtsman's mark of a centre of gravity; ``up`` is the axis that points up. Returns its legend entry."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Circle, Wedge

    place = (cg[0], cg[up])
    axes.add_patch(Circle(place, radius, facecolor="white", edgecolor=INK, zorder=4))
    for first in (0.0, 180.0):
        axes.add_patch(Wedge(place, radius, first, first + 90.0, facecolor=INK, zorder=4))
    mark = Line2D([], [], linestyle="none", marker="o", markersize=8, fillstyle="left", color=INK)
    mark.set_markerfacecoloralt("white")
    place_text = ", ".join(f"{part:.3g}" for part in cg).replace("-", "−")
    return f"centre of gravity ({place_text}) m", mark


def _tripod(axes: "Axes", up: str, length: float) -> None:
    for tip, name in (((length, 0.0), "x"), ((0.0, length), up)):
        style = {"arrowstyle": "-|>", "color": LIMIT_COLOR, "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", tip, (0.0, 0.0), arrowprops=style)
        beyond = (5, 7) if name == "x" else (0, 6)
        axes.annotate(name, tip, beyond, textcoords="offset points", color=LIMIT_COLOR, ha="center", va="center")


def _dimension(axes: "Axes", ends: tuple[float, float], at: float, along: str) -> None:
    """A dimension line from end to end, at a distance, with its length [m]."""
    style = {"arrowstyle": "<|-|>", "color": "#4B5563", "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
    first, last = ((end, at) if along == "x" else (at, end) for end in ends)
    axes.annotate("", last, first, arrowprops=style)
    middle = (0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1]))
    box = {"boxstyle": "square,pad=0.15", "facecolor": "white", "edgecolor": "none"}
    turned = 90.0 if along == "y" else 0.0
    text = f"{abs(ends[1] - ends[0]):.4g}"
    axes.text(*middle, text, ha="center", va="center", rotation=turned, fontsize=8.8, color="#374151", bbox=box)


def _waves(axes: "Axes", waves: Sequence[tuple[str, float]], room: float) -> None:
    """Arrows in the margin on the left that show where waves in the floor go."""
    (left, _), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    step = (top - bottom) / (len(waves) + 1)
    for place, (label, direction) in enumerate(waves, start=1):
        x, y = left + 0.5 * room, top - place * step
        reach = 0.3 * room * np.array([math.cos(math.radians(direction)), math.sin(math.radians(direction))])
        style = {"arrowstyle": "-|>", "color": GREY, "linewidth": 2.0, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (x + reach[0], y + reach[1]), (x - reach[0], y - reach[1]), arrowprops=style)
        axes.text(x, y - 0.4 * room, label, va="top", ha="center", fontsize=8.8, color="#4B5563")


# --- SVG -----------------------------------------------------------------------------------------------------------


def svg(figure: "Figure", name: str) -> str:
    """The figure as an SVG file: text as text, the same bytes every time, its ids beginning with ``name``."""
    title = figure.get_suptitle()
    with _styled(), io.StringIO() as file:
        figure.savefig(file, format="svg", metadata={"Date": None, "Creator": None, "Title": title})
        text = file.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>\s*", "", text, flags=re.DOTALL)
    text = re.sub(r"<!--.*?-->\s*", "", text, flags=re.DOTALL)
    text = re.sub(r"<!DOCTYPE.*?>\s*", "", text, flags=re.DOTALL)
    text = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", text)
    text = re.sub(r' d="[^"]*"', lambda path: re.sub(r"(\.\d\d)\d+", r"\1", path.group()), text)
    return text.replace("'DejaVu Sans', sans-serif", FONTS)


def inline(text: str) -> str:
    """An SVG file as a part of an HTML page: without the prologue, scaled by the page."""
    text = re.sub(r"<\?xml.*?\?>\s*", "", text, count=1, flags=re.DOTALL)
    return re.sub(r' xmlns:xlink="[^"]*"', "", text, count=1)
