"""What stands on top of the page: attenuation at a few bands, classes met, warnings."""

import re
from typing import Final

from ehamj.pages import Section, Table
from ehamj.pages.words import AXIS_NAMES, CRITERION_AXES, DASH, decibel
from ehamj.report.shown import Shown, floor_moves, known
from ehamj.report.verdict import class_met

HEADLINE_BANDS: Final = ("5", "10", "20", "50", "100")

PROCESSING: Final = re.compile(
    r"record .*(: (\S+ )?[xyz] from |, in this order: )|the ground starts from rest|floor \S+(, \S+ times as strong)?: "
    r"|mounts move with Luco-Wong|table .*: .* rows from line |record .*: times are rounded to "
)
"""Warnings that only say how a record was processed."""


def headline(shown: Shown) -> Section:
    """Vertical attenuation at a few bands."""
    tables = {label: result.summary.attenuation_db["z"] for label, result in shown.results.items()}
    rows = [[label, *(decibel(table.get(band)) for band in HEADLINE_BANDS)] for label, table in tables.items()]
    note = f"{DASH}: undecided." if any(DASH in row for row in rows) else ""
    if not known(tables.values()):
        rows, note = [], "Undecided in every band: the run is too short, or the floor moves too little."
    if not floor_moves(shown.first):
        rows, note = [], "The ground is at rest: there is nothing to attenuate."
    title = "Vertical attenuation [dB] in the third-octave bands at"
    table = Table(title, ["", *(f"{band} Hz" for band in HEADLINE_BANDS)], rows, note)
    return Section("headline", tables=[table], notes=() if rows else [note], kind="headline")


def classes(shown: Shown) -> Section:
    """Vibration class per axis of the floor and of each machine, with margin and band."""
    columns = {name: place for name, _, place in shown.with_floors(lambda result: result.summary.criterion)}
    norm = next(iter(shown.norms.values()))
    rows = [
        [AXIS_NAMES[axis], *(class_met(place[axis], norm, "worse than") for place in columns.values())]
        for axis in CRITERION_AXES
    ]
    note = "Margin: below the limit of the class met, in the band that decides, where it is least."
    return Section("classes", tables=[Table(f"Class met: {norm.title}", ["", *columns], rows, note, kind="words")])


def warnings(shown: Shown) -> Section | None:
    """What a reader has to know."""
    found = told(shown, processing=False)
    return Section("warnings", items=found, items_title="Warnings", kind="warnings") if found else None


def told(shown: Shown, processing: bool) -> list[str]:
    """Warnings in plain words, each with the results that it holds for; ``processing``: those about a record's."""
    found: dict[str, list[str]] = {}
    for label, result in shown.results.items():
        for text in result.summary.warnings:
            if bool(PROCESSING.match(text)) == processing:
                found.setdefault(text, []).append(label)
    return [text if len(who) == len(shown.results) else f"{', '.join(who)}: {text}" for text, who in found.items()]
