"""Attenuation over frequency, drawn as lines: Rerun's own plots have no logarithmic axis."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import rerun as rr

from ehamj.replay.recording import Array, Color, entity, fixed, result_color
from ehamj.result import Result

ROOT = "attenuation"
WIDTH, HEIGHT = 320.0, 400.0
"""Size of the chart between its axes, in the view's units."""

MARGINS = (45.0, 20.0, 60.0, 45.0)
"""Room left, right, above and below the chart for its labels."""

TICKS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)
GRID: Color = (62, 66, 72)
ZERO: Color = (150, 155, 160)
TEXT: Color = (170, 175, 180)

TITLES = {"x": "along x", "y": "along y", "z": "vertical", "rx": "roll rx", "ry": "pitch ry", "rz": "yaw rz"}


class Curve(NamedTuple):
    """Attenuation of one result: band centres [Hz] and values [dB], nan where undecided."""

    frequency: Array
    decibel: Array


def curves_of(results: Mapping[str, Result]) -> dict[str, dict[str, Curve]]:
    """Attenuation by axis and result, as far as the summaries have it; vertical first."""
    found: dict[str, dict[str, Curve]] = {}
    for label, result in results.items():
        for axis, bands in result.summary.attenuation_db.items():
            points = sorted((float(centre), np.nan if value is None else value) for centre, value in bands.items())
            curve = Curve(*np.array(points, float).reshape(-1, 2).T)
            if np.isfinite(curve.decibel).any():
                found.setdefault(axis, {})[label] = curve
    return dict(sorted(found.items(), key=lambda item: (item[0] != "z", len(item[0]), item[0])))


def log_attenuation(
    recording: rr.RecordingStream, curves: Mapping[str, Mapping[str, Curve]], labels: tuple[str, ...]
) -> None:
    """Log one chart per axis; ``labels`` are all results in order, which decides the colours."""
    for axis, by_label in curves.items():
        chart = _Chart.around(by_label)
        _log_grid(recording, entity(ROOT, axis, "grid"), chart)
        for label, curve in by_label.items():
            path = entity(ROOT, axis, "curve", label)
            _log_curve(recording, path, curve, chart, result_color(labels.index(label)))
        _log_legend(recording, entity(ROOT, axis, "legend"), labels)


class _Chart(NamedTuple):
    """Ranges of the axes: frequency [Hz], attenuation [dB]."""

    lowest: float
    highest: float
    bottom: float
    top: float

    @classmethod
    def around(cls, curves: Mapping[str, Curve]) -> "_Chart":
        frequency, decibel = (np.concatenate(parts) for parts in zip(*curves.values(), strict=True))
        frequency, decibel = frequency[np.isfinite(decibel)], decibel[np.isfinite(decibel)]
        lowest = max((tick for tick in TICKS if tick <= frequency.min() * 1.05), default=float(frequency.min()))
        highest = min((tick for tick in TICKS if tick >= frequency.max() * 0.95), default=float(frequency.max()))
        bottom = min(-10.0, 10.0 * math.floor(float(decibel.min()) / 10.0))
        top = max(10.0, 10.0 * math.ceil(float(decibel.max()) / 10.0))
        return cls(lowest, max(highest, 2.0 * lowest), bottom, top)

    def place(self, frequency: Any, decibel: Any) -> Array:
        """Points (n, 2) in the view; y points down there."""
        x = WIDTH * np.log(np.asarray(frequency, float) / self.lowest) / math.log(self.highest / self.lowest)
        y = HEIGHT * (self.top - np.asarray(decibel, float)) / (self.top - self.bottom)
        return np.column_stack(np.broadcast_arrays(x, y))


def _log_grid(recording: rr.RecordingStream, path: str, chart: _Chart) -> None:
    """Lines at the ticks, their numbers, and what the axes are."""
    frequencies = [tick for tick in TICKS if chart.lowest <= tick <= chart.highest]
    step = 10.0 if chart.top - chart.bottom <= 100.0 else 20.0
    levels = np.arange(chart.bottom, chart.top + 0.5, step)
    ends, sides = [chart.bottom, chart.top], [chart.lowest, chart.highest]
    strips = [chart.place(tick, ends) for tick in frequencies] + [chart.place(sides, level) for level in levels]
    colors = [GRID] * len(frequencies) + [ZERO if level == 0.0 else GRID for level in levels]
    fixed(recording, path, rr.LineStrips2D(strips, colors=colors, radii=rr.Radius.ui_points(0.5), draw_order=0.0))
    below = [(point[0], HEIGHT + 4.0) for tick in frequencies for point in chart.place(tick, chart.bottom)]
    beside = [(-20.0, point[1] - 8.0) for level in levels for point in chart.place(chart.lowest, level)]
    titles = [(0.5 * WIDTH, HEIGHT + 24.0), (0.5 * WIDTH, -50.0)]
    words = [f"{tick:g}" for tick in frequencies] + [f"{level:g}" for level in levels]
    words += ["third-octave band [Hz]", "attenuation of the whole-run RMS [dB]: up is quieter than the floor"]
    text = rr.Points2D(below + beside + titles, radii=0.01, colors=[TEXT], labels=words, show_labels=True)
    fixed(recording, f"{path}/text", text)


def _log_curve(recording: rr.RecordingStream, path: str, curve: Curve, chart: _Chart, color: Color) -> None:
    """A line broken where a band is undecided, and a dot per band."""
    known = np.isfinite(curve.decibel)
    points = chart.place(curve.frequency, curve.decibel)[known]
    strips = np.split(points, np.flatnonzero(np.diff(np.flatnonzero(known)) > 1) + 1)
    fixed(recording, path, rr.LineStrips2D(strips, colors=[color], radii=rr.Radius.ui_points(1.5), draw_order=10.0))
    dots = rr.Points2D(points, radii=rr.Radius.ui_points(3.0), colors=[color], draw_order=11.0)
    fixed(recording, f"{path}/bands", dots)


def _log_legend(recording: rr.RecordingStream, path: str, labels: tuple[str, ...]) -> None:
    """The results' names in their colours, in a row above the chart."""
    places = [(WIDTH * (index + 0.5) / len(labels), -26.0) for index in range(len(labels))]
    colors = [result_color(index) for index in range(len(labels))]
    fixed(recording, path, rr.Points2D(places, radii=0.01, colors=colors, labels=labels, show_labels=True))
