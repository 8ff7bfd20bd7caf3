"""Tables of measured numbers: bands, peaks, and computation."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any, Final

import xarray as xr

from ehamj.criteria.verdict import WHOLE
from ehamj.estimate.sliding import TIMES as AVERAGING
from ehamj.estimate.statistics import WORDS
from ehamj.judge.verdicts import Criterion
from ehamj.pages import Section, Table
from ehamj.pages.words import DASH, ENGINEERING, MICRO, NEGLIGIBLE, TURNS, decibel, exact, measured, scaled
from ehamj.report.sections.limits import of_each
from ehamj.report.shown import Shown
from ehamj.result import Result

ALONG: Final = {"z": "Vertical", "x": "Along x", "y": "Along y"}
VELOCITY: Final = {"z": "Vertical velocity", "x": "Velocity along x", "y": "Velocity along y"}
OF_THE_LAW: Final = ("measured", "controller_state")
"""Variables that repeat what the controller saw and how it counts; they stand in the result, not in the table."""

TIMING: Final = (
    ("simulated [s]", "simulated_s", 1.0),
    ("step [µs]", "timestep_s", 1e6),
    ("steps", "steps", 1.0),
    ("stepping [s]", "stepping_s", 1.0),
    ("in all [s]", "wall_s", 1.0),
    ("simulated over stepping", "ratio", 1.0),
)


def numbers(shown: Shown) -> Section:
    """What the figures show, as numbers."""
    of_axes = [table(shown, axis) for axis in shown.judged_axes for table in (_bands, _statistics)]
    computation = of_each("Computation", "timing", TIMING, shown)
    engines = ["engine", *(result.summary.timing.engine for result in shown.results.values())]
    tables = [*of_axes, _levels(shown), replace(computation, rows=[engines, *computation.rows])]
    return Section("tables", "Numbers", tables=tables)


def _bands(shown: Shown, axis: str) -> Table:
    """Levels along an axis and attenuation per band."""
    head = ["band [Hz]", "floor [µm/s]"]
    for label in shown.results:
        head += [f"{label} [µm/s]", f"{label} [dB]"]
    rows = []
    for band, level in shown.first.summary.third_octave_velocity["floor"][axis].items():
        row = [band, measured(scaled(level, MICRO))]
        for result in shown.results.values():
            machine = result.summary.third_octave_velocity["machine"][axis].get(band)
            row += [measured(scaled(machine, MICRO)), decibel(result.summary.attenuation_db[axis].get(band))]
        if set(row[1:]) != {DASH}:
            rows.append(row)
    note = (
        "Levels: RMS velocity over the whole run, of the floor at its worst mount, of the machine at its centre of "
        "gravity. Attenuation is counted from the mean of the mounts, which a passing wave makes smaller than a "
        "single mount's motion."
    )
    return Table(f"{ALONG[axis]}, per third-octave band", head, rows, note)


def _statistics(shown: Shown, axis: str) -> Table:
    """Levels along an axis by every statistic in the bands that decide; without rows in results that are older."""
    tables = {name: place for name, _, place in shown.with_floors(partial(_by_statistic, axis))}
    judged = [result.summary.criterion for result in shown.results.values()]
    bands = dict.fromkeys(band for criterion in judged for band in _deciding(criterion, axis))
    found = [table for table in tables.values() if table]
    rows: list[list[str]] = []
    for band in bands if found else ():
        if band is None or band == WHOLE:
            continue
        seconds = found[0]["averaging"].get(band)
        rows.append([f"in the band at {band} Hz, averaging {exact(round(seconds or 0.0, 2))} s"])
        rows += [
            [WORDS[name], *(measured(scaled(table.get(name, {}).get(band), MICRO)) for table in tables.values())]
            for name in WORDS
            if name != "peak"
        ]
    if found:
        peaks = [table.get("peak", {}).get(WHOLE) for table in tables.values()]
        rows += [["of all frequencies together"], [WORDS["peak"], *(measured(scaled(peak, MICRO)) for peak in peaks)]]
    note = (
        "In the bands that decide the verdict there: of the floor at its worst mount, of the machine at its centre "
        f"of gravity. Fast levels average {exact(AVERAGING['fast'])} s, or 1/bandwidth where that is longer."
    )
    return Table(f"{VELOCITY[axis]} by statistic [µm/s]", ["", *tables], rows, note, kind="numbers wide")


def _deciding(criterion: Criterion, axis: str) -> Iterator[str | None]:
    """Bands that decide along an axis: of the floor, of the machine where it is worst and at its CG."""
    yield criterion.floor[axis].deciding_band
    if criterion.decisive is not None:
        parts = (criterion.decisive.vertical, criterion.decisive.horizontal)
        yield from (part.worst.verdict.deciding_band for part in parts if part.worst.axis == axis)
    yield criterion.machine[axis].deciding_band


def _by_statistic(axis: str, result: Result) -> dict[str, Any]:
    """Of floor and machine: levels along an axis by statistic and band, and the averaging times."""
    summary = result.summary
    if summary.levels is None:
        return {}
    levels, averaging = summary.levels, summary.levels.averaging_s["max_1s"]
    return {
        place: {
            "averaging": averaging,
            "peak": {WHOLE: levels.peak[place][axis]},
            **{name: summary.in_bands("velocity", name)[place][axis] for name in ("rms", *levels.velocity)},
        }
        for place in ("floor", "machine")
    }


def _levels(shown: Shown) -> Table:
    """Peak and RMS of every channel that moves."""
    rows: list[list[str]] = []
    data = shown.first.dataset
    for name in data.data_vars:
        if name in OF_THE_LAW:
            continue
        channel = str(name).replace("_", " ").replace("cg", "CG").replace("ground", "floor")
        for part in _parts(data[name]):
            factor, unit = _unit(str(data[name].attrs.get("units", "")), part)
            values = [
                scaled(_worst(getattr(result.summary, kind).get(name), part.split()), factor)
                for result in shown.results.values()
                for kind in ("peak", "rms")
            ]
            if any(value is not None and abs(value) > NEGLIGIBLE for value in values):
                rows.append([f"{channel} {part}".strip() + f" [{unit}]", *map(measured, values)])
    head = ["about the equilibrium", *(f"{label}, {kind}" for label in shown.results for kind in ("peak", "RMS"))]
    note = "What each mount has: the largest of all. Channels that do not move are left out."
    return Table("Peak and RMS", head, rows, note, kind="numbers wide")


def _parts(data: xr.DataArray) -> list[str]:
    """Names of a channel's parts without the mounts: its axes, points and axes, …; '' where it has none."""
    inner = [data[dimension].values for dimension in data.dims if dimension not in ("time", "mount")]
    return [" ".join(map(str, labels)) for labels in product(*inner)]


def _worst(table: Any, part: Sequence[str]) -> float | None:
    """A part's value; where there is one per mount, the largest."""
    if not isinstance(table, Mapping):
        return table if isinstance(table, float | int) else None
    if part and part[0] in table:
        return _worst(table[part[0]], part[1:])
    values = [_worst(inner, part) for inner in table.values()]
    return max((value for value in values if value is not None), default=None)


def _unit(units: str, part: str) -> tuple[float, str]:
    """Factor and unit in which a channel's part is shown; units may tell turns apart: 'm (rx, ry, rz: rad)'."""
    turned = re.fullmatch(r"(\S+) \(rx, ry, rz: (\S+)\)", units)
    if turned:
        units = turned.group(2 if part in TURNS else 1)
    return ENGINEERING.get(units, (1.0, units))
