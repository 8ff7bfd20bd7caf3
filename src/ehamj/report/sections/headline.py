"""What stands on top of the page: attenuation at a few bands, and warnings."""

from typing import Final

from ehamj.judge.brief import MEAN, PROCESSING
from ehamj.judge.worse import cancelled
from ehamj.pages import Section, Table
from ehamj.pages.words import AXIS_NAMES, DASH, decibel
from ehamj.plant.axes import AXES
from ehamj.report.levels import HEADLINE_BANDS, OF_LEVELS, mixed_in
from ehamj.report.sections.attenuation import FIRST, figures_of
from ehamj.report.sections.faults import in_front, picture
from ehamj.report.shown import Shown, floor_moves, known

WORST: Final = (
    "Worst place: of the centre of gravity, each foot and every point, the one with least in that band; a foot is held "
    "against the ground below it, all else against the mean of the floor."
)
OLDER: Final = (
    "levels of this result are those of an earlier version, through one Hann window over the run, which says little of "
    "what strikes near its ends: run it again for those of the whole run"
)
"""What to know of a result whose levels are not the whole run's."""


def headline(shown: Shown) -> Section:
    """Vertical attenuation at a few bands, at the place of the machine that has least, and at its centre of gravity;
    beside any machine that is actuated in all six motions that of each motion."""
    rows: list[list[str]] = []
    tables = []
    found = {label: result.summary.attenuation_first() for label, result in shown.results.items()}
    several = any(len(motions) > 1 for motions in found.values())
    for label, motions in found.items():
        for motion, places in motions.items():
            words = f", {AXIS_NAMES[motion]}" if several else ""
            for place, levels in places.items():
                where = "" if motion not in AXES else f", {place}"
                rows.append([f"{label}{words}{where}", *(decibel(levels.get(band)) for band in HEADLINE_BANDS)])
            tables += list(places.values())
    mixed = mixed_in(shown)
    note = f"{OF_LEVELS}{mixed} {WORST}" + (f" {DASH}: undecided." if any(DASH in row for row in rows) else "")
    asked = [(shown.results[label].summary, axis) for label, motions in found.items() for axis in motions]
    small = {band for summary, axis in asked if axis in AXES for band in cancelled(summary, axis)}
    if against := [band for band in HEADLINE_BANDS if band in small]:
        note += f" At {', '.join(against)} Hz: {MEAN}."
    if not known(tables):
        rows, note = [], "Undecided in every band: the run is too short, or the floor moves too little."
    if not floor_moves(shown.first):
        rows, note = [], "The ground is at rest: there is nothing to attenuate."
    fault = in_front(shown)
    figures = [picture(shown, shown.label, fault)] if fault else list(figures_of(shown, (FIRST,)))
    title = f"{'Attenuation' if several else 'Vertical attenuation'} [dB] in the third-octave bands at"
    table = Table(title, ["", *(f"{band} Hz" for band in HEADLINE_BANDS)], rows, note)
    notes = () if rows else [note]
    return Section("headline", figures=figures, tables=[table], notes=notes, kind="headline abreast")


def warnings(shown: Shown) -> Section | None:
    """What a reader has to know of the result that is reported."""
    found = told(shown, processing=False, first=True)
    return Section("warnings", items=found, items_title="Warnings", kind="warnings") if found else None


def warnings_beside(shown: Shown) -> Section | None:
    """What is to be known of the others alone."""
    found = told(shown, processing=False, first=False)
    title = "Warnings about what stands beside it"
    return Section("warnings-beside", items=found, items_title=title, kind="warnings") if found else None


def told(shown: Shown, processing: bool, first: bool | None = None) -> list[str]:
    """Warnings in plain words, each with the results that it holds for.

    Args:
        shown: the results.
        processing: whether those that say how a record was processed, or all others.
        first: whether those that hold for the first result, or for others alone; all without.
    """
    found: dict[str, list[str]] = {}
    for label, result in shown.results.items():
        older = [] if result.summary.levels is not None else [OLDER]
        for text in (*older, *result.summary.warnings):
            if bool(PROCESSING.match(text)) == processing:
                found.setdefault(text, []).append(label)
    return [
        text if len(who) == len(shown.results) else f"{'; '.join(who)}: {text}"
        for text, who in found.items()
        if first is None or first == (who[0] == shown.label)
    ]
