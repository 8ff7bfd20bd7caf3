"""Tables of measured numbers: bands, peaks, limits, oil and computation."""

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import product
from typing import Any, Final

from ehamj.pages import Table
from ehamj.pages.words import (
    BAR,
    DASH,
    ENGINEERING,
    LITRE_PER_MINUTE,
    MICRO,
    NEGLIGIBLE,
    TURNS,
    decibel,
    exact,
    measured,
    number,
    scaled,
)
from ehamj.plant.mounts import MOUNTS
from ehamj.report.shown import Results, ground_parts
from ehamj.result import Result

OF_THE_LAW: Final = ("measured", "controller_state")
"""Variables that repeat what the controller saw and how it counts; they stand in the result, not in the table."""


def facts(result: Result) -> list[tuple[str, str]]:
    """What was simulated, in a few lines."""
    scenario, timing = result.scenario, result.summary.get("timing", {})
    plant, supply = scenario.plant, scenario.supply
    kinds = [getattr(part, "kind", "") for part in ground_parts(scenario)]
    facts = [
        ("machine", f"{exact(plant.total_mass)} kg with its plates, on four mounts ({scenario.plates} plates)"),
        ("supply", f"{exact(BAR * supply.pressure)} bar, tank {exact(BAR * supply.tank_pressure)} bar (absolute)"),
        ("floor", " + ".join(kinds)),
        ("control", scenario.control.kind),
        ("simulated", f"{exact(timing.get('simulated_s', 0.0))} of {exact(scenario.duration)} s, seed {scenario.seed}"),
    ]
    law = result.controller
    if law is not None:
        bits = "exact" if law.bits is None else f"{law.bits} bit"
        facts.insert(
            4,
            (
                "law",
                f"{law.states} states, {len(law.inputs)} inputs, "
                + " + ".join(
                    f"{exact(1e-3 / part.period)} kHz, delay {exact(1e3 * part.latency)} ms" for part in law.parts
                )
                + f", ±{exact(law.voltage_limit)} V, {bits}",
            ),
        )
    instruments = [(name, getattr(scenario.sensors, name)) for name in type(scenario.sensors).model_fields]
    if law is not None:
        named = [
            f"{name} ({sensor.kind})" if name in ("ground", "inertial") else name
            for name, sensor in instruments
            if sensor is not None
        ]
        facts.append(("sensors", ", ".join(named) or "exact"))
    if scenario.force:
        places = (force.point if isinstance(force.point, str) else str(list(force.point)) for force in scenario.force)
        pushed = [f"{force.kind} at {place}" for force, place in zip(scenario.force, places, strict=True)]
        facts.append(("forces on the machine", ", ".join(pushed)))
    analysis = result.summary.get("analysis")
    if analysis:
        facts.append(("levels taken", f"from {exact(analysis['from_s'])} to {exact(analysis['to_s'])} s"))
    return facts


def bands_table(results: Results) -> Table:
    """Vertical levels and attenuation per band."""
    first = next(iter(results.values())).summary
    head = ["band [Hz]", "floor [µm/s]"]
    for label in results:
        head += [f"{label} [µm/s]", f"{label} [dB]"]
    rows = []
    for band, level in first.get("third_octave_velocity", {}).get("floor", {}).get("z", {}).items():
        row = [band, measured(scaled(level, MICRO))]
        for result in results.values():
            machine = result.summary.get("third_octave_velocity", {}).get("machine", {}).get("z", {})
            attenuation = result.summary.get("attenuation_db", {}).get("z", {})
            row += [measured(scaled(machine.get(band), MICRO)), decibel(attenuation.get(band))]
        if set(row[1:]) != {DASH}:
            rows.append(row)
    note = (
        "Levels: RMS velocity, of the floor at its worst mount, of the machine at its centre of gravity. Attenuation "
        "is counted from the mean of the mounts, which a passing wave makes smaller than a single mount's motion."
    )
    return Table("Vertical, per third-octave band", head, rows, note)


def levels(results: Results) -> Table:
    """Peak and RMS of every channel that moves."""
    rows: list[list[str]] = []
    data = next(iter(results.values())).dataset
    for name in data.data_vars:
        if name in OF_THE_LAW:
            continue
        channel = str(name).replace("_", " ").replace("cg", "CG").replace("ground", "floor")
        for part in _parts(results, str(name)):
            factor, unit = _unit(str(data[name].attrs.get("units", "")), part)
            values = [
                scaled(_worst(result.summary.get(kind, {}).get(name), part.split()), factor)
                for result in results.values()
                for kind in ("peak", "rms")
            ]
            if any(value is not None and abs(value) > NEGLIGIBLE for value in values):
                rows.append([f"{channel} {part}".strip() + f" [{unit}]", *map(measured, values)])
    head = ["about the equilibrium", *(f"{label}, {kind}" for label in results for kind in ("peak", "RMS"))]
    note = "What each mount has: the largest of the four. Channels that do not move are left out."
    return Table("Peak and RMS", head, rows, note, kind="numbers wide")


def _parts(results: Results, name: str) -> list[str]:
    """Names of a channel's parts without the mounts: its axes, points and axes, …; '' where it has none."""
    data = next(iter(results.values())).dataset[name]
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


def saturation(results: Results) -> Table:
    """Share of the time at each limit, per mount."""
    rows = []
    for label, result in results.items():
        if len(results) > 1:
            rows.append([label])
        for limit_name, shares in result.summary.get("saturation", {}).items():
            percent = [measured(scaled(shares.get(mount), 100.0)) for mount in MOUNTS]
            rows.append([limit_name.replace("_", " "), *percent])
    return Table("Share of the time at a limit [%]", ["", *MOUNTS], rows)


def oil(results: Results) -> Table:
    quantities = (
        ("mean flow [l/min]", "mean_flow_m3_s", LITRE_PER_MINUTE),
        ("peak flow [l/min]", "peak_flow_m3_s", LITRE_PER_MINUTE),
        ("volume [l]", "volume_m3", 1e3),
        ("mean power [W]", "mean_power_w", 1.0),
    )
    return _per_result("Oil drawn from the supply", "oil", quantities, results, "All mounts together.")


def timing(results: Results) -> Table:
    quantities = (
        ("simulated [s]", "simulated_s", 1.0),
        ("step [µs]", "timestep_s", 1e6),
        ("steps", "steps", 1.0),
        ("stepping [s]", "stepping_s", 1.0),
        ("in all [s]", "wall_s", 1.0),
        ("simulated over stepping", "ratio", 1.0),
    )
    return _per_result("Computation", "timing", quantities, results, "")


def _per_result(title: str, key: str, quantities: Iterable[tuple[str, str, float]], results: Results, n: str) -> Table:
    tables = [result.summary.get(key, {}) for result in results.values()]
    rows = [[text, *(number(scaled(table.get(name), factor)) for table in tables)] for text, name, factor in quantities]
    return Table(title, ["", *results], rows, n)
