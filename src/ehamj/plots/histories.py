"""Figures over time, thinned so that no peak is lost."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.plots import style
from ehamj.plots.axes import linear_axis
from ehamj.plots.style import Artist, Axes, Figure

STRETCHES: Final = 500
"""Stretches of time that a long record is drawn in."""

SEEN: Final = 0.2
"""Share of the loudest below which a line beside it shows nothing of its course [-]."""

FAR_LIMIT: Final = 20.0
"""Limits further away than this many times the data's peak are named and not drawn."""


@dataclass(frozen=True)
class Trace:
    """A line over time: times [s], (n,), and values, (n,), or (n, lines) of which the envelope is drawn."""

    label: str
    time: Array
    values: Array
    color: str
    width: float = 1.1
    dash: str = "-"

    def within(self, window: tuple[float, float] | None) -> "Trace":
        """The part of it in a window of time [s]."""
        if window is None:
            return self
        part = slice(*np.searchsorted(self.time, window))
        return replace(self, time=self.time[part], values=self.values[part])


@dataclass(frozen=True)
class Limit:
    """Values that a quantity cannot or may not pass."""

    label: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Moment:
    """A time [s] at which something happened."""

    label: str
    time: float


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


@style.styled()
def history(
    title: str,
    quantity: str,
    whole: Sequence[Trace],
    detail: Sequence[Trace],
    limits: Sequence[Limit] = (),
    window: tuple[float, float] | None = None,
    closer: Sequence[Sequence[Trace]] = (),
    moments: Sequence[Moment] = (),
) -> Figure:
    """Time histories: above, the envelope of the whole run with its limits; below, every line in a part of it.

    Args:
        title: of the figure.
        quantity: what the values are, with unit, such as ``command [V]``.
        whole: what is drawn over the whole run.
        detail: what is drawn in the window; of several lines together the band between lowest and highest.
        limits: drawn in the upper part, unless they are further off than `FAR_LIMIT` peaks: then they are only named.
        window: from when to when the lower part goes [s]; without, there is no lower part and ``detail`` is drawn in
            the upper one.
        closer: traces of ``detail`` that are too small to be seen there, each group again at a scale of its own.
        moments: marked by upright lines.
    """
    figure, (above, *below) = style.new_figure(title, (2 if window else 1) + len(closer))
    entries: dict[str, Artist] = {}
    if window:
        for trace in whole:
            entries.setdefault(style.shown(trace.label), _band_over_time(above, trace))
        above.axvspan(*window, color="#FFF3C4", zorder=0)
        above.margins(x=0)
        above.set_xlabel("time [s], whole run")
    in_full = below if window else [above, *below]
    for axes, traces in zip(in_full, (detail, *closer), strict=True):
        for trace in traces:
            entries.setdefault(style.shown(trace.label), _line_over_time(axes, trace, window))
        axes.set_xlabel("time [s]")
        if window:
            axes.set_xlim(*window)
            axes.set_xlabel(f"time [s], the {window[1] - window[0]:.3g} s marked above")
    for axes in (above, *below):
        entries |= _moments(axes, moments, window if axes in below else None)
    entries |= _limits(above, [*whole, *([] if window else detail)], limits)
    panels = [above, *below]
    for k, axes in enumerate(panels):
        own = k >= len(panels) - len(closer)
        axes.set_ylabel(f"own scale [{quantity.partition('[')[2]}" if own else quantity)
        linear_axis(axes.yaxis)
    style.share(in_full)
    gaps = [12.0 if axes in in_full[:-1] else style.BELOW for axes in panels]
    height = 92.0 if window else 140.0
    style.arrange(figure, [(axes, height if k < 2 else 70.0) for k, axes in enumerate(panels)], entries, gaps=gaps)
    return figure


def quieter(traces: Sequence[Trace]) -> list[list[Trace]]:
    """Groups that need a scale of their own beside all of them: what is below `SEEN` of the loudest, then of that."""
    groups, left = [], list(traces)
    while left:
        sizes = [float(np.nanmax(np.abs(finite(trace.values)), initial=0.0)) for trace in left]
        left = [trace for trace, size in zip(left, sizes, strict=True) if 0.0 < size < SEEN * max(sizes)]
        if left:
            groups.append(left)
    return groups


def finite(values: Array) -> Array:
    """Values that can be drawn: what is not finite, or of absurd size in a run that failed, is left out."""
    return np.where(np.abs(values) < 1e30, values, np.nan)


def _band_over_time(axes: Axes, trace: Trace) -> Artist:
    time, low, high = envelope(trace.time, finite(trace.values))
    return axes.fill_between(time, low, high, facecolor=trace.color, edgecolor=trace.color, linewidth=0.6, alpha=0.85)


def _line_over_time(axes: Axes, trace: Trace, window: tuple[float, float] | None) -> Artist:
    inside = slice(None)
    if window:
        first, last = np.searchsorted(trace.time, window)
        inside = slice(max(int(first) - 1, 0), int(last) + 1)
    if trace.values.ndim > 1:
        return _band_over_time(axes, replace(trace, time=trace.time[inside], values=trace.values[inside]))
    time, values = thinned(trace.time[inside], finite(trace.values[inside]))
    (line,) = axes.plot(time, values, color=trace.color, linewidth=trace.width, linestyle=trace.dash)
    return line


def _moments(axes: Axes, moments: Sequence[Moment], window: tuple[float, float] | None) -> dict[str, Artist]:
    """Upright lines at what falls into the window; without one, into the whole run."""
    shown = [one for one in moments if window is None or window[0] <= one.time <= window[1]]
    look: dict[str, Any] = {"color": style.MOMENT_COLOR, "linewidth": 1.3, "linestyle": (0, (1, 1)), "zorder": 4}
    return {one.label: axes.axvline(one.time, **look) for one in shown}


def _limits(axes: Axes, traces: Sequence[Trace], limits: Sequence[Limit]) -> dict[str, Artist]:
    """Draw limits that are near enough to matter, and name all."""
    values = [finite(trace.values) for trace in traces]
    peak = max((float(np.nanmax(np.abs(part), initial=0.0)) for part in values if part.size), default=0.0)
    look: dict[str, Any] = {"color": style.LIMIT_COLOR, "linewidth": 1.1, "linestyle": (0, (5, 2))}
    entries: dict[str, Artist] = {}
    for limit in limits:
        near = [axes.axhline(value, **look) for value in limit.values if abs(value) <= FAR_LIMIT * peak]
        if near:
            entries[limit.label] = near[0]
        else:
            entries[f"{limit.label}: far outside"] = style.line_key(linestyle="none")
    return entries
