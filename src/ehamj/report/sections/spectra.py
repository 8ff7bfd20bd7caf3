"""Response spectra of floor, machines and points."""

from collections.abc import Iterator, Mapping
from itertools import cycle
from typing import Any, Final

import numpy as np

from ehamj import plots
from ehamj.pages import Picture, Section
from ehamj.pages.words import AXIS_NAMES, CRITERION_AXES, MICRO
from ehamj.plots import Levels
from ehamj.report.shown import Shown
from ehamj.result import Result

MILLI: Final = 1e3
DASHES: Final = ("--", ":", "-.")
KINDS: Final = (
    ("velocity", "pseudo-velocity, peak [µm/s]", MICRO, "Response velocity"),
    ("acceleration", "absolute acceleration, peak [mm/s²]", MILLI, "Response acceleration"),
)


def spectra(shown: Shown) -> Section | None:
    """Response spectra along each axis that moves, where a scenario asks for them."""
    figures = list(_figures(shown))
    if not figures:
        return None
    found = (result.summary.response_spectrum for result in shown.results.values())
    damping = next(spectrum.damping for spectrum in found if spectrum)
    note = (
        f"What an oscillator of one degree of freedom (damping ratio {damping:g}) would do on the floor at its "
        "worst mount, on the machine at its centre of gravity, and at its points (dashed): 2πf times its peak "
        "displacement relative to its base, and its peak absolute acceleration, over its natural frequency f."
    )
    return Section("spectra", "Response spectra", figures, notes=[note])


def _figures(shown: Shown) -> Iterator[Picture]:
    for axis in CRITERION_AXES:
        for kind, quantity, factor, title in KINDS:
            curves = list(_curves(shown, kind, axis, factor))
            if curves:
                across = "natural frequency of the oscillator [Hz]"
                figure = plots.levels(f"{title}, {AXIS_NAMES[axis]}", curves, quantity, across)
                yield Picture(f"spectrum-{kind}-{axis}", figure)


def _curves(shown: Shown, kind: str, axis: str, factor: float) -> Iterator[Levels]:
    """Floors and machines, then the first result's points (dashed); only what moves."""

    def spectrum(result: Result) -> Mapping[str, Any]:
        if (found := result.summary.response_spectrum) is None:
            return {}
        return {place: (found.frequency_hz, axes[axis]) for place, axes in getattr(found, kind).items()}

    points = {place: own for place, own in spectrum(shown.first).items() if place not in ("floor", "machine")}
    curves = [
        *((*one, "-") for one in shown.with_floors(spectrum)),
        *((f"{shown.label}, {place}", plots.INK, own, dash)
          for (place, own), dash in zip(points.items(), cycle(DASHES), strict=False)),
    ]  # fmt: skip
    for label, color, content, dash in curves:
        if content and np.nanmax(values := factor * np.array(content[1], float), initial=0.0) > 0.0:
            yield Levels(label, np.array(content[0]), values, color, dash)
