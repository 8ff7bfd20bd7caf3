"""Tables of how near a run came to its limits: peaks, and when a limit was reached."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.pages import Section, Table
from ehamj.pages.words import BAR, DASH, LITRE_PER_MINUTE, measured, number, scaled
from ehamj.report.shown import Shown
from ehamj.result import Result

COLUMNS: Final = 6
"""Mounts up to which each has a column."""


@dataclass(frozen=True)
class Limits:
    """What each mount cannot pass, (mount,): stroke [m], command [V], spool [mA], flow into a chamber [m³/s]."""

    stroke: Array
    voltage: Array
    spool: Array
    flow: Array


def limits_of(result: Result) -> Limits:
    """The limits of actuators and law; the flow is the rated one."""
    actuators, law = result.scenario.plant.actuators, result.controller
    stroke, voltage, spool, gain = (
        np.array([getattr(actuator, name) for actuator in actuators])
        for name in ("maximum_stroke", "voltage_limit", "spool_stroke", "flow_gain")
    )
    if law is not None:
        voltage = np.minimum(voltage, law.converter.voltage_limit)
    return Limits(stroke, voltage, spool, gain * spool)


def nearest(shown: Shown) -> Section:
    """How near each run came to its limits."""
    return Section("nearest", tables=[_against_limits(shown)])


def limits(shown: Shown) -> Section:
    """For how long a run was at its limits, and what it drew."""
    tables = [_saturation(shown), _when_limited(shown), _oil(shown)]
    return Section("limits", "Limits, oil and power", tables=tables)


def _against_limits(shown: Shown) -> Table:
    """Peak of each limited quantity at the mount where it comes nearest to its limit."""
    found = {label: dict(_peaks(result)) for label, result in shown.results.items() if result.dataset.time.size}
    names = list(dict.fromkeys(name for peaks in found.values() for name in peaks))
    rows = [[name, *(peaks.get(name, DASH) for peaks in found.values())] for name in names]
    note = (
        "By the recorded rows, at the mount that comes nearest. Strokes count from unloaded membranes; chamber "
        "pressures may pass the supply's when a piston is pushed."
    )
    return Table("Peaks against limits", ["", *found], rows, note, kind="words")


def _peaks(result: Result) -> Iterator[tuple[str, str]]:
    """Quantity with its unit, and peak of limit with its share."""
    data, scenario, limits = result.dataset, result.scenario, limits_of(result)
    pressure = data.chamber_pressure.values
    yield "stroke [mm]", _nearest(data.stroke.values, limits.stroke, 1e3)
    yield "command [V]", _nearest(data.valve_command.values, limits.voltage)
    yield "spool [mA]", _nearest(data.spool.values, limits.spool)
    flows = np.abs(data.chamber_flow.values).max(axis=2)
    yield "flow into a chamber, of the rated [l/min]", _nearest(flows, limits.flow, LITRE_PER_MINUTE)
    supply = np.array(scenario.supply.pressure)
    yield "highest chamber pressure, of the supply [bar]", _nearest(pressure.max(axis=2), supply, BAR)
    vapour = max(actuator.vapour_pressure for actuator in scenario.plant.actuators)
    lowest = f"{number(BAR * float(np.nanmin(pressure)))} (vapour {number(BAR * vapour)})"
    yield "lowest chamber pressure [bar]", lowest


def _nearest(values: Array, limits: Array, factor: float = 1.0) -> str:
    """Peak of limit with its share, of the mount with the largest share; values (time, mount)."""
    peaks, limits = np.fmax.reduce(np.abs(values), axis=0), np.broadcast_to(limits, values.shape[1:])
    k = int(np.argmax(np.nan_to_num(peaks / limits)))
    share = 100.0 * float(peaks[k] / limits[k])
    return f"{number(factor * float(peaks[k]))} of {number(factor * float(limits[k]))} ({number(share, 2)} %)"


def _when_limited(shown: Shown) -> Table:
    """When each limit was first reached, and for how long; only limits that were."""
    rows = []
    for label, result in shown.results.items():
        reached = {name: part for name, part in result.summary.at_limit.items() if part}
        if reached and not shown.alone:
            rows.append([label])
        for name, part in reached.items():
            rows.append([name.replace("_", " "), number(part.first_s, 4), number(part.longest_s), part.mount])
    return Table("Limits that were reached", ["", "first at [s]", "longest [s]", "at"], rows, kind="words")


def _saturation(shown: Shown) -> Table:
    """Share of the time at each limit, per mount: a column each, or, of many, a row for each that reached any."""
    mounts = shown.scenario.plant.mounts
    if len(mounts) > COLUMNS:
        return _saturation_of_many(shown)
    rows = []
    for label, result in shown.results.items():
        rows += [] if shown.alone else [[label]]
        for name, shares in result.summary.saturation.items():
            rows.append([name.replace("_", " "), *(measured(scaled(shares.get(mount), 100.0)) for mount in mounts)])
    return Table("Share of the time at a limit [%]", ["", *mounts], rows)


def _saturation_of_many(shown: Shown) -> Table:
    """A row for each mount that reached a limit."""
    limits = list(dict.fromkeys(name for result in shown.results.values() for name in result.summary.saturation))
    rows = []
    for label, result in shown.results.items():
        rows += [] if shown.alone else [[label]]
        shares, mounts = result.summary.saturation, result.scenario.plant.mounts
        reached = [mount for mount in mounts if any(shares.get(name, {}).get(mount) for name in limits)]
        rows += [
            [mount, *(measured(scaled(shares.get(name, {}).get(mount), 100.0)) for name in limits)] for mount in reached
        ]
        if left := len(mounts) - len(reached):
            rows.append([f"the other {left}" if reached else f"all {left}", *["0"] * len(limits)])
    return Table("Share of the time at a limit [%]", ["", *(name.replace("_", " ") for name in limits)], rows)


def _oil(shown: Shown) -> Table:
    quantities = (
        ("mean flow [l/min]", "mean_flow_m3_s", LITRE_PER_MINUTE),
        ("peak flow [l/min]", "peak_flow_m3_s", LITRE_PER_MINUTE),
        ("volume [l]", "volume_m3", 1e3),
        ("mean power [W]", "mean_power_w", 1.0),
    )
    return of_each("Oil drawn from the supply", "oil", quantities, shown, "All mounts together.")


def of_each(title: str, key: str, quantities: Iterable[tuple[str, str, float]], shown: Shown, note: str = "") -> Table:
    """A table of the summary, one column per result; ``quantities``: words, entry and factor."""
    tables = [getattr(result.summary, key) for result in shown.results.values()]
    rows = [
        [text, *(number(scaled(getattr(table, name), factor)) for table in tables)] for text, name, factor in quantities
    ]
    return Table(title, ["", *shown.results], rows, note)
