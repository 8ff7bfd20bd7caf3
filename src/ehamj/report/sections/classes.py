"""Floor and machine before the first norm: levels against its curves, and the class met along each axis."""

from collections.abc import Mapping, Sequence
from functools import partial

from ehamj.criteria.curves import Norm
from ehamj.criteria.verdict import Verdict
from ehamj.estimate.statistics import WORDS, Statistic
from ehamj.judge.decisive import place_in_words
from ehamj.judge.places import AtPlace
from ehamj.pages import Section, Table
from ehamj.pages.words import AXIS_NAMES, CRITERION_AXES
from ehamj.report.levels import mixed_in
from ehamj.report.sections.criteria import figures_of, first_views
from ehamj.report.shown import Shown
from ehamj.report.verdict import class_met
from ehamj.result import Result


def classes(shown: Shown) -> Section:
    """Levels before the first norm, and the class per axis of the floor and of each machine where it is worst, with
    margin, band and place: by the verdict's levels, and by the largest second."""
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
    table = Table(f"Class met: {norm.title}", ["", *columns], rows, note, kind="words")
    figures = list(figures_of(shown, first, norm, first_views(shown)))
    return Section("classes", "Before and after", figures, [table], kind="sheet" if figures else "")


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
