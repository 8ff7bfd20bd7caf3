"""What stands on top of the page: attenuation at a few bands, classes met, warnings."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Final

from ehamj.criteria.curves import Norm
from ehamj.criteria.verdict import Verdict
from ehamj.estimate.statistics import WORDS, Statistic
from ehamj.judge.brief import MEAN, PROCESSING
from ehamj.judge.decisive import place_in_words
from ehamj.judge.faults import WHOLE
from ehamj.judge.places import AtPlace
from ehamj.judge.worse import cancelled
from ehamj.pages import Section, Table
from ehamj.pages.words import AXIS_NAMES, CRITERION_AXES, DASH, decibel
from ehamj.plant.axes import AXES
from ehamj.report.shown import Shown, floor_moves, known
from ehamj.report.verdict import class_met
from ehamj.result import Result

OF_LEVELS: Final = "Of the RMS over the whole run."
"""What attenuation is of."""
WORST: Final = (
    "Worst place: of the centre of gravity, each foot and every point, the one with least in that band; a foot is held "
    "against the ground below it, all else against the mean of the floor."
)
HEADLINE_BANDS: Final = ("5", "10", "20", "50", "100")

OLDER: Final = (
    "levels of this result are those of an earlier version, through one Hann window over the run, which says little of "
    "what strikes near its ends: run it again for those of the whole run"
)
"""What to know of a result whose levels are not the whole run's."""

MIXED: Final = f" Where something failed: {WHOLE}; see Faults for each part."


def mixed_in(shown: Shown) -> str:
    """What to know of levels of the whole run, where something failed in one."""
    return MIXED if any(result.summary.mixed for result in shown.results.values()) else ""


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
    title = f"{'Attenuation' if several else 'Vertical attenuation'} [dB] in the third-octave bands at"
    table = Table(title, ["", *(f"{band} Hz" for band in HEADLINE_BANDS)], rows, note)
    return Section("headline", tables=[table], notes=() if rows else [note], kind="headline")


def classes(shown: Shown) -> Section:
    """Vibration class per axis of the floor and of each machine where it is worst, with margin, band and place: by the
    verdict's levels, and by the largest second."""
    first, norm = next(iter(shown.norms.items()))
    columns = {name: places for name, _, places in shown.with_floors(partial(_places, first))}
    verdicts = [_worst(places, axis, norm)[1] for places in columns.values() for axis in CRITERION_AXES]
    compared = dict.fromkeys(verdict.statistic for verdict in verdicts)
    rows = [[_by([name for name in compared if name])], *_met(columns, norm)]
    beside = {name: places for name, _, places in shown.with_floors(_by_largest_second)}
    if all(beside.values()) and "max_1s" not in compared:
        rows += [[_by(["max_1s"])], *_met(beside, norm)]
    note = "At the worst of the machine's places. Margin: below the limit of the class met, in the band that decides."
    if any(verdict.peak is not None for verdict in verdicts):
        note = "At the worst of the machine's places. Margin: below the limit of the class met, of the nearest peak."
    note += mixed_in(shown)
    rows = [row for row in rows if row != [""]]
    return Section("classes", tables=[Table(f"Class met: {norm.title}", ["", *columns], rows, note, kind="words")])


def _places(norm: str, result: Result) -> dict[str, dict[str, AtPlace]]:
    """What a norm says of the floor, and of every place of the machine."""
    return _floor_and_machine(result.summary.criteria[norm].places)


def _by_largest_second(result: Result) -> dict[str, dict[str, AtPlace]]:
    """The same of the first norm by the largest second; nothing where it is not known of every place."""
    beside = result.summary.criterion.max_1s
    if beside is None or not beside.places:
        return {}
    return _floor_and_machine(beside.places)


def _floor_and_machine(places: Mapping[str, AtPlace]) -> dict[str, dict[str, AtPlace]]:
    machine = dict(places)
    return {"floor": {"floor": machine.pop("floor")}, "machine": machine}


def _worst(places: Mapping[str, AtPlace], axis: str, norm: Norm) -> tuple[str, Verdict]:
    """The place where an axis is worst, and its verdict."""
    judged: dict[str, Verdict] = {place: found[axis] for place, found in places.items()}
    return min(judged.items(), key=lambda item: norm.rank(item[1]))


def _met(columns: Mapping[str, Mapping[str, AtPlace]], norm: Norm) -> list[list[str]]:
    """A row of classes per axis."""
    rows = []
    for axis in CRITERION_AXES:
        found = [_worst(places, axis, norm) for places in columns.values()]
        cells = [
            class_met(verdict, norm, "worse than", place="" if place == "floor" else place_in_words(place))
            for place, verdict in found
        ]
        rows.append([AXIS_NAMES[axis], *cells])
    return rows


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
