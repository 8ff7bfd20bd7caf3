"""Figures over third-octave bands: attenuation, and velocity against the curves of a criterion."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.plots import style
from ehamj.plots.axes import decibel_axis, frequency_axis, log_axis
from ehamj.plots.style import Artist, Axes, Figure

LABEL_HEIGHT: Final = 8.0
"""Least distance between the names of two curves [pt]."""

QUIETEST: Final = 1e-3
"""Lowest velocity on a criterion plot [µm/s]."""


@dataclass(frozen=True)
class Levels:
    """A line over frequency bands: centres [Hz] and values, NaN where nothing is known, (bands,) each."""

    label: str
    frequency: Array
    values: Array
    color: str
    dash: str = "-"

    @classmethod
    def of_bands(cls, label: str, table: Mapping[str, float | None], color: str, factor: float = 1.0) -> "Levels":
        """From a level per band's name, times a factor."""
        values = [math.nan if value is None else factor * value for value in table.values()]
        return cls(label, np.array([float(band) for band in table]), np.array(values), color)


@style.styled()
def attenuation(title: str, curves: Sequence[Levels]) -> Figure:
    """Attenuation [dB] over third-octave bands; up is quieter than the floor."""
    figure, axes = _over_bands(title, curves)
    decibel_axis(axes, np.concatenate([curve.values for curve in curves] or [np.zeros(0)]), (-10.0, 10.0))
    axes.axhspan(axes.get_ylim()[0], 0.0, color="#FBEDEA", zorder=0)
    zero = axes.axhline(0.0, color=style.GREY, linewidth=1.2)
    axes.set_ylabel("attenuation [dB], up = quieter")
    style.arrange(figure, [(axes, 150.0)], _band_lines(axes, curves) | {"as the floor (0 dB)": zero})
    return figure


@style.styled()
def criterion(
    title: str,
    curves: Sequence[Levels],
    classes: Mapping[str, tuple[Array, Array]],
    known_to: float | None = None,
    quantity: str = "RMS velocity per band [µm/s]",
) -> Figure:
    """Third-octave RMS velocity [µm/s] over bands, with the curves of a criterion's classes.

    Args:
        title: of the figure.
        curves: levels [µm/s].
        classes: name → band centres [Hz] and limits [µm/s] of each class, coarsest first, drawn where they are in
            sight; all are down to the first that no curve meets, or the strictest.
        known_to: frequency above which the ground is not known [Hz].
        quantity: what the vertical axis shows.
    """
    figure, axes = _over_bands(title, curves)
    drawn, values = _positive(curves)
    strictest = _first_missed(drawn, list(classes.values()))
    bottom = min(0.3, float(strictest.min()) / 1.5, max(QUIETEST, float(values.min(initial=1.0)) / 1.5))
    top = max(100.0, 1.5 * float(values.max(initial=1.0)), 1.5 * float(strictest.max()))
    _level_axis(axes, bottom, top, quantity)
    height, named_at, end = 190.0, math.inf, axes.get_xlim()[1]
    for name, (frequency, limit) in classes.items():
        level = float(limit[-1])
        if not bottom * 1.1 < level < top:
            continue
        axes.plot(frequency, limit, color="#4B5563", linewidth=0.9, gid=f"class-{name}".replace(" ", "-"))
        axes.plot([frequency[-1], end], [level] * 2, color=style.FAINT, linewidth=0.8, linestyle=":")
        if math.log(named_at / level) * height / math.log(top / bottom) < LABEL_HEIGHT:
            continue  # its name would lie on that of the class above
        named_at = level
        axes.annotate(name, (end, level), (4, 0), textcoords="offset points", va="center", fontsize=8, color="#374151")
    entries = _band_lines(axes, drawn)
    if known_to is not None and known_to < end:
        axes.axvspan(known_to, end, color="#EEF0F3", zorder=0)
        entries[f"floor not known above {known_to:.3g} Hz"] = style.patch_key(color="#E3E6EA")
    style.arrange(figure, [(axes, height)], entries, right=76.0)
    return figure


def _first_missed(curves: Sequence[Levels], classes: Sequence[tuple[Array, Array]]) -> Array:
    """Limits of the first class, coarsest first, that every curve exceeds in some band; or of the strictest."""

    def exceeds(curve: Levels, frequency: Array, limit: Array) -> bool:
        inside = np.isin(curve.frequency, frequency) & np.isfinite(curve.values)
        return bool(np.any(curve.values[inside] > np.interp(curve.frequency[inside], frequency, limit)))

    missed = (limit for frequency, limit in classes if curves and all(exceeds(c, frequency, limit) for c in curves))
    return next(missed, classes[-1][1] if classes else np.ones(1))


@style.styled()
def levels(title: str, curves: Sequence[Levels], quantity: str, across: str = "third-octave band [Hz]") -> Figure:
    """Levels over frequency, both logarithmic.

    Args:
        title: of the figure.
        curves: levels, at least one of them positive somewhere.
        quantity: what the vertical axis shows, with its unit.
        across: what the horizontal axis shows.
    """
    figure, axes = _over_bands(title, curves, across)
    drawn, values = _positive(curves)
    top = 1.5 * float(values.max())
    _level_axis(axes, max(float(values.min()) / 1.5, 1e-6 * top), top, quantity)
    style.arrange(figure, [(axes, 170.0)], _band_lines(axes, drawn))
    return figure


def _over_bands(title: str, curves: Sequence[Levels], across: str = "third-octave band [Hz]") -> tuple[Figure, Axes]:
    """A figure over a logarithmic axis of frequency that spans all bands, known or not."""
    figure, (axes,) = style.new_figure(title)
    frequency = np.concatenate([curve.frequency for curve in curves] or [np.array([1.0, 100.0])])
    frequency_axis(axes, float(frequency.min()) / 1.12, float(frequency.max()) * 1.12, across)
    return figure, axes


def _level_axis(axes: Axes, bottom: float, top: float, quantity: str) -> None:
    axes.set_ylim(bottom, top)
    log_axis(axes.yaxis, few=True)
    axes.set_ylabel(quantity)


def _positive(curves: Sequence[Levels]) -> tuple[list[Levels], Array]:
    """What a logarithmic axis can show: the curves, with gaps elsewhere, and all their values."""
    drawn = [replace(curve, values=np.where(curve.values > 0, curve.values, np.nan)) for curve in curves]
    values = np.concatenate([curve.values for curve in drawn] or [np.zeros(0)])
    return drawn, values[np.isfinite(values)]


def _band_lines(axes: Axes, curves: Sequence[Levels]) -> dict[str, Artist]:
    """Draw the curves: floors broad and below; machines with markers, earlier ones thinner and on top, so that those
    which coincide all show; dashed ones above all. Returns the legend."""
    entries: dict[str, Artist] = {}
    place = 0
    for curve in sorted(curves, key=lambda curve: (curve.dash != "-", curve.color != style.FLOOR_COLOR)):
        if curve.dash != "-":
            look: dict[str, Any] = {"linewidth": 1.1, "linestyle": curve.dash, "zorder": 3.5}
        elif curve.color == style.FLOOR_COLOR:
            look = {"linewidth": 4.5, "zorder": 2.2, "solid_capstyle": "round"}
        else:
            look = {"linewidth": 1.4 + 0.9 * place, "marker": style.MARKERS.get(curve.color, "o")}
            look |= {"markersize": 3.4 + 1.6 * place, "zorder": 3.0 - 0.1 * place}
            place += 1
        (entries[style.shown(curve.label)],) = axes.plot(curve.frequency, curve.values, color=curve.color, **look)
    return entries
