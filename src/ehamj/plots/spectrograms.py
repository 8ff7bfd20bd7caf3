"""Levels over time and third-octave bands as colours, one panel below the other, of one scale."""

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.plots import style
from ehamj.plots.axes import fixed_axis, linear_axis, log_axis
from ehamj.plots.histories import Moment
from ehamj.plots.style import Artist, Figure

COLORS: Final = "viridis"
DEEPEST: Final = 1e-4
"""Lowest level on the scale, over the highest: 80 dB."""
ROW: Final = 4.6
"""Height of a band [pt]."""
NAMED: Final = ("1", "2", "5", "10", "20", "50", "100", "200")
"""Bands that have their number on the axis."""
LONGEST: Final = 60
"""Letters of a name."""
UNKNOWN: Final = "#E3E6EA"


def scale_of(panels: Sequence[Array], quietest: float) -> tuple[float, float]:
    """Lowest and highest level of a scale that all panels share: round numbers, at most 80 dB apart.

    Args:
        panels: levels; NaN is left out.
        quietest: level below which nobody looks.
    """
    values = np.concatenate([np.ravel(panel) for panel in panels])
    values = values[np.isfinite(values) & (values > 0.0)]
    top = _round(float(values.max(initial=quietest)), up=True)
    bottom = _round(max(float(values.min(initial=top)), quietest, DEEPEST * top), up=False)
    return min(bottom, 0.1 * top), top


def _round(value: float, up: bool) -> float:
    """The nearest of 1, 2, 5·10ⁿ that is not below, or not above, a value."""
    power = 10.0 ** math.floor(math.log10(value) + 1e-9)
    steps = [step * power for step in (1.0, 2.0, 5.0, 10.0)]
    near = 1e-9 * value
    return min(s for s in steps if s >= value - near) if up else max(s for s in steps if s <= value + near)


@style.styled()
def spectrogram(
    title: str,
    time: Array,
    bands: Sequence[str],
    panels: Mapping[str, Array],
    quantity: str,
    quietest: float = 1e-3,
    moments: Sequence[Moment] = (),
) -> Figure:
    """Levels over time in third-octave bands.

    Args:
        title: of the figure.
        time: evenly, ends of the times that the levels are of [s], (t,).
        bands: names of the bands' centres [Hz], rising.
        panels: name → levels (bands, t), NaN where nothing is known; one scale of colours for all.
        quantity: what the colours are, with unit.
        quietest: lowest level that has a colour of its own.
        moments: marked by upright lines.
    """
    from matplotlib import colormaps
    from matplotlib.colors import LogNorm

    figure, axes = style.new_figure(title, len(panels), sharex=True)
    low, high = scale_of(list(panels.values()), quietest)
    step = float(time[1] - time[0]) if len(time) > 1 else 1.0
    colors = colormaps[COLORS].with_extremes(bad=UNKNOWN)
    places = [k for k, name in enumerate(bands) if name in NAMED]
    for one, (name, levels) in zip(axes, panels.items(), strict=True):
        image = one.imshow(
            np.where(levels <= low, low, levels),
            norm=LogNorm(low, high),
            cmap=colors,
            origin="lower",
            aspect="auto",
            interpolation="nearest",
            extent=(float(time[0]) - step, float(time[-1]), -0.5, len(bands) - 0.5),
        )
        one.set_title(style.shown(name, LONGEST), loc="left", fontsize=9.5, pad=3.0)
        fixed_axis(one.yaxis, places, [bands[k] for k in places])
        one.set(xlabel="time [s]", ylabel="band [Hz]")
        one.grid(False)
        linear_axis(one.xaxis, 6)
    style.share(axes)
    entries: dict[str, Artist] = {
        "not known: windows are not full, or the run is too short": style.patch_key(color=UNKNOWN)
    }
    for moment in moments:
        for one in axes:
            one.axvline(moment.time, color="white", linewidth=2.6, zorder=4)
            entries[style.shown(moment.label, LONGEST)] = one.axvline(
                moment.time, color=style.MOMENT_COLOR, linewidth=1.3, linestyle=(0, (2, 1)), zorder=5
            )
    style.arrange(figure, [(one, ROW * len(bands)) for one in axes], entries, right=74.0, gap=20.0, head=10.0)
    top, bottom = axes[0].get_position(), axes[-1].get_position()
    place = top.x1 + 0.025, bottom.y0, 0.028, top.y1 - bottom.y0
    beside = figure.add_axes(place, axes_class=type(axes[0]), label="<colorbar>")
    bar = figure.colorbar(image, cax=beside, label=quantity)
    log_axis(bar.ax.yaxis)
    return figure
