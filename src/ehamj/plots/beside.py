"""Measured channels beside predicted ones, and what is left between them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.plots import style
from ehamj.plots.axes import linear_axis, log_axis
from ehamj.plots.histories import thinned
from ehamj.plots.style import Artist, Axes, Figure

HEIGHT: Final = 66.0
"""Of a channel's panel [pt]."""
LEFT_OVER: Final = 30.0
"""Of the panel below it, which shows what is left [pt]."""
DEEPEST: Final = 0.1
"""Share of the least that was measured, or is left, below which a spectrum is not drawn."""
MEASURED: Final[dict[str, Any]] = {"color": "#8A939C", "linewidth": 2.2}
PREDICTED: Final[dict[str, Any]] = {"color": style.BLUE, "linewidth": 1.0}
LEFT: Final[dict[str, Any]] = {"color": style.VERMILLION, "linewidth": 0.9}
NOISE: Final[dict[str, Any]] = {"facecolor": "#FBE3D6", "linewidth": 0.0}
"""Measured wide and grey, the model thin on top of it, what is left in another hue and darkness."""


@dataclass(frozen=True)
class Beside:
    """One channel over ``x``, (n,): measured and predicted, (n,) each, in one unit; ``noise`` is what of the
    rest its noise explains: its standard deviation or its density, (n,) or a number."""

    name: str
    unit: str
    x: Array
    measured: Array
    predicted: Array
    noise: Array | float = 0.0
    said: str = ""
    """What stands at the right above it, such as the fit."""


@style.styled()
def beside_chart(title: str, x: str, channels: Sequence[Beside]) -> Figure:
    """Channels below each other; below each of them what is left, with twice the noise as a band.

    Args:
        title: of the figure.
        x: what the axis is, with unit.
        channels: at least one.
    """
    figure, axes = style.new_figure(title, 2 * len(channels), sharex=True)
    for above, below, one in zip(axes[::2], axes[1::2], channels, strict=True):
        above.plot(*thinned(one.x, one.measured), **MEASURED)
        above.plot(*thinned(one.x, one.predicted), **PREDICTED)
        noise = np.broadcast_to(2.0 * np.asarray(one.noise, float), one.x.shape)
        below.fill_between(one.x[[0, -1]], -noise[[0, -1]], noise[[0, -1]], zorder=1, **NOISE)
        below.plot(*thinned(one.x, one.measured - one.predicted), **LEFT)
        _names(above, one)
        above.set_ylabel(f"[{one.unit}]")
        below.set_ylabel("left")
        linear_axis(above.yaxis)
        linear_axis(below.yaxis, 2)
    last = axes[-1]
    last.margins(x=0)
    last.set_xlabel(x)
    linear_axis(last.xaxis, 6)
    style.share(axes)
    gaps = [4.0, 20.0] * len(channels)
    heights = [HEIGHT, LEFT_OVER] * len(channels)
    style.arrange(figure, list(zip(axes, heights, strict=True)), _entries(noise=True), gaps=gaps, head=14.0)
    return figure


@style.styled()
def spectra_chart(title: str, channels: Sequence[Beside]) -> Figure:
    """Spectral densities of channels, whose ``x`` are frequencies [Hz] and ``noise`` is the density of what is left."""
    figure, axes = style.new_figure(title, len(channels), sharex=True)
    for one, channel in zip(axes, channels, strict=True):
        one.plot(channel.x, channel.measured, **MEASURED)
        one.plot(channel.x, channel.predicted, **PREDICTED)
        one.plot(channel.x, np.broadcast_to(channel.noise, channel.x.shape), **LEFT)
        _names(one, channel)
        one.set_ylabel(f"[{channel.unit}]")
        one.set_ylim(bottom=DEEPEST * min(float(channel.measured.min()), float(np.min(channel.noise))))
        log_axis(one.yaxis, few=True)
    last = axes[-1]
    last.margins(x=0)
    last.set_xlabel("frequency [Hz]")
    log_axis(last.xaxis)
    style.share(axes)
    style.arrange(figure, [(one, HEIGHT) for one in axes], _entries(noise=False), gap=20.0, head=14.0)
    return figure


def _names(axes: Axes, one: Beside) -> None:
    """The channel's name and what is said of it, above its panel."""
    axes.set_title(style.shown(one.name, 46), loc="left", fontsize=8.8, pad=3.0)
    if one.said:
        axes.set_title(one.said, loc="right", fontsize=8.8, color=style.GREY, pad=3.0)


def _entries(noise: bool) -> dict[str, Artist]:
    entries = {
        "measured": style.line_key(**MEASURED),
        "model": style.line_key(**PREDICTED),
        "left": style.line_key(**LEFT),
    }
    return entries | ({"twice the noise": style.patch_key(**NOISE)} if noise else {})
