"""Axes as people read them: plain numbers, logarithmic ones with round ticks, frequencies, decibels."""

import math
from collections.abc import Sequence

import numpy as np

from ehamj.arrays import Array
from ehamj.plots.style import Axes, Axis


def plain(value: float, place: int | None = None) -> str:
    """A tick's number; ``place`` is what Matplotlib counts ticks by."""
    return f"{value:g}".replace("e+0", "e").replace("e+", "e").replace("-", "−")


def linear_axis(axis: Axis, most: int = 4) -> None:
    """An axis with at most so many intervals."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    axis.set_major_locator(MaxNLocator(most, steps=[1, 2, 2.5, 5, 10], min_n_ticks=3))
    axis.set_major_formatter(FuncFormatter(plain))


def fixed_axis(axis: Axis, places: Sequence[float], names: Sequence[str] = ()) -> None:
    """An axis with numbers, or names, at places; as Matplotlib's ``set_ticks``, which makes an object for each."""
    from matplotlib.ticker import FixedFormatter, FixedLocator, FuncFormatter

    axis.set_major_locator(FixedLocator(places))
    axis.set_major_formatter(FixedFormatter(names) if names else FuncFormatter(plain))


def log_axis(axis: Axis, few: bool = False) -> None:
    """Make an axis logarithmic, with round numbers over what it shows; ``few``: powers of ten alone."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    (axis.axes.set_xscale if axis is axis.axes.xaxis else axis.axes.set_yscale)("log")
    low, high = axis.get_view_interval()
    decades = math.log10(high / low)
    wide = high >= 1e5 or low < 1e-3  # numbers with exponents need room
    steps: tuple[float, ...] = (1.0, 2.0, 5.0) if decades > 0.7 else (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0)
    if few or decades > (1.3 if wide else 4.0):
        steps = (1.0,)
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    powers = powers[:: math.ceil(len(powers) / 10)]
    ticks = [float(f"{step}e{power}") for power in powers for step in steps]
    axis.set_major_locator(FixedLocator([tick for tick in ticks if low <= tick <= high]))
    axis.set_minor_locator(NullLocator())  # ticks without names cost a tenth of a page's time
    axis.set_major_formatter(FuncFormatter(plain))


def frequency_axis(axes: Axes, low: float, high: float, name: str = "frequency [Hz]", few: bool = False) -> None:
    """A logarithmic axis of frequency from ``low`` to ``high`` [Hz]."""
    axes.set_xlim(low, high)
    log_axis(axes.xaxis, few)
    axes.set_xlabel(name)


def decibel_axis(axes: Axes, values: Array, least: tuple[float, float], deepest: float = -math.inf) -> None:
    """Limits at multiples of 10 dB around all values that are known, and ``least`` in any case."""
    known = values[np.isfinite(values)]
    bottom = max(deepest, min(least[0], 10.0 * math.floor(float(known.min(initial=0.0)) / 10.0)))
    axes.set_ylim(bottom, max(least[1], 10.0 * math.ceil(float(known.max(initial=0.0)) / 10.0)))
    linear_axis(axes.yaxis, 5)
