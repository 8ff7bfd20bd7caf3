"""When it was loud, in which band: floor and machines over time."""

from collections.abc import Collection, Iterator
from typing import Final

from ehamj import plots
from ehamj.judge.spectrogram import STEP, Run, Spectrogram
from ehamj.judge.spectrogram import spectrogram as levels_of
from ehamj.pages import Picture, Section
from ehamj.pages.words import AXIS_NAMES, CRITERION_AXES, MICRO
from ehamj.report.sections.histories import moments_of
from ehamj.report.shown import Shown

QUANTITY: Final = "velocity, 1 s RMS [µm/s]"
NOTE: Final = (
    "Third-octave velocity over time, before (floor, at the mount that moves most along the axis) and after (machines, "
    "at the centre of gravity), in one scale of colours: RMS of the second that ends there, of bands narrower than "
    "1 Hz of 1/bandwidth. A strike is a block as long as that time."
)


def spectrogram(shown: Shown) -> Section | None:
    """Levels over time of the floor and each machine, along every axis that moves."""
    figures = list(figures_of(shown))
    return Section("spectrogram", "Levels over time", figures, notes=[NOTE]) if figures else None


def figures_of(shown: Shown, axes: Collection[str] = CRITERION_AXES) -> Iterator[Picture]:
    """Levels over time along some axes, of those that move."""
    runs = {
        label: Run(result.dataset, result.scenario.record_rate, result.summary.analysis)
        for label, result in shown.results.items()
    }
    found = levels_of(runs)
    moments = dict.fromkeys(moment for result in shown.results.values() for moment in moments_of(result))
    if found is not None:
        yield from _figures(found, list(moments), axes)


def _figures(found: Spectrogram, moments: list[plots.Moment], axes: Collection[str]) -> Iterator[Picture]:
    several = round(found.step / STEP)
    caption = f"A level every {STEP:g} s" + (f", drawn the largest of {several}." if several > 1 else ".")
    bands = [band.name for band in found.bands]
    for axis in (axis for axis in CRITERION_AXES if axis in axes):
        panels = {place: MICRO * levels for place, levels in found.along(axis).items()}
        if panels:
            title = f"Levels over time, {AXIS_NAMES[axis]}"
            figure = plots.spectrogram(title, found.time, bands, panels, QUANTITY, plots.QUIETEST, moments)
            yield Picture(f"spectrogram-{axis}", figure, caption)
