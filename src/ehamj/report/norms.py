"""What norms say: levels against the curves of each, and the classes met at every place."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from ehamj import plots
from ehamj.criteria.curves import CANDIDATES, Norm
from ehamj.criteria.iso2631 import FACTORS
from ehamj.pages import Picture, Table
from ehamj.pages.words import AXIS_NAMES, CRITERION_AXES, DASH, MICRO, decibel
from ehamj.plots import Levels
from ehamj.report.shown import Results

EQUIVALENT: Final = "RMS velocity at the band's centre [µm/s]"
MULTIPLES: Final = {name: f"×\u202f{factor:g}" for name, factor in FACTORS.items()}
CLASS_LABELS: Final = {"iso-2631-2": MULTIPLES}
CAPTIONS: Final = {
    "nist-a": "Up to 20 Hz the limit is one of displacement, 0.025 µm: levels there are displacements, drawn as the "
    "velocity that they have at the band's centre.",
    "iso-2631-2": "Accelerations, drawn as the velocity that they have at the band's centre. Multiples of the base "
    f"curve: {', '.join(f'{multiple} {name}' for name, multiple in MULTIPLES.items())}.",
}
VIEWS: Final = {"z": "vertical, z", "xy": "horizontal"}
WORSE: Final = "The worse of x and y in each band."


def norms_of(results: Results) -> dict[str, Norm]:
    """The norms that judge the first result."""
    first = next(iter(results.values()))
    return first.scenario.criteria.chosen() if first.summary.get("criteria") else {}


def criterion(results: Results, colors: Mapping[str, str]) -> Iterator[Picture]:
    """Floor and machines against the curves of each norm; VC curves along each axis."""
    usable = {result.summary.get("analysis", {}).get("usable_to_hz") for result in results.values()}
    known_to = min((value for value in usable if value is not None), default=None)
    for name, norm in norms_of(results).items():
        views = {axis: AXIS_NAMES[axis] for axis in CRITERION_AXES} if name == "vc" else VIEWS
        for view, words in views.items():
            curves = list(_curves(results, norm, view, colors))
            if not curves:
                continue
            quantity = "RMS velocity per band [µm/s]" if name == "vc" else EQUIVALENT
            title = "Velocity and vibration classes" if name == "vc" else norm.title
            limits = _limits(norm, view[0], CLASS_LABELS.get(name, {}))
            figure = plots.criterion(f"{title}, {words}", curves, limits, known_to, quantity)
            caption = " ".join(text for text in (WORSE if len(view) > 1 else "", CAPTIONS.get(name, "")) if text)
            yield Picture(f"criterion-{view}" if name == "vc" else f"criterion-{name}-{view}", figure, caption)


def _limits(norm: Norm, axis: str, labels: Mapping[str, str]) -> dict[str, tuple[Any, Any]]:
    """Bands and limits of each class, as velocity [µm/s]."""
    found = {}
    for name in norm.classes:
        limits = [(band, limit) for band in CANDIDATES if (limit := norm.limit(name, axis, band)) is not None]
        frequency = np.array([band.nominal for band, _ in limits])
        found[labels.get(name, name)] = (
            frequency,
            MICRO * np.array([limit.as_velocity(band) for band, limit in limits]),
        )
    return found


def _curves(results: Results, norm: Norm, view: str, colors: Mapping[str, str]) -> Iterator[Levels]:
    """Levels of floor and machines as a norm sees them; floors that are alike once, what hardly moves not at all."""
    floors: list[Any] = []
    for label, result in results.items():
        floor = _seen(result.summary, norm, "floor", view)
        if not any(_alike(floor, known) for known in floors):
            floors.append(floor)
            who = "floor" if len(floors) == 1 else f"floor of {label}"
            yield from _curve(who, floor, plots.FLOOR_COLOR)
    for label, result in results.items():
        yield from _curve(label, _seen(result.summary, norm, "machine", view), colors[label])


def _curve(label: str, table: Mapping[str, float], color: str) -> Iterator[Levels]:
    values = np.array(list(table.values()))
    if np.isfinite(values).any() and np.nanmax(values) > plots.QUIETEST:
        yield Levels(label, np.array([float(band) for band in table]), values, color)


def _alike(one: Mapping[str, float], other: Mapping[str, float]) -> bool:
    return np.array_equal(list(one.values()), list(other.values()), equal_nan=True)


def _seen(summary: Mapping[str, Any], norm: Norm, place: str, view: str) -> dict[str, float]:
    """Level per band of what the norm limits there, as velocity [µm/s]; velocity where it limits nothing.

    Of several axes the largest. NaN where nothing is known.
    """
    of_band = {band.name: band for band in CANDIDATES}
    velocities = summary.get("third_octave_velocity", {}).get(place, {}).get(view[0], {})
    found = {}
    for name in velocities:
        band = of_band.get(name)
        limit = None if band is None else norm.limit(norm.classes[-1], view[0], band)
        quantity = "velocity" if limit is None else limit.quantity
        tables = summary.get(f"third_octave_{quantity}", {}).get(place, {})
        level = max((value for axis in view if (value := tables.get(axis, {}).get(name)) is not None), default=math.nan)
        share = 1.0 if limit is None or band is None else limit.as_velocity(band) / limit.value
        found[name] = MICRO * level * share
    return found


def classes_at_places(results: Results) -> Table | None:
    """By each norm, what is met at floor, feet, CG and points, vertically and horizontally; None without norms."""
    norms = norms_of(results)
    rows: list[list[str]] = []
    for name, norm in norms.items():
        rows.append([norm.title])
        tables = {
            label: result.summary.get("criteria", {}).get(name, {}).get("places", {})
            for label, result in results.items()
        }
        floors: list[Any] = []
        for label, table in tables.items():
            for place, judged in table.items():
                if place == "floor" and judged in floors:
                    continue
                floors += [judged] if place == "floor" else []
                who = place if place == "floor" and len(floors) == 1 else f"{label}, {place_in_words(place)}"
                rows.append([who, *(_met(judged, axes, norm) for axes in (("z",), ("x", "y")))])
    note = _note(results, norms)
    return Table("Criteria at every place", ["", "vertical", "horizontal"], rows, note, kind="words") if rows else None


def place_in_words(place: str) -> str:
    return {"feet": "worst foot", "machine": "centre of gravity"}.get(place, place)


def _met(place: Mapping[str, Any], axes: tuple[str, ...], norm: Norm) -> str:
    """The class that the worst of some axes meets, with margin or excess, axis and band."""
    judged = {axis: place[axis] for axis in axes if place.get(axis, {}).get("deciding_band_hz") is not None}
    if not judged:
        return "not judged"

    def rank(axis: str) -> tuple[int, float]:
        verdict = judged[axis]
        if verdict["class"] is None:
            return -1, -verdict["excess_db"]
        return norm.classes.index(verdict["class"]), math.inf if verdict["margin_db"] is None else verdict["margin_db"]

    axis = min(judged, key=rank)
    verdict, along = judged[axis], f"{axis} at " if len(axes) > 1 else ""
    where = f"{along}{verdict['deciding_band_hz']} Hz"
    if verdict["class"] is None:
        return f"{decibel(verdict['excess_db'])} dB over {norm.classes[0]} ({where})"
    if verdict["margin_db"] is None or verdict["margin_db"] > 100.0:
        return f"{verdict['class']} (at rest)"
    return f"{verdict['class']} ({decibel(verdict['margin_db'])} dB, {where})"


def _note(results: Results, norms: Mapping[str, Norm]) -> str:
    """How to read the table, and what is undecided by which norm."""
    words = "The floor at its worst mount. In brackets the margin, and the axis and band that decide."
    missing = []
    for name, norm in norms.items():
        bands = dict.fromkeys(
            band
            for result in results.values()
            if (places := result.summary.get("criteria", {}).get(name, {}).get("places"))
            for axis in CRITERION_AXES
            for band in places["machine"][axis]["undecided_bands_hz"]
        )
        if bands:
            missing.append(f"{norm.title}: {', '.join(bands)} Hz")
    return words + (f" Undecided: {'; '.join(missing)}." if missing else "")


def attenuation_at_places(results: Results, bands: tuple[str, ...]) -> Table | None:
    """Vertical attenuation at feet, CG and points in a few bands; None where nothing is known."""
    rows: list[list[str]] = []
    for label, result in results.items():
        tables = {"machine": result.summary.get("attenuation_db", {}), **result.summary.get("attenuation_at_db", {})}
        own = [
            [place_in_words(place), *(decibel(table.get("z", {}).get(band)) for band in bands)]
            for place, table in tables.items()
        ]
        if any(cell != DASH for row in own for cell in row[1:]):
            rows += [[label]] if len(results) > 1 else []
            rows += own
    note = "Centre of gravity and points: of the mean of the floor; worst foot: of the ground below it."
    head = ["", *(f"{band} Hz" for band in bands)]
    return Table("Vertical attenuation at every place [dB]", head, rows, note) if rows else None
