"""What norms say: levels against the curves of each, and the classes met at every place."""

from collections.abc import Collection, Iterator, Mapping
from functools import partial
from typing import Any, Final

import numpy as np

from ehamj import plots
from ehamj.criteria.curves import CANDIDATES, Norm
from ehamj.criteria.vc import EXTENDED
from ehamj.criteria.verdict import where
from ehamj.estimate.statistics import SHORT, BandStatistic
from ehamj.judge.decisive import decibel, place_in_words, unit_of
from ehamj.judge.places import AtPlace
from ehamj.pages import Picture, Section, Table
from ehamj.pages.words import AXIS_NAMES, CRITERION_AXES, MICRO, scaled
from ehamj.plots import Levels, Line
from ehamj.records.units import Quantity
from ehamj.report.shown import Shown, known
from ehamj.report.verdict import class_met
from ehamj.result import Result

VIEWS: Final = {"z": "vertical, z", "xy": "horizontal"}
EQUIVALENT: Final = "Levels of other quantities: as the velocity that they have at the band's centre."
CURVE_COLOR: Final = "#4B5563"
SWINGS: Final = "The swing of each that comes nearest to a limit, along the worst axis."
WORSE: Final = "The worse of x and y in each band."


def criteria(shown: Shown) -> Section:
    """Levels of floor and machines beside the norms that judge the first result."""
    norms, front = shown.norms, first_views(shown)
    figures = [
        picture
        for k, (name, norm) in enumerate(norms.items())
        for picture in figures_of(shown, name, norm, [view for view in views_of(name) if k or view not in front])
    ]
    return Section("criterion", "Criteria", figures, [_at_places(shown, norms)], _notes(shown))


def views_of(name: str) -> Mapping[str, str]:
    """The views in which a norm is drawn, in words: VC curves along each axis."""
    return {axis: AXIS_NAMES[axis] for axis in CRITERION_AXES} if name == "vc" else VIEWS


def first_views(shown: Shown) -> tuple[str, ...]:
    """Views of the first norm that stand in front: the vertical, and that in which the machine is worst across."""
    name, norm = next(iter(shown.norms.items()))
    if name != "vc":
        return tuple(VIEWS)
    places = dict(shown.first.summary.criteria[name].places)
    places.pop("floor")
    return "z", min("xy", key=lambda axis: min(norm.rank(place[axis]) for place in places.values()))


def figures_of(shown: Shown, name: str, norm: Norm, views: Collection[str]) -> Iterator[Picture]:
    """Floor and machines against the curves of a norm, if it has curves, in some of its views."""
    if norm.swinging:
        yield from _swings(shown, name, norm, views)
    if not any(norm.needed(axis) for axis in CRITERION_AXES):
        return
    usable = {result.summary.analysis.usable_to_hz for result in shown.results.values()}
    known_to = min((value for value in usable if value is not None), default=None)
    for view in views:
        words = views_of(name)[view]
        curves = [
            Levels.of_bands(label, table, color)
            for label, color, table in shown.with_floors(partial(_seen, norm, view))
            if max(known([table]), default=0.0) > plots.QUIETEST  # what hardly moves is left out
        ]
        if not curves:
            continue
        quantity = f"velocity, {SHORT[_statistic(norm)]} [µm/s]"
        title = "Velocity and vibration classes" if name == "vc" else norm.title
        limits = _limits(norm, view[0])
        figure = plots.criterion(f"{title}, {words}", curves, limits, known_to, quantity)
        of_levels = "" if name == "vc" else EQUIVALENT
        caption = " ".join(text for text in (WORSE if len(view) > 1 else "", of_levels, norm.note) if text)
        yield Picture(f"criterion-{view}" if name == "vc" else f"criterion-{name}-{view}", figure, caption)


def _statistic(norm: Norm) -> BandStatistic:
    """Of the levels that a norm compares in bands."""
    for _, statistic in sorted(norm.kinds):
        if statistic != "peak":
            return statistic
    return "rms"


def _swings(shown: Shown, name: str, norm: Norm, views: Collection[str]) -> Iterator[Picture]:
    """Peaks at the frequency of their swing, against limits that depend on it."""
    for view in views:
        words = VIEWS[view]
        of_classes = {own: norm.limit(own, view[0], None) for own in norm.classes}
        limits = {own: limit for own, limit in of_classes.items() if limit is not None and limit.corners}
        if not limits:
            continue
        first = next(iter(limits.values()))
        factor, unit = unit_of(first.quantity, first.value)
        points = []
        for label, color, places in shown.with_floors(partial(_sides, name)):
            verdict = min((place[axis] for place in places for axis in view), key=norm.rank)
            if verdict.peak and verdict.peak_hz:
                points.append(Line(label, [verdict.peak_hz], [factor * verdict.peak], color, marker="o"))
        if not points:
            continue
        frequency = np.geomspace(1.0, 200.0, 200)
        lines = [
            Line(own, frequency, factor * limit.over(frequency), CURVE_COLOR, dash=k)
            for k, (own, limit) in enumerate(limits.items())
        ]
        title = f"{norm.title}, {words}"
        figure = plots.lines_chart(title, "frequency of the swing [Hz]", {f"peak [{unit}]": [*lines, *points]}, "xy")
        yield Picture(f"criterion-{name}-{view}", figure, f"{SWINGS} {norm.note}")


def _sides(name: str, result: Result) -> dict[str, list[AtPlace]]:
    """What a norm says of the floor, and of each of the machine's places."""
    places = dict(result.summary.criteria[name].places)
    return {"floor": [places.pop("floor")], "machine": list(places.values())}


def _notes(shown: Shown) -> list[str]:
    """How to read the figures, and why some are missing."""
    found = [
        "The floor at its worst mount; the machine at the worst of its places in each band, as it is judged: centre of "
        "gravity, feet and points. Thin lines are the classes' limits."
    ]
    found += [EXTENDED] if "vc" in shown.norms else []
    velocities = [result.summary.third_octave_velocity for result in shown.results.values()]
    loudest = {
        axis: max(known(table[who][axis] for table in velocities for who in ("floor", "machine")), default=0.0)
        for axis in CRITERION_AXES
    }
    quiet = [AXIS_NAMES[axis] for axis, level in loudest.items() if level * MICRO <= plots.QUIETEST]
    if quiet:
        found.append(f"Nothing above {plots.QUIETEST:g} µm/s, or not known: {'; '.join(quiet)}.")
    return found


def _limits(norm: Norm, axis: str) -> dict[str, tuple[Any, Any]]:
    """Bands and limits of each class, as velocity [µm/s]."""
    found = {}
    for name in norm.classes:
        limits = {band: limit for band in CANDIDATES if (limit := norm.limit(name, axis, band)) is not None}
        velocities = MICRO * np.array([limit.as_velocity(band) for band, limit in limits.items()])
        found[norm.marks.get(name, name)] = np.array([band.nominal for band in limits]), velocities
    return found


def _seen(norm: Norm, view: str, result: Result) -> dict[str, dict[str, float | None]]:
    """Levels of floor and machine per band of what the norm limits there, as velocity [µm/s].

    The machine is where it is worst in each band, as it is judged. Velocity where the norm limits nothing; of several
    axes the largest; None where nothing is known.
    """
    of_band = {band.name: band for band in CANDIDATES}
    found: dict[str, dict[str, float | None]] = {"floor": {}, "machine": {}}
    for who, levels in found.items():
        for name in result.summary.third_octave_velocity[who][view[0]]:
            band = of_band.get(name)
            limit = None if band is None else norm.limit(norm.classes[-1], view[0], band)
            quantity: Quantity = "velocity" if limit is None else limit.quantity
            tables = result.summary.in_bands(quantity, _statistic(norm))
            places = [table for place, table in tables.items() if (place == "floor") == (who == "floor")]
            level = max(known({axis: table.get(axis, {}).get(name) for axis in view} for table in places), default=None)
            share = 1.0 if limit is None or band is None else limit.as_velocity(band) / limit.value
            levels[name] = scaled(level, MICRO * share)
    return found


def _at_places(shown: Shown, norms: Mapping[str, Norm]) -> Table:
    """By each norm, what is met at floor, feet, CG and points, vertically and horizontally."""
    rows: list[list[str]] = []
    for name, norm in norms.items():
        rows.append([norm.title])
        floors: list[Any] = []
        for label, result in shown.results.items():
            for place, judged in result.summary.criteria[name].places.items():
                if place == "floor" and judged in floors:
                    continue
                floors += [judged] if place == "floor" else []
                who = place if place == "floor" and len(floors) == 1 else f"{label}, {place_in_words(place)}"
                rows.append([who, *(_met(judged, axes, norm) for axes in (("z",), ("x", "y")))])
    head = ["", "vertical", "horizontal"]
    return Table("Criteria at every place", head, rows, _note(shown, norms), kind="words")


def _met(place: AtPlace, axes: tuple[str, ...], norm: Norm) -> str:
    """The class that the worst of some axes meets, with margin or excess, axis and band."""
    axis = min(axes, key=lambda axis: norm.rank(place[axis]))
    worse = f"{decibel(place[axis].excess_db or 0.0)} dB over"
    return class_met(place[axis], norm, worse, axis if len(axes) > 1 else "")


def _note(shown: Shown, norms: Mapping[str, Norm]) -> str:
    """How to read the table, and what is undecided by which norm."""
    words = "The floor at its worst mount. In brackets the margin, and the axis and band that decide."
    missing = []
    for name, norm in norms.items():
        bands = dict.fromkeys(
            band
            for result in shown.results.values()
            for verdict in result.summary.criteria[name].places["machine"].along(CRITERION_AXES)
            for band in verdict.undecided
        )
        if bands:
            missing.append(f"{norm.title}: {where(list(bands)).removeprefix('at ')}")
    return words + (f" Undecided: {'; '.join(missing)}." if missing else "")
