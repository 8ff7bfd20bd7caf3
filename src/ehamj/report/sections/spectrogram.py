"""When it was loud, in which band: floor and machines over time."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from ehamj import plots
from ehamj.judge.spectrogram import STEP, Spectrogram
from ehamj.pages import Picture, Section
from ehamj.pages.words import AXIS_NAMES, CRITERION_AXES, MICRO
from ehamj.plant.axes import AXES
from ehamj.report.shown import Shown

QUANTITY: Final = "velocity, 1 s RMS [µm/s]"
LEAST_SHARE: Final = 1e-3
"""Share of the loudest axis' level below which an axis is left out: it shows what others leak into it."""
NOTE: Final = (
    "Third-octave velocity over time, before (floor, in each band at its worst mount) and after (machines, at the "
    "centre of gravity), in one scale of colours: RMS of the second that ends there, of bands narrower than 1 Hz of "
    "1/bandwidth. A strike is a block as long as that time."
)


def spectrogram(shown: Shown) -> Section | None:
    """Levels over time of the floor and each machine, along every axis that moves."""
    figures = list(_figures(shown))
    return Section("spectrogram", "Levels over time", figures, notes=[NOTE]) if figures else None


def _figures(shown: Shown) -> Iterator[Picture]:
    found = shown.evaluations[shown.label].spectrogram
    if found is None:
        return
    places = dict(found.beside({label: one.spectrogram for label, one in shown.evaluations.items()}))
    loudest = max(float(np.nanmax(levels, initial=0.0)) for levels in places.values())
    for axis in CRITERION_AXES:
        panels = {name: MICRO * levels[:, :, AXES.index(axis)] for name, levels in places.items()}
        if max(float(np.nanmax(panel, initial=0.0)) for panel in panels.values()) <= LEAST_SHARE * MICRO * loudest:
            continue
        title, bands = f"Levels over time, {AXIS_NAMES[axis]}", [band.name for band in found.bands]
        figure = plots.spectrogram(title, found.time, bands, panels, QUANTITY, plots.QUIETEST)
        yield Picture(f"spectrogram-{axis}", figure, _caption(found))


def _caption(found: Spectrogram) -> str:
    """How close the levels are."""
    several = round(found.step / STEP)
    return f"A level every {STEP:g} s" + (f", drawn the largest of {several}." if several > 1 else ".")
