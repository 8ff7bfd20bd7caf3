"""Tables of how near a run came to its limits: peaks, when a limit was reached, and what the loop's margins are."""

from collections.abc import Iterator, Mapping
from typing import Any, Final

import numpy as np

from ehamj.pages import Table
from ehamj.pages.words import BAR, DASH, LITRE_PER_MINUTE, number
from ehamj.report.shown import Array, Results
from ehamj.result import Result

LOOP_HEAD: Final = ("loop", "gain [dB]", "phase [°]", "disk [-]", "peak [-]", "peak at [Hz]", "crosses at [Hz]")


def against_limits(results: Results) -> Table:
    """Peak of each limited quantity at the mount where it comes nearest to its limit."""
    found = {label: dict(_peaks(result)) for label, result in results.items() if result.dataset.time.size}
    names = list(dict.fromkeys(name for peaks in found.values() for name in peaks))
    rows = [[name, *(peaks.get(name, DASH) for peaks in found.values())] for name in names]
    note = (
        "By the recorded rows, at the mount that comes nearest. Strokes count from unloaded membranes; chamber "
        "pressures may pass the supply's when a piston is pushed."
    )
    return Table("Peaks against limits", ["", *found], rows, note, kind="words")


def _peaks(result: Result) -> Iterator[tuple[str, str]]:
    """Quantity with its unit, and peak of limit with its share."""
    data, plant = result.dataset, result.scenario.plant
    actuators, supply = plant.actuators, plant.supply
    voltage = np.array([actuator.voltage_limit for actuator in actuators])
    if result.controller is not None:
        voltage = np.minimum(voltage, result.controller.voltage_limit)
    stroke = np.array([actuator.maximum_stroke for actuator in actuators])
    spool = np.array([actuator.spool_stroke for actuator in actuators])
    flow = np.array([actuator.flow_gain * actuator.spool_stroke for actuator in actuators])
    pressure = data.chamber_pressure.values
    yield "stroke [mm]", _nearest(data.stroke.values, stroke, 1e3)
    yield "command [V]", _nearest(data.valve_command.values, voltage)
    yield "spool [mA]", _nearest(data.spool.values, spool)
    flows = np.abs(data.chamber_flow.values).max(axis=2)
    yield "flow into a chamber, of the rated [l/min]", _nearest(flows, flow, LITRE_PER_MINUTE)
    yield (
        "highest chamber pressure, of the supply [bar]",
        _nearest(pressure.max(axis=2), np.array(supply.pressure), BAR),
    )
    vapour = max(actuator.vapour_pressure for actuator in actuators)
    lowest = f"{number(BAR * float(np.nanmin(pressure)))} (vapour {number(BAR * vapour)})"
    yield "lowest chamber pressure [bar]", lowest


def _nearest(values: Array, limits: Array, factor: float = 1.0) -> str:
    """Peak of limit with its share, of the mount with the largest share; values (time, mount)."""
    peaks, limits = np.fmax.reduce(np.abs(values), axis=0), np.broadcast_to(limits, values.shape[1:])
    k = int(np.argmax(np.nan_to_num(peaks / limits)))
    share = 100.0 * float(peaks[k] / limits[k])
    return f"{number(factor * float(peaks[k]))} of {number(factor * float(limits[k]))} ({number(share, 2)} %)"


def when_limited(results: Results) -> Table:
    """When each limit was first reached, and for how long; only limits that were."""
    rows = []
    for label, result in results.items():
        reached = {name: part for name, part in result.summary.get("at_limit", {}).items() if part}
        if reached and len(results) > 1:
            rows.append([label])
        for name, part in reached.items():
            words = [number(part["first_s"], 4), number(part["longest_s"], 3), part["mount"]]
            rows.append([name.replace("_", " "), *words])
    return Table("Limits that were reached", ["", "first at [s]", "longest [s]", "at"], rows, kind="words")


def margins(results: Results) -> Table:
    """What each law's loop has in hand before it becomes unstable, as the summary says it."""
    tables = {label: result.summary.get("margins") for label, result in results.items()}
    known = {label: table for label, table in tables.items() if table}
    rows: list[list[str]] = []
    for label, table in known.items():
        if len(known) > 1:
            rows.append([label])
        if not table["stable"]:
            rows.append(["the closed loop is unstable", *[DASH] * (len(LOOP_HEAD) - 1)])
        rows.append(["least, anywhere", *_loop(table)])
        rows += [[name, *_loop(one)] for name, one in table.get("motions", {}).items()]
    note = (
        "Each motion opened by itself, the rest closed; the least also over single valves, single readings and all "
        "valves at once. Peak: of the sensitivity. Practice asks for 6 dB, 45°, a disk margin of 0.5 and a peak below "
        f"2. {DASH}: unlimited, or no crossing."
    )
    return Table("Margins of the control loop", LOOP_HEAD, rows, note)


def _loop(one: Mapping[str, Any]) -> list[str]:
    """Cells of a loop's row."""
    crossings = ", ".join(number(hertz) for hertz in one.get("crossings_hz", ()))
    peak = [number(one.get(name)) for name in ("peak_sensitivity", "peak_hz")]
    return [number(one["gain_db"]), number(one["phase_deg"]), number(one["disk"]), *peak, crossings or DASH]
