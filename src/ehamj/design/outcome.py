"""What a design comes out with: answers, tables and figures of margins, loops and budget."""

from typing import Final

import numpy as np
import xarray as xr

from ehamj.control import LinearController
from ehamj.design.budget import Budget
from ehamj.design.requirements import Machines
from ehamj.design.tuning import Design
from ehamj.findings import finite
from ehamj.labels import table
from ehamj.linear.loop import Loop, feeds_back, opened
from ehamj.linear.margins import PATTERNS, grid, in_patterns
from ehamj.plots import Figure, Line, lines_chart
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Drawing, Outcome

SHOWN: Final = ("5", "10", "20", "50", "100")
"""Third-octave bands of the answers [Hz]."""


def outcome(scenario: Scenario, kind: str, machines: Machines, design: Design, limits: Budget) -> Outcome:
    """The design of a scenario's control as answers, tables and drawings.

    Args:
        scenario: under the designed control.
        kind: architecture.
        machines: the machine and its variations.
        design: the law with its margins.
        limits: its budget on the machine as designed.
    """
    has_loop = feeds_back(design.law)
    tables, drawings = {}, {}
    if has_loop:
        spectra = loop_table(scenario, machines, design.law)
        tables = {"margins": margin_table(design), "loops": spectra}
        drawings["loops"] = Drawing(
            "Loop gain and sensitivity of each motion with the others closed: thick as designed, thin on the "
            "variations. Where the sensitivity lies below 0 dB the feedback quietens.",
            lambda: _loops_chart(spectra),
        )
    tables["budget"] = budget_table(limits)
    drawings["budget"] = Drawing(
        "Vertical velocity of the machine's centre of gravity by what causes it, and the floor's.",
        lambda: _budget_chart(limits),
    )
    worst = [one.worst for one in design.reports.values()] or [(np.inf, np.inf, 2.0)]
    gain, phase, disk = (float(min(values)) for values in zip(*worst, strict=True))
    return Outcome(
        title=f"Controller for {scenario.name}",
        question=f"Which {kind} law leaves the margins, and what limits it?",
        answers=tuple(_answers(scenario, design, limits, has_loop)),
        tables=tables,
        drawings=drawings,
        notes=(
            "Margins are those of the sampled loop with computation delay, hold and sensors, broken at one place (a "
            "valve, a motion, a reading) with the rest closed; the disk margin also at all four valves at once.",
            "Attenuation is predicted for a floor that heaves, from the linear machine; turbulent flow and rounding "
            "are estimates. `ehamj run` on the written scenario measures it in the nonlinear machine.",
        ),
        numbers={
            "meets": design.meets,
            "gain_margin_db": finite(gain),
            "phase_margin_deg": finite(phase),
            "disk_margin": disk,
            "margins": {name: one.to_dict() for name, one in design.reports.items()},
            "budget": limits.to_dict(),
            "law": {"states": design.law.states, "inputs": len(design.law.inputs)},
        },
    )


def _answers(scenario: Scenario, design: Design, limits: Budget, has_loop: bool) -> list[str]:
    found = []
    if has_loop:
        wanted = design.requirements
        worst = {name: one.worst for name, one in design.reports.items()}
        least = [min(worst, key=lambda name: worst[name][k]) for k in range(3)]
        verdict = "Leaves" if design.meets else "Does NOT leave"
        found.append(
            f"{verdict} the margins asked for ({wanted.gain_margin:g} dB, {wanted.phase_margin:g}°, disk "
            f"{wanted.disk_margin:g}) on all {len(worst)} machines: least gain margin "
            f"{worst[least[0]][0]:.1f} dB ({least[0]}), phase {worst[least[1]][1]:.0f}° ({least[1]}), disk "
            f"{worst[least[2]][2]:.2f} ({least[2]})."
        )
        if not design.tuned:
            found.append(f"{scenario.control.kind} has no loops to tune: its gains are as they were given.")
        unstable = [name for name, one in design.reports.items() if not one.stable]
        if unstable:
            found.append(f"Unstable: {', '.join(unstable)}.")
    else:
        found.append("The law only measures the ground: there is no loop, and nothing that could become unstable.")
    quieter = 20 * np.log10(limits.floor / limits.total)
    named = {
        band.name: (value, cause) for band, value, cause in zip(limits.bands, quieter, limits.binding, strict=True)
    }
    words = ", ".join(f"{named[band][0]:.0f} dB at {band} Hz" for band in SHOWN)
    found.append(f"Predicted vertical attenuation: {words}.")
    causes = ", ".join(f"{named[band][1]} at {band} Hz" for band in SHOWN)
    found.append(f"What limits it: {causes}.")
    found.append(
        f"Commands: {limits.command_rms:.2f} V RMS of ±{limits.limit:g} V ({limits.command['noise']:.2f} V of it by "
        f"noise), beyond their range for {100 * limits.saturated:.2g} % of the time."
    )
    if limits.phases:
        lags = {
            "the valve": limits.phases["valve_deg"],
            "computation and hold": limits.phases["delay_and_hold_deg"],
            "the instrument": limits.phases["instrument_deg"],
            "oil and membrane": limits.phases["oil_and_membrane_deg"],
        }
        words = ", ".join(f"{cause} {value:.0f}°" for cause, value in lags.items())
        first = max(lags, key=lambda cause: lags[cause])
        found.append(
            f"Heave crosses at {limits.phases['crossing_hz']:.0f} Hz; what lags there: {words}. "
            f"The bandwidth is bound by {first} first."
        )
    return found


def margin_table(design: Design) -> xr.Dataset:
    """Margins of each pattern of motion on each machine, and of all valves at once."""
    names = list(design.reports)
    values = np.full((4, len(names), len(PATTERNS)), np.nan)
    together = np.array([one.disk for one in design.reports.values()])
    for row, one in enumerate(design.reports.values()):
        for column, pattern in enumerate(PATTERNS):
            m = one.motions[pattern]
            values[:, row, column] = m.gain, m.phase, m.disk, m.peak
    values[~np.isfinite(values)] = np.nan
    return table(
        "margins",
        {"machine": (names, "", "machine"), "pattern": (list(PATTERNS), "", "pattern of motion")},
        gain_margin=(values[0], "dB", "gain margin"),
        phase_margin=(values[1], "deg", "phase margin"),
        disk_margin=(values[2], "1", "disk margin"),
        peak_sensitivity=(values[3], "1", "peak sensitivity"),
        disk_margin_all_valves=(("machine",), together, "1", "disk margin, all valves at once"),
    )


def loop_table(scenario: Scenario, machines: Machines, law: LinearController) -> xr.Dataset:
    """Loop gain and sensitivity of heave, roll and pitch over frequency, the others closed, on each machine [dB]."""
    f = grid(law)
    f = f[(f >= 0.5) & (f <= 2000.0)]
    patterns = PATTERNS[:3]
    gain, sensitivity = np.zeros((2, len(machines), len(patterns), f.size))
    loop = Loop.of(scenario, law)
    for row, model in enumerate(machines.values()):
        moved = in_patterns(opened(model, loop, f).sensitivity, scenario.plant.positions)
        for column in range(len(patterns)):
            one = moved[:, column, column]
            gain[row, column] = 20 * np.log10(np.maximum(np.abs(1.0 / one - 1.0), 1e-12))
            sensitivity[row, column] = 20 * np.log10(np.abs(one))
    over = {
        "machine": (list(machines), "", "machine"),
        "pattern": (list(patterns), "", "pattern of motion"),
        "frequency": (f, "Hz", "frequency"),
    }
    return table("loop gains", over, gain=(gain, "dB", "loop gain"), sensitivity=(sensitivity, "dB", "sensitivity"))


def budget_table(limits: Budget) -> xr.Dataset:
    """Floor, machine and contributions per third-octave band."""
    causes = {
        name.replace(",", "").replace(" ", "_"): (values, "m/s", f"by {name}")
        for name, values in limits.contributions.items()
    }
    return table(
        "what limits the isolation",
        {"band": ([float(band.name) for band in limits.bands], "Hz", "third-octave band")},
        floor=(limits.floor, "m/s", "floor, RMS velocity"),
        machine=(limits.total, "m/s", "machine, RMS velocity"),
        attenuation=(20 * np.log10(limits.floor / limits.total), "dB", "attenuation"),
        binding=(list(limits.binding), "", "largest contribution"),
        **causes,
    )


def _loops_chart(table: xr.Dataset) -> Figure:
    panels = {}
    for quantity in ("gain", "sensitivity"):
        lines = []
        for row, machine in enumerate(table.machine.values):
            for column, pattern in enumerate(table.pattern.values):
                values = table[quantity].sel(machine=machine, pattern=pattern).values
                label = str(pattern) if row == 0 else ("on a variation" if column == 0 and row == 1 else "")
                width = 2.0 if row == 0 else 0.7
                lines.append(Line(label, table.frequency.values, values, column, min(row, 1), width=width))
        panels[f"{table[quantity].attrs['long_name']} [dB]"] = lines[::-1]
    limits = {"loop gain [dB]": (-40.0, 60.0), "sensitivity [dB]": (-60.0, 10.0)}
    return lines_chart("Loops", "frequency [Hz]", panels, "x", limits=limits)


def _budget_chart(limits: Budget) -> Figure:
    centres = [band.centre for band in limits.bands]
    micro = 1e6
    lines = [Line("floor", centres, micro * limits.floor, 7, width=2.4)]
    lines.append(Line("machine, all together", centres, micro * limits.total, 0, width=2.4))
    for k, (name, values) in enumerate(limits.contributions.items()):
        lines.append(Line(name, centres, micro * np.maximum(values, 1e-12), 1 + k % 6, 1 + k // 3 % 3, width=1.3))
    least = max(1e-6, 0.1 * micro * float(np.min(limits.total)))
    quantity = "RMS velocity [µm/s]"
    top = 3.0 * micro * float(max(limits.floor.max(), limits.total.max()))
    return lines_chart("Budget", "third-octave band [Hz]", {quantity: lines}, "xy", limits={quantity: (least, top)})
