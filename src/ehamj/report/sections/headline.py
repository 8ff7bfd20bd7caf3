"""What stands on top of the page: attenuation at a few bands, classes met, warnings."""

import re
from collections.abc import Mapping, Sequence
from typing import Final

from ehamj.criteria.curves import Norm
from ehamj.estimate.statistics import WORDS, Statistic
from ehamj.judge.verdicts import AtPlace
from ehamj.pages import Section, Table
from ehamj.pages.words import AXIS_NAMES, CRITERION_AXES, DASH, decibel
from ehamj.report.shown import Shown, floor_moves, known
from ehamj.report.verdict import class_met

OF_LEVELS: Final = "Of the RMS over the whole run."
"""What attenuation is of."""
HEADLINE_BANDS: Final = ("5", "10", "20", "50", "100")

OLDER: Final = (
    "levels of this result are those of an earlier version, through one Hann window over the run, which says little of "
    "what strikes near its ends: run it again for those of the whole run"
)
"""What to know of a result whose levels are not the whole run's."""

PROCESSING: Final = re.compile(
    r"record .*(: (\S+ )?[xyz] from |, in this order: )|the ground starts from rest|floor \S+(, \S+ times as strong)?: "
    r"|mounts move with Luco-Wong|table .*: .* rows from line |record .*: times are rounded to "
)
"""Warnings that only say how a record was processed."""


def headline(shown: Shown) -> Section:
    """Vertical attenuation at a few bands."""
    tables = {label: result.summary.attenuation_db["z"] for label, result in shown.results.items()}
    rows = [[label, *(decibel(table.get(band)) for band in HEADLINE_BANDS)] for label, table in tables.items()]
    note = OF_LEVELS + (f" {DASH}: undecided." if any(DASH in row for row in rows) else "")
    if not known(tables.values()):
        rows, note = [], "Undecided in every band: the run is too short, or the floor moves too little."
    if not floor_moves(shown.first):
        rows, note = [], "The ground is at rest: there is nothing to attenuate."
    title = "Vertical attenuation [dB] in the third-octave bands at"
    table = Table(title, ["", *(f"{band} Hz" for band in HEADLINE_BANDS)], rows, note)
    return Section("headline", tables=[table], notes=() if rows else [note], kind="headline")


def classes(shown: Shown) -> Section:
    """Vibration class per axis of the floor and of each machine, with margin and band: by the verdict's levels, and by
    the largest second."""
    norm = next(iter(shown.norms.values()))
    columns = {name: place for name, _, place in shown.with_floors(lambda result: result.summary.criterion)}
    compared = dict.fromkeys(verdict.statistic for place in columns.values() for verdict in place.along(CRITERION_AXES))
    rows = [[_by([name for name in compared if name])], *_met(columns, norm)]
    beside = {name: place for name, _, place in shown.with_floors(lambda result: result.summary.criterion.max_1s or {})}
    if all(beside.values()) and "max_1s" not in compared:
        rows += [[_by(["max_1s"])], *_met(beside, norm)]
    note = "Margin: below the limit of the class met, in the band that decides, where it is least."
    if any(verdict.peak is not None for place in columns.values() for verdict in place.along(CRITERION_AXES)):
        note = "Margin: below the limit of the class met, of the peak that comes nearest to it."
    rows = [row for row in rows if row != [""]]
    return Section("classes", tables=[Table(f"Class met: {norm.title}", ["", *columns], rows, note, kind="words")])


def _met(columns: Mapping[str, AtPlace], norm: Norm) -> list[list[str]]:
    """A row of classes per axis."""
    return [
        [AXIS_NAMES[axis], *(class_met(place[axis], norm, "worse than") for place in columns.values())]
        for axis in CRITERION_AXES
    ]


def _by(statistics: Sequence[Statistic]) -> str:
    """Which levels a part of the table is by."""
    return f"by {' and '.join(WORDS[name] for name in statistics)}" if statistics else ""


def warnings(shown: Shown) -> Section | None:
    """What a reader has to know."""
    found = told(shown, processing=False)
    return Section("warnings", items=found, items_title="Warnings", kind="warnings") if found else None


def told(shown: Shown, processing: bool) -> list[str]:
    """Warnings in plain words, each with the results that it holds for; ``processing``: those about a record's."""
    found: dict[str, list[str]] = {}
    for label, result in shown.results.items():
        older = [] if result.summary.levels is not None else [OLDER]
        for text in (*older, *result.summary.warnings):
            if bool(PROCESSING.match(text)) == processing:
                found.setdefault(text, []).append(label)
    return [text if len(who) == len(shown.results) else f"{'; '.join(who)}: {text}" for text, who in found.items()]
