"""Levels over time as a picture of colours, with a cursor that goes along with the time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from ehamj.judge.spectrogram import Run, spectrogram
from ehamj.plots.spectrograms import COLORS, NAMED, scale_of
from ehamj.replay.recording import Array, Color, entity, fixed, moving
from ehamj.result import Result

ROOT: Final = "spectrogram"
WIDTH: Final = 480
"""Width of the panels, in pixels, which are the view's units."""
ROW: Final = 7
"""Height of a band."""
GAP: Final = 34
"""Room above each panel for its name."""
BAR: Final = (52, 12)
"""Where the bar of colours is below the last panel, and how high it is."""
MARGINS: Final = (48.0, 16.0, 24.0, 40.0)
"""Room left, right, above and below for numbers and names."""
QUIETEST: Final = 1e-8
"""Lowest level that has a colour of its own [m/s]."""
UNKNOWN: Final[Color] = (58, 62, 68)
PAPER: Final[Color] = (13, 16, 17)
TEXT: Final[Color] = (170, 175, 180)
CURSOR: Final[Color] = (255, 255, 255)
TICKS: Final = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1e3, 2e3, 5e3)
"""Between two times that are written [s]."""
CURSOR_STEP: Final = 0.05
"""Time between two places of the cursor [s]."""


@dataclass(frozen=True)
class Heat:
    """One axis: what is loud when, on one scale."""

    time: Array
    """Ends of the columns [s], evenly, (t,)."""
    step: float
    bands: tuple[str, ...]
    panels: dict[str, Array]
    """Levels by name [m/s], (bands, t)."""

    @property
    def tall(self) -> int:
        """Height of the picture."""
        return len(self.panels) * (GAP + ROW * len(self.bands)) + sum(BAR)

    def top(self, panel: int) -> int:
        """Where a panel begins."""
        return GAP + panel * (GAP + ROW * len(self.bands))

    def across(self, time: Array) -> Array:
        """Where a time is [s]."""
        return np.asarray(WIDTH * (time - (self.time[0] - self.step)) / (self.step * self.time.size))


def heats_of(results: Mapping[str, Result]) -> dict[str, Heat]:
    """Levels over time by axis, vertical first, of floor and each result; nothing of a run that is too short."""
    found = spectrogram(
        {
            label: Run(result.dataset, result.scenario.record_rate, result.summary.analysis)
            for label, result in results.items()
        }
    )
    if found is None:
        return {}
    bands = tuple(band.name for band in found.bands)
    by_axis = {axis: found.along(axis) for axis in ("z", "x", "y")}
    return {axis: Heat(found.time, found.step, bands, panels) for axis, panels in by_axis.items() if panels}


def log_heats(recording: rr.RecordingStream, heats: Mapping[str, Heat]) -> None:
    """Log a picture per axis, its numbers, and the cursor."""
    for axis, heat in heats.items():
        low, high = scale_of(list(heat.panels.values()), QUIETEST)
        fixed(recording, entity(ROOT, axis, "picture"), rr.Image(picture(heat, low, high), draw_order=0.0))
        places, words = _words(heat, low, high)
        text = rr.Points2D(places, radii=0.01, colors=[TEXT], labels=words, show_labels=True, draw_order=2.0)
        fixed(recording, entity(ROOT, axis, "text"), text)
        _log_cursor(recording, entity(ROOT, axis, "cursor"), heat)


def picture(heat: Heat, low: float, high: float) -> NDArray[np.uint8]:
    """The panels and the bar of colours, (height, width, 3)."""
    drawn = np.full((heat.tall, WIDTH, 3), PAPER, np.uint8)
    columns = np.minimum(np.arange(WIDTH) * heat.time.size // WIDTH, heat.time.size - 1)
    for number, levels in enumerate(heat.panels.values()):
        top = heat.top(number)
        colors = _colors(levels[::-1], low, high)[:, columns]
        drawn[top : top + ROW * len(heat.bands)] = np.repeat(colors, ROW, axis=0)
    bar = _colors(np.geomspace(low, high, WIDTH)[None], low, high)
    drawn[-BAR[1] :] = bar
    return drawn


def _colors(levels: Array, low: float, high: float) -> NDArray[np.uint8]:
    from matplotlib import colormaps

    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.log(levels / low) / np.log(high / low)
    colors = (255.0 * colormaps[COLORS](np.clip(np.nan_to_num(share), 0.0, 1.0))[..., :3]).astype(np.uint8)
    return np.where(np.isnan(levels)[..., None], np.array(UNKNOWN, np.uint8), colors)


def _words(heat: Heat, low: float, high: float) -> tuple[list[tuple[float, float]], list[str]]:
    """Places and texts: names of panels, bands, seconds, levels."""
    found: list[tuple[float, float, str]] = []
    for number, name in enumerate(heat.panels):
        top = heat.top(number)
        found.append((0.5 * WIDTH, top - 22.0, name))
        for row, band in enumerate(reversed(heat.bands)):
            if band in NAMED:
                found.append((-22.0, top + ROW * (row + 0.5) - 8.0, band))
    bottom = heat.top(len(heat.panels) - 1) + ROW * len(heat.bands)
    found += [(float(heat.across(np.array(second))), bottom, f"{second:g} s") for second in _seconds(heat)]
    for level in _levels(low, high):
        share = np.log(level / low) / np.log(high / low)
        found.append((float(WIDTH * share), float(heat.tall), f"{1e6 * level:g}"))
    found.append((0.5 * WIDTH, heat.tall + 18.0, "velocity, RMS of 1 s, per third-octave band in Hz [µm/s]"))
    return [(x, y) for x, y, _ in found], [word for _, _, word in found]


def _seconds(heat: Heat) -> list[float]:
    """Round times within the picture [s]."""
    length = float(heat.step * heat.time.size)
    every = next((step for step in TICKS if length / step <= 8), TICKS[-1])
    first = np.ceil((heat.time[0] - heat.step) / every - 1e-9)
    return [float(every * k) for k in np.arange(first, np.floor(heat.time[-1] / every + 1e-9) + 1)]


def _levels(low: float, high: float) -> Sequence[float]:
    """Powers of ten on the scale, and its ends [m/s]."""
    powers = np.arange(np.ceil(np.log10(low) - 1e-9), np.floor(np.log10(high) + 1e-9) + 1)
    return sorted({round(float(level), 15) for level in (low, high, *10.0**powers)})


def _log_cursor(recording: rr.RecordingStream, path: str, heat: Heat) -> None:
    """A line at the time that is shown, through all panels."""
    length = float(heat.time[-1] - heat.time[0]) + heat.step
    time = np.linspace(float(heat.time[0]) - heat.step, float(heat.time[-1]), max(int(length / CURSOR_STEP), 2))
    top, bottom = heat.top(0), heat.top(len(heat.panels) - 1) + ROW * len(heat.bands)
    half = [[0.6, 0.5 * (bottom - top)]]
    fixed(recording, path, rr.Boxes2D.from_fields(half_sizes=half, colors=[CURSOR], draw_order=3.0))
    centers = np.column_stack([heat.across(time), np.full(time.size, 0.5 * (top + bottom))])
    moving(recording, path, time, rr.Boxes2D.columns(centers=centers))
