"""Loop gains as control engineers look at them, drawn by python-control: Bode, Nyquist and Nichols plots.

The disk about −1 is that of the balanced disk margin α (σ = 0; Seiler, Packard and Gahinet, IEEE Control Systems 40(5),
2020): a curve that stays out of it keeps |S − 1/2| < 1/α. Its edges on the real axis are (α − 2)/(α + 2) and the
inverse of that.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.plots import style
from ehamj.plots.axes import decibel_axis, frequency_axis, linear_axis
from ehamj.plots.responses import Response
from ehamj.plots.style import Artist, Figure

DEEPEST: Final = -60.0
"""Loop gain below which nothing is drawn [dB]."""
REACH: Final = 3.0
"""Largest magnitude of a Nyquist plot, to which larger ones are bent, so that what is near −1 can be seen."""
BENT: Final = 0.25
"""Share of it over which they are."""
TURN: Final = 180.0
NICHOLS: Final = (-40.0, 40.0)
"""Least range of a Nichols plot [dB]."""
POINTS: Final = 400
"""Of a disk's edge."""

COLORS: Final = (style.BLUE, style.VERMILLION, style.GREEN, style.PURPLE)
STROKES: Final = ("-", (0, (5, 2)), (0, (6, 1.5, 1, 1.5)), (0, (2.5, 1.2)))
"""How the curves of each colour are drawn, so that they are told apart in grey too."""
BODE: Final = "Bode plot of each motion's loop gain, the others closed; lines at 0 dB and −180°."
NYQUIST: Final = (
    "Nyquist plot of the same, with the unit circle: while a motion's curve stays out of the disk, its gain and phase "
    f"may change by what the disk margin says. Curves beyond {(1.0 - BENT) * REACH:g} are dotted and bent to a "
    f"magnitude of {REACH:g}."
)
NICHOLS_PLOT: Final = "Nichols plot of the same: crosses and disks at −180° and what is alike."

NOTHING: Final = 1e-9
"""Loop gain of a place where the law does nothing, but for rounding [-]."""


def loop_figures(
    hertz: Array, gains: Mapping[str, ComplexArray], disk: float, nichols_too: bool = False, of: str = ""
) -> dict[str, tuple[str, Callable[[], Figure]]]:
    """Figures of a control loop by name, each with its caption and what draws it.

    Args:
        hertz: frequencies [Hz].
        gains: complex loop gain by place where the loop is broken; one that is nothing has no curve.
        disk: balanced disk margin whose disk is drawn [-].
        nichols_too: with a Nichols plot.
        of: whose loop it is, where there are several.
    """
    acting = {name: gain for name, gain in gains.items() if np.abs(gain).max() > NOTHING}
    curves = [
        Response(name, hertz, gain, color)
        for (name, gain), color in zip(acting.items(), itertools.cycle(COLORS), strict=False)
    ]
    where = f" of the loop, {of}" if of else " of the loop"
    found: dict[str, tuple[str, Callable[[], Figure]]] = {
        "bode": (BODE, lambda: bode(f"Bode plot{where}", curves)),
        "nyquist": (NYQUIST, lambda: nyquist(f"Nyquist plot{where}", curves, disk)),
    }
    if nichols_too:
        found["nichols"] = (NICHOLS_PLOT, lambda: nichols(f"Nichols plot{where}", curves, disk))
    return found


def _data(curves: Sequence[Response]) -> list[Any]:
    import control

    return [
        control.FrequencyResponseData(np.asarray(one.response, complex), 2 * np.pi * one.frequency, sysname=one.label)
        for one in curves
    ]


def _stroke(number: int) -> Any:
    return STROKES[number % len(STROKES)]


def _entries(curves: Sequence[Response], disk: float | None = None) -> dict[str, Artist]:
    found = {
        style.shown(one.label): style.line_key(color=one.color, linewidth=1.6, linestyle=_stroke(k))
        for k, one in enumerate(curves)
    }
    if disk is not None:
        found[f"disk margin {disk:.2g}"] = style.patch_key(facecolor=style.FAINT, edgecolor=style.LIMIT_COLOR)
    return found


@style.styled()
def bode(title: str, curves: Sequence[Response]) -> Figure:
    """Magnitude [dB] and phase [deg] of loop gains over frequency; lines at 0 dB and −180°, and the like."""
    import control

    figure, (above, below) = style.new_figure(title, 2)
    for k, (one, data) in enumerate(zip(curves, _data(curves), strict=True)):
        control.bode_plot(
            data, ax=np.array([[above], [below]]), dB=True, Hz=True, deg=True, grid=False, show_legend=False, title="",
            color=one.color, linewidth=1.6, linestyle=_stroke(k),
        )  # fmt: skip
    figure.suptitle(title)
    frequencies = np.concatenate([one.frequency for one in curves])
    low, high = float(frequencies.min()), float(frequencies.max())
    levels = np.concatenate([20 * np.log10(np.maximum(np.abs(one.response), 1e-30)) for one in curves])
    decibel_axis(above, levels, (-20.0, 10.0), DEEPEST)
    turns = np.concatenate([np.asarray(line.get_ydata(), float) for line in below.lines])
    seen = levels > DEEPEST
    bottom, top = (float(bound(turns[seen], initial=-TURN)) for bound in (np.min, np.max))
    below.set_ylim(90.0 * np.floor(bottom / 90.0), 90.0 * np.ceil(top / 90.0))
    _quarter_turns(below.yaxis)
    above.axhline(0.0, color=style.GREY, linewidth=1.0, zorder=1.5)
    for turn in np.arange(-20, 20, 2) * TURN - TURN:
        below.axhline(turn, color=style.GREY, linewidth=1.0, zorder=1.5)
    above.set_ylabel("loop gain [dB]")
    below.set_ylabel("phase [deg]")
    for axes in (above, below):
        axes.grid(True)
        frequency_axis(axes, low, high, few=True)
    style.share((above, below))
    style.arrange(figure, [(above, 120.0), (below, 120.0)], _entries(curves), gap=12.0)
    return figure


def _quarter_turns(axis: Any) -> None:
    """Ticks at multiples of 45, 90, 180° …, at most seven."""
    from matplotlib.ticker import MultipleLocator, NullLocator

    low, high = axis.get_view_interval()
    step = next(step for step in (45.0, 90.0, 180.0, 360.0, 720.0, 1440.0, 1e5) if (high - low) / step <= 6.0)
    axis.set_major_locator(MultipleLocator(step))
    axis.set_minor_locator(NullLocator())


@style.styled()
def nyquist(title: str, curves: Sequence[Response], disk: float | None = None) -> Figure:
    """Loop gains in the complex plane about −1; what comes near `REACH` is dotted and bent to it.

    Args:
        title: of the figure.
        curves: loop gains, of rising frequency.
        disk: balanced disk margin whose disk is drawn [-], below 2.
    """
    import control

    figure, (axes,) = style.new_figure(title)
    for k, (one, data) in enumerate(zip(curves, _data(curves), strict=True)):
        before = len(axes.lines)
        control.nyquist_plot(
            data, ax=axes, color=one.color, linewidth=1.6, mirror_style=False, arrows=2, arrow_size=5,
            primary_style=["-", ":"], max_curve_magnitude=REACH, blend_fraction=BENT, start_marker=False,
            unit_circle=one is curves[0], warn_encirclements=False, show_legend=False, title="",
        )  # fmt: skip
        for line in axes.lines[before:]:
            if line.get_linestyle() == "-" and line.get_color() == one.color:  # python-control takes names only
                line.set_linestyle(_stroke(k))
    figure.suptitle(title)
    if disk is not None:
        edge = _disk(disk)
        axes.fill(edge.real, edge.imag, facecolor=style.FAINT, alpha=0.6, zorder=0.5)
        axes.plot(edge.real, edge.imag, color=style.LIMIT_COLOR, linewidth=1.4)
    axes.set(xlim=(-1.1 * REACH, 0.5 * REACH), ylim=(-0.8 * REACH, 0.8 * REACH), xlabel="real part [-]")
    axes.set_ylabel("imaginary part [-]")
    for axis in (axes.xaxis, axes.yaxis):
        linear_axis(axis, 6)
    axes.grid(True, color="#E4E7EB")
    style.arrange(figure, [(axes, 302.0)], _entries(curves, disk))
    return figure


def _disk(margin: float) -> Array:
    """Edge of the disk of a balanced margin, complex (n,)."""
    inner, outer = (margin - 2.0) / (margin + 2.0), (margin + 2.0) / (margin - 2.0)
    turn = np.exp(1j * np.linspace(0.0, 2 * np.pi, POINTS))
    return np.asarray(0.5 * (inner + outer) + 0.5 * (inner - outer) * turn)


@style.styled()
def nichols(title: str, curves: Sequence[Response], disk: float | None = None) -> Figure:
    """Loop gain [dB] over phase [deg] (Nichols), arguments as `nyquist`; each curve begins between −360° and 0°."""
    import control

    figure, (axes,) = style.new_figure(title)
    for k, (one, data) in enumerate(zip(curves, _data(curves), strict=True)):
        look = {"color": one.color, "linewidth": 1.6, "linestyle": _stroke(k)}
        control.nichols_plot(data, ax=axes, grid=False, show_legend=False, title="", **look)
    figure.suptitle(title)
    turns = np.concatenate([np.asarray(line.get_xdata(), float) for line in axes.lines])
    levels = np.concatenate([np.asarray(line.get_ydata(), float) for line in axes.lines])
    seen = levels > NICHOLS[0]
    low, high = (float(bound(turns[seen], initial=-TURN)) for bound in (np.min, np.max))
    low, high = 90.0 * np.floor(min(low, -2 * TURN) / 90.0), 90.0 * np.ceil(max(high, 0.0) / 90.0)
    for about in np.arange(-20, 20, 2) * TURN - TURN:
        axes.plot([about], [0.0], "+", color=style.LIMIT_COLOR, markersize=8, zorder=3)
        if disk is not None:
            edge = _disk(disk)
            phase = about + np.degrees(np.angle(-edge))
            axes.fill(phase, 20 * np.log10(np.abs(edge)), facecolor=style.FAINT, edgecolor=style.LIMIT_COLOR, alpha=0.6)
    axes.axhline(0.0, color=style.GREY, linewidth=1.0, zorder=1.5)
    axes.set(xlim=(low, high), xlabel="phase [deg]", ylabel="loop gain [dB]")
    decibel_axis(axes, levels, NICHOLS, NICHOLS[0])
    _quarter_turns(axes.xaxis)
    axes.grid(True)
    style.arrange(figure, [(axes, 240.0)], _entries(curves, disk))
    return figure
