"""Attenuation over third-octave bands, and at every place."""

from collections.abc import Iterable, Iterator
from typing import Final

from ehamj import plots
from ehamj.judge.decisive import place_in_words
from ehamj.pages import Picture, Section, Table
from ehamj.pages.words import AXIS_NAMES, DASH, decibel
from ehamj.plots import Levels
from ehamj.report.levels import HEADLINE_BANDS, OF_LEVELS, mixed_in
from ehamj.report.sections.faults import in_front
from ehamj.report.shown import Shown, floor_moves, known

FIRST: Final = "z"
"""The motion whose attenuation stands in front, unless what a fault made of it does."""
ALONG: Final = {"z": "Vertical attenuation", "x": "Attenuation along x", "y": "Attenuation along y"}


def attenuation(shown: Shown) -> Section:
    """How much quieter than its floor each machine is."""
    return Section(
        "attenuation",
        "Attenuation",
        list(figures_of(shown, [axis for axis in AXIS_NAMES if axis != FIRST or in_front(shown)])),
        [at_places(shown, axis) for axis in shown.judged_axes],
        _notes(shown),
    )


def figures_of(shown: Shown, motions: Iterable[str]) -> Iterator[Picture]:
    """Attenuation of each machine over the bands, a figure for each of some motions in which any is known."""
    for axis in motions:
        words = AXIS_NAMES[axis]
        tables = {label: result.summary.attenuation_db.get(axis, {}) for label, result in shown.results.items()}
        curves = [
            Levels.of_bands(label, table, shown.colors[label]) for label, table in tables.items() if known([table])
        ]
        if curves:
            yield Picture(f"attenuation-{axis}", plots.attenuation(f"Attenuation, {words}", curves))


def at_places(shown: Shown, axis: str = "z") -> Table:
    """Attenuation along an axis at feet, CG and points in a few bands; without rows where nothing is known."""
    rows: list[list[str]] = []
    for label, result in shown.results.items():
        tables = {"machine": result.summary.attenuation_db, **result.summary.attenuation_at_db}
        own = [
            [place_in_words(place), *(decibel(table[axis].get(band)) for band in HEADLINE_BANDS)]
            for place, table in tables.items()
        ]
        if any(cell != DASH for row in own for cell in row[1:]):
            rows += [*([] if shown.alone else [[label]]), *own]
    note = f"{OF_LEVELS}{mixed_in(shown)} Centre of gravity and points: of the mean of the floor; worst foot: of the "
    note += "ground below it."
    head = ["", *(f"{band} Hz" for band in HEADLINE_BANDS)]
    title = f"{ALONG[axis]} at every place [dB]"
    return Table(title, head, rows, note)


def _notes(shown: Shown) -> list[str]:
    """How to read the figures, and why some are missing."""
    if not floor_moves(shown.first):
        return ["The ground is at rest: attenuation is not defined."]
    found = [
        "Up is quieter. Along x, y and z: the mean of the floor at the mounts over the machine's centre of gravity; "
        "roll, pitch and yaw: of the rigid slab fitted to the floor, over those of the machine; all of the RMS over "
        f"the whole run.{mixed_in(shown)} Gaps are undecided bands."
    ]
    tables = [result.summary.attenuation_db for result in shown.results.values()]
    silent = [name for axis, name in AXIS_NAMES.items() if not known(table.get(axis, {}) for table in tables)]
    if silent:
        why = "since the floor moves too little or the run is short"
        found.append(f"Undecided in every band, {why}: {'; '.join(silent)}.")
    return found
