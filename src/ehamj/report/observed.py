"""What a scenario asks for beside: response spectra, and motions of one place relative to another."""

from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from ehamj import plots
from ehamj.pages import Picture, Table
from ehamj.pages.words import AXIS_NAMES, CRITERION_AXES, MICRO, measured, scaled
from ehamj.plots import Levels
from ehamj.report.shown import Results

MILLI: Final = 1e3
DASHES: Final = ("--", ":", "-.")


def spectra(results: Results, colors: Mapping[str, str]) -> Iterator[Picture]:
    """Response spectra of floor, machines (CG) and the first result's points, along each axis that moves."""
    kinds = (
        ("velocity", "pseudo-velocity, peak [µm/s]", MICRO, "Response velocity"),
        ("acceleration", "absolute acceleration, peak [mm/s²]", MILLI, "Response acceleration"),
    )
    for axis in CRITERION_AXES:
        for kind, quantity, factor, title in kinds:
            curves = list(_spectrum_curves(results, colors, kind, axis, factor))
            if curves:
                figure = plots.levels(
                    f"{title}, {AXIS_NAMES[axis]}", curves, quantity, "natural frequency of the oscillator [Hz]"
                )
                yield Picture(f"spectrum-{kind}-{axis}", figure)


def _spectrum_curves(
    results: Results, colors: Mapping[str, str], kind: str, axis: str, factor: float
) -> Iterator[Levels]:
    """Floors that are alike once, then machines, then the first result's points (dashed); only what moves."""
    floors: list[Any] = []
    points: list[Levels] = []
    for label, result in results.items():
        spectrum = result.summary.get("response_spectrum")
        if spectrum is None:
            continue
        frequency = np.array(spectrum["frequency_hz"])
        for place, axes in spectrum[kind].items():
            values = factor * np.array(axes[axis], float)
            if not np.nanmax(values, initial=0.0) > 0.0:
                continue
            if place == "floor" and axes[axis] not in floors:
                floors.append(axes[axis])
                who = "floor" if len(floors) == 1 else f"floor of {label}"
                yield Levels(who, frequency, values, plots.FLOOR_COLOR)
            elif place == "machine":
                yield Levels(label, frequency, values, colors[label])
            elif place != "floor" and label == next(iter(results)):
                dash = DASHES[len(points) % len(DASHES)]
                points.append(Levels(f"{label}, {place}", frequency, values, plots.INK, dash))
    yield from points


def spectra_note(results: Results) -> list[str]:
    """How to read the response spectra; nothing where there are none."""
    dampings = [
        result.summary["response_spectrum"]["damping"]
        for result in results.values()
        if result.summary.get("response_spectrum") is not None
    ]
    if not dampings:
        return []
    return [
        f"What an oscillator of one degree of freedom (damping ratio {dampings[0]:g}) would do on the floor at its "
        "worst mount, on the machine at its centre of gravity, and at its points (dashed): 2πf times its peak "
        "displacement relative to its base, and its peak absolute acceleration, over its natural frequency f."
    ]


def relative_figures(results: Results, colors: Mapping[str, str]) -> Iterator[Picture]:
    """Third-octave displacement of each relative motion, all axes together."""
    for name, first in next(iter(results.values())).summary.get("relative", {}).items():
        curves = []
        for label, result in results.items():
            table = (
                result.summary.get("relative", {}).get(name, {}).get("third_octave_displacement", {}).get("total", {})
            )
            values = np.array([np.nan if level is None else MICRO * level for level in table.values()])
            if np.nanmax(values, initial=0.0) > 0.0:
                curves.append(Levels(label, np.array([float(band) for band in table]), values, colors[label]))
        if curves:
            title = f"Relative motion, {name}"
            figure = plots.levels(title, curves, "RMS displacement per band [µm]")
            caption = f"{first['from']} against {first['to']}; all three axes together."
            yield Picture(f"relative-{name}", figure, caption)


def relative_table(results: Results) -> Table | None:
    """Peak and RMS of each relative motion; None where there is none."""
    rows: list[list[str]] = []
    tables = [result.summary.get("relative", {}) for result in results.values()]
    for name, about in tables[0].items():
        rows.append([f"{name}: {about['from']} against {about['to']}"])
        for part in ("x", "y", "z", "total"):
            cells = [
                measured(scaled(table.get(name, {}).get(kind, {}).get(part), MICRO))
                for table in tables
                for kind in ("peak", "rms")
            ]
            rows.append([{"total": "distance"}.get(part, part), *cells])
    if not rows:
        return None
    head = ["", *(f"{label}, {kind}" for label in results for kind in ("peak", "RMS"))]
    note = "About its value at the start of the run."
    return Table("Relative motion [µm]", head, rows, note, kind="numbers wide")
