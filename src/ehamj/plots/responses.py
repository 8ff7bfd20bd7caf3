"""Frequency responses: magnitude, phase and coherence over frequency, and the matrix of all magnitudes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.plots import style
from ehamj.plots.axes import decibel_axis, fixed_axis, frequency_axis
from ehamj.plots.style import Artist, Axes, Figure

MANY: Final = 120
"""Measured lines above which a response is drawn as a line instead of markers."""
DEEPEST: Final = -100.0
"""Magnitude below which nothing is drawn [dB]."""


@dataclass(frozen=True)
class Response:
    """One curve: complex response over frequency [Hz]; what was measured has coherences and a confidence radius.

    Where the radius reaches zero, nothing but coherence is drawn: neither magnitude nor phase is known there.
    """

    label: str
    frequency: Array
    response: NDArray[np.complex128]
    color: str
    radius: Array | None = None
    multiple: Array | None = None
    ordinary: Array | None = None

    @property
    def measured(self) -> bool:
        """Whether it was measured."""
        return self.multiple is not None

    @property
    def known(self) -> NDArray[np.complex128]:
        """The response where it is known to differ from zero, NaN elsewhere."""
        if self.radius is None:
            return self.response
        return np.where(self.radius < np.abs(self.response), self.response, np.nan)


@style.styled()
def response(title: str, curves: Sequence[Response], unit: str, confidence: float = 0.95) -> Figure:
    """Magnitude [dB], phase [deg] and, of what was measured, coherence.

    Args:
        title: of the figure.
        curves: linear ones are lines; measured ones markers with a band of confidence.
        unit: of the response: the magnitude is over 1 ``unit``.
        confidence: probability of the band, for the legend.
    """
    coherent = any(curve.measured for curve in curves)
    figure, (above, middle, *below) = style.new_figure(title, 3 if coherent else 2)
    entries: dict[str, Artist] = {}
    for place, curve in enumerate(curves):
        entries[style.shown(curve.label)] = _magnitude(above, curve, 3.0 - 0.1 * place)
        _line(middle, curve, np.degrees(np.angle(curve.known)), 3.0 - 0.1 * place)
    _decibels(above, curves)
    above.axhline(0.0, color=style.GREY, linewidth=1.0, zorder=1)
    above.set_ylabel(f"magnitude [dB re 1 {unit}]")
    middle.set(ylim=(-190, 190), ylabel="phase [°]")
    fixed_axis(middle.yaxis, (-180, -90, 0, 90, 180))
    if below:
        entries |= _coherence(below[0], curves)
        entries[f"{100 * confidence:g} % confidence"] = style.patch_key(color=style.GREY, alpha=0.35)
    panels = list(zip((above, middle, *below), (120.0, 70.0, 56.0), strict=False))
    for axes, _ in panels:
        _frequency_axis(axes, curves)
    style.share(axes for axes, _ in panels)
    style.arrange(figure, panels, entries, gap=10.0)
    return figure


def _coherence(axes: Axes, curves: Sequence[Response]) -> dict[str, Artist]:
    """Multiple coherences, and ordinary ones where they differ. Returns what the legend says of both, if any does."""
    multiple: dict[str, Any] = {"linewidth": 1.5}
    ordinary: dict[str, Any] = {"linewidth": 0.9, "linestyle": ":"}
    several = False
    for curve in curves:
        if curve.multiple is not None and curve.ordinary is not None:
            axes.plot(curve.frequency, curve.multiple, color=curve.color, **multiple)
            if not np.allclose(curve.multiple, curve.ordinary, equal_nan=True):
                several = True
                axes.plot(curve.frequency, curve.ordinary, color=curve.color, **ordinary)
    axes.set(ylim=(-0.03, 1.05), ylabel="coherence [-]")
    fixed_axis(axes.yaxis, (0, 0.5, 1))
    looks = {"multiple coherence": multiple, "ordinary coherence": ordinary} if several else {}
    return {name: style.line_key(color=style.GREY, **look) for name, look in looks.items()}


@style.styled()
def response_matrix(
    title: str, rows: Sequence[str], columns: Sequence[str], curves: Mapping[tuple[str, str], Sequence[Response]],
    unit: str,
) -> Figure:  # fmt: skip
    """Magnitudes [dB] of a matrix of responses, all panels with the same axes.

    Args:
        title: of the figure.
        rows: names of the outputs.
        columns: names of the inputs.
        curves: by row and column; elements that are missing are zero and stay empty.
        unit: of the magnitudes, for the axes' label.
    """
    everything = [curve for part in curves.values() for curve in part]
    figure, grid = style.new_grid(title, len(rows), len(columns), sharex=True, sharey=True)
    entries: dict[str, Artist] = {}
    for (i, row), (j, column) in product(enumerate(rows), enumerate(columns)):
        axes = grid[i, j]
        for place, curve in enumerate(curves.get((row, column), ())):
            entries.setdefault(style.shown(curve.label), _magnitude(axes, curve, 3.0 - 0.1 * place, small=True))
        if (row, column) not in curves:
            axes.text(0.5, 0.5, "0", transform=axes.transAxes, ha="center", va="center", color=style.GREY)
        if i == 0:
            axes.set_title(f"floor {column}", fontsize=8.8)
        if j == 0:
            axes.set_ylabel(row, fontsize=8.8)
        axes.tick_params(labelsize=7.5, length=2)
    first = grid[0, 0]
    _frequency_axis(first, everything, few=True)
    first.set_xlabel("")
    _decibels(first, everything)
    figure.supxlabel("frequency [Hz]", fontsize=9.5, y=0.005)
    figure.supylabel(f"machine: magnitude [dB re 1 {unit}]", fontsize=9.5, x=0.005)
    size = 78.0
    width = max(style.WIDTH, style.LEFT + 12.0 + size * len(columns))
    beside = style.legend_columns(list(entries), width - style.LEFT)
    head = 50.0 + 12.0 * -(-len(entries) // beside)
    height = head + style.BELOW + size * len(rows)
    figure.set_size_inches(width / style.INCH, height / style.INCH)
    figure.suptitle(title, x=6.0 / width, y=1.0 - 6.0 / height, ha="left", va="top")
    left, bottom = style.LEFT / width, style.BELOW / height
    figure.subplots_adjust(left, bottom, 1 - 12.0 / width, 1 - head / height, wspace=0.08, hspace=0.08)
    style.legend(figure, entries, (left, 1.0 - 24.0 / height), beside)
    return figure


def _magnitude(axes: Axes, curve: Response, order: float, small: bool = False) -> Artist:
    size = np.abs(curve.known)
    if curve.radius is not None:
        low, high = _in_decibels(size - curve.radius), _in_decibels(size + curve.radius)
        axes.fill_between(curve.frequency, low, high, color=curve.color, alpha=0.22, linewidth=0.0, zorder=order - 1)
    return _line(axes, curve, _in_decibels(size), order, small)


def _line(axes: Axes, curve: Response, values: Array, order: float, small: bool = False) -> Artist:
    """Linear curves as lines; measured ones as markers, or as a broken line where they are dense."""
    look: dict[str, Any] = {"color": curve.color, "zorder": order}
    if not curve.measured:
        look |= {"linewidth": 1.0 if small else 1.5}
    elif curve.frequency.size > MANY:
        look |= {"linewidth": 1.2, "linestyle": (0, (4, 1.2))}
    else:
        marker = style.MARKERS.get(curve.color, "o")
        look |= {"linestyle": "none", "marker": marker, "markersize": 2.0 if small else 4.0, "fillstyle": "none"}
    (line,) = axes.plot(curve.frequency, values, **look)
    return line


def _in_decibels(size: Array) -> Array:
    with np.errstate(divide="ignore"):
        return np.asarray(np.where(size > 0, 20 * np.log10(size), np.nan))


def _decibels(axes: Axes, curves: Sequence[Response]) -> None:
    parts = [_in_decibels(np.abs(curve.known)) for curve in curves]
    decibel_axis(axes, np.concatenate(parts or [np.zeros(0)]), (0.0, 10.0), DEEPEST)


def _frequency_axis(axes: Axes, curves: Sequence[Response], few: bool = False) -> None:
    ends = [(curve.frequency.min(), curve.frequency.max()) for curve in curves if curve.frequency.size]
    low, high = (min(low for low, _ in ends), max(high for _, high in ends)) if ends else (1.0, 300.0)
    frequency_axis(axes, low / 1.03, high * 1.03, few=few)
