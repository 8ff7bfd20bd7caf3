"""What the page says in words: verdict, classes, warnings, and how to read each section."""

import re
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from ehamj import plots
from ehamj.criteria.curves import Norm
from ehamj.pages import Table
from ehamj.pages.words import AXIS_NAMES, CRITERION_AXES, DASH, MICRO, decibel
from ehamj.report.histories import characteristic_part
from ehamj.report.observed import spectra_note
from ehamj.report.shown import Results, floor_moves, known
from ehamj.result import Result

HEADLINE_BANDS: Final = ("5", "10", "20", "50", "100")

TRANSMISSIBILITY: Final = (
    "Displacement of the machine (translation of its centre of gravity, rotation) over that of the floor, of which a "
    "rigid slab is fitted to the mounts. Lines: linear, about the equilibrium, with the sampled control loop. Marks or "
    "broken lines: measured from the run, each direction by itself; coherence below one tells of other directions that "
    "move the machine as well, of noise, and of the valves' nonlinearity."
)

PROCESSING: Final = re.compile(
    r"record .*(: (\S+ )?[xyz] from |, in this order: )|the ground starts from rest|floor \S+(, \S+ times as strong)?: "
    r"|mounts move with Luco-Wong"
)
"""Warnings that only say how a record was processed."""


def failure(result: Result) -> str:
    return str(result.summary.get("failure", "the simulation did not reach its end"))


def verdict(result: Result) -> list[tuple[str, str]]:
    """The verdict's lines as the summary says them: vertical apart from horizontal."""
    criterion = result.summary.get("criterion", {})
    lines = []
    for name, axes in (("vertical", ("z",)), ("horizontal", ("x", "y"))):
        parts = [criterion.get(who, {}).get(axis, {}) for who in ("floor", "machine") for axis in axes]
        judged = any(part.get("deciding_band_hz") is not None for part in parts)
        said = criterion.get("verdict", {}).get(name, DASH)
        lines.append((name, said if judged else "not judged: the run is too short for any band of the criterion"))
    return lines


def headline(results: Results) -> Table:
    """Vertical attenuation at a few bands."""
    tables = {label: result.summary.get("attenuation_db", {}).get("z", {}) for label, result in results.items()}
    rows = [[label, *(decibel(table.get(band)) for band in HEADLINE_BANDS)] for label, table in tables.items()]
    note = f"{DASH}: undecided." if any(DASH in row for row in rows) else ""
    if not known(tables.values()):
        rows, note = [], "Undecided in every band: the run is too short, or the floor moves too little."
    if not floor_moves(next(iter(results.values()))):
        note = "The ground is at rest: there is nothing to attenuate."
    head = ["", *(f"{band} Hz" for band in HEADLINE_BANDS)]
    return Table("Vertical attenuation [dB] in the third-octave bands at", head, rows, note)


def classes(results: Results) -> Table:
    """Vibration class per axis of the floor and of each machine, with margin and band."""
    columns: list[tuple[str, Mapping[str, Any]]] = []
    for label, result in results.items():
        criterion = result.summary.get("criterion", {})
        floor = criterion.get("floor", {})
        if not any(floor == known for _, known in columns):
            columns.append(("floor" if not columns else f"floor of {label}", floor))
        columns.append((label, criterion.get("machine", {})))
    norm = next(iter(next(iter(results.values())).scenario.criteria.chosen().values()))
    rows = [
        [AXIS_NAMES[axis], *(_class(column.get(axis, {}), norm) for _, column in columns)] for axis in CRITERION_AXES
    ]
    note = "Margin: below the limit of the class met, in the band that decides, where it is least."
    return Table(f"Class met: {norm.title}", ["", *(name for name, _ in columns)], rows, note, kind="words")


def _class(verdict: Mapping[str, Any], norm: Norm) -> str:
    band, margin = verdict.get("deciding_band_hz"), verdict.get("margin_db")
    if band is None:
        return "not judged"
    if verdict.get("class") is None:
        return f"worse than {norm.classes[0]} ({band} Hz)"
    if margin is None or margin > 100.0:
        return f"{verdict['class']} (at rest)"
    return f"{verdict['class']} ({decibel(margin)} dB, {band} Hz)"


def warnings(results: Results, processing: bool) -> list[str]:
    """Warnings in plain words, each with the results that it holds for; ``processing``: those about a record's."""
    found: dict[str, list[str]] = {}
    for label, result in results.items():
        for text in result.summary.get("warnings", []):
            if bool(PROCESSING.match(text)) == processing:
                found.setdefault(text, []).append(label)
    alone = len(results) == 1
    return [text if alone or len(who) == len(results) else f"{', '.join(who)}: {text}" for text, who in found.items()]


def notes(results: Results) -> dict[str, list[str]]:
    """What each section says before its figures: how to read them, and why some are missing."""
    label, first = next(iter(results.items()))
    tables = [result.summary.get("attenuation_db", {}) for result in results.values()]
    silent = [name for axis, name in AXIS_NAMES.items() if not known(table.get(axis, {}) for table in tables)]
    attenuation = [
        "Up is quieter. Along x, y and z: the mean of the floor at the mounts over the machine's centre of gravity; "
        "roll and pitch: of the plane fitted to the floor, over those of the machine. Gaps are undecided bands."
    ]
    if not floor_moves(first):
        attenuation = ["The ground is at rest: attenuation is not defined."]
    elif silent:
        attenuation.append(
            f"Undecided in every band, since the floor moves too little or the run is short: {'; '.join(silent)}."
        )
    criterion = [
        "The floor at its worst mount, the machine at its centre of gravity; thin lines are the classes' limits."
    ]
    velocities = [result.summary.get("third_octave_velocity", {}) for result in results.values()]
    quiet = []
    for axis in CRITERION_AXES:
        levels = known(table.get(who, {}).get(axis, {}) for table in velocities for who in ("floor", "machine"))
        if not any(level * MICRO > plots.QUIETEST for level in levels):
            quiet.append(AXIS_NAMES[axis])
    if quiet:
        criterion.append(f"Nothing above {plots.QUIETEST:g} µm/s, or not known: {'; '.join(quiet)}.")
    beside = {"spectra": spectra_note(results), "transmissibility": [TRANSMISSIBILITY]}
    if first.dataset.time.size < 2:
        return {**beside, "attenuation": attenuation, "criterion": criterion, "histories": ["Nothing was recorded."]}
    histories = [f"What belongs to single mounts is that of {label}."] if len(results) > 1 else []
    window = characteristic_part(first)
    if window:
        histories.append(f"The lower part of each figure shows {window[0]:.4g} to {window[1]:.4g} s.")
    if not np.any(first.dataset.valve_command.values):
        histories.append("There is no command: the valves stay centred.")
    return {**beside, "attenuation": attenuation, "criterion": criterion, "histories": [" ".join(histories)]}
