"""What a design comes out with: answers, tables and figures of margins, loops and budget."""

from collections.abc import Sequence
from typing import Final

import numpy as np
import xarray as xr

from ehamj.control import LinearController
from ehamj.control.describing import AMPLITUDES, across
from ehamj.control.spools import followed
from ehamj.design.budget import Attenuations, Budget
from ehamj.design.figures import budget_drawings, loop_drawings, plotted, valve_drawings
from ehamj.findings import finite
from ehamj.judge.levels import SLAB
from ehamj.labels import table
from ehamj.linear.loop import Loop, feeds_back, opened
from ehamj.linear.margins import grid, in_patterns
from ehamj.linear.smooth import used_options
from ehamj.pages.words import AXIS_NAMES, decibel
from ehamj.plant.layout import MOTION_NAMES
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Outcome
from ehamj.synthesis.judged import Design
from ehamj.synthesis.requirements import NOMINAL, Machines

SHOWN: Final = ("5", "10", "20", "50", "100")
"""Third-octave bands of the answers [Hz]."""
CLIPPED: Final = 1e-3
"""Share of the time beyond the valves' range from which on a prediction does not hold."""
LIMITED: Final = {"z": "vertically", "x": "along x", "y": "along y"}
"""Axes of which it is told what limits them."""
LOUDER: Final = 0.5
"""By so much the machine must be louder than the floor before it is said [dB]."""


def outcome(
    scenario: Scenario, kind: str, machines: Machines, design: Design, limits: Budget, wrong: Attenuations
) -> Outcome:
    """The design of a scenario's control as answers, tables and drawings.

    Args:
        scenario: under the designed control.
        kind: architecture.
        machines: the machine and its variations.
        design: the law with its margins.
        limits: its budget on the machine as designed.
        wrong: what is left on machines of which the law believes all wrongly at once.
    """
    has_loop = feeds_back(design.law)
    tables, drawings = {}, {}
    if has_loop:
        spectra = loop_table(scenario, machines, design.law)
        tables = {"margins": margin_table(design), "loops": spectra}
        drawings = loop_drawings(spectra) | plotted(scenario, machines[NOMINAL], design)
    valves = valve_table(scenario, design.law)
    if valves is not None:
        tables, drawings = tables | {"valves": valves}, drawings | valve_drawings(valves)
    tables |= {"attenuation": attenuation_table(limits), "budget": budget_table(limits)}
    drawings |= budget_drawings(limits)
    worst = [one.worst for one in design.reports.values()] or [(np.inf, np.inf, 2.0)]
    gain, phase, disk = (float(min(values)) for values in zip(*worst, strict=True))
    return Outcome(
        title=f"Controller for {scenario.name}",
        question=f"Which {kind} law leaves the margins, and what limits it?",
        answers=(*_answers(scenario, design, limits, has_loop), *_left(wrong)),
        tables=tables,
        drawings=drawings,
        notes=(
            "Margins are those of the sampled loop with computation delay, hold and sensors, broken at one place (a "
            "valve, a motion, a reading) with the rest closed; the disk margin also at all valves at once.",
            "The prediction takes the scenario's own floor at each mount and axis through the closed loop, with what "
            "turbulent flow, compressed oil and turning add along that motion, and with noise and rounding as they are "
            "on average; a run scatters by some tenths of a decibel about it where noise binds.",
            *left_out(design),
            *limits.notes,
        ),
        numbers={
            "meets": design.meets,
            "gain_margin_db": finite(gain),
            "phase_margin_deg": finite(phase),
            "disk_margin": disk,
            "margins": {name: one.to_dict() for name, one in design.reports.items()},
            "budget": limits.to_dict(),
            "attenuation_if_wrong_db": {name: {m: dict(v) for m, v in one.items()} for name, one in wrong.items()},
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
        unstable = [f"{name} ({one.unstable})" for name, one in design.reports.items() if one.unstable]
        if unstable:
            found.append(f"Unstable: {'; '.join(unstable)}.")
    else:
        found.append("The law only measures the ground: there is no loop, and nothing that could become unstable.")
    found += _predicted(limits, scenario.plant.layout.motions)
    beyond = limits.saturated
    rarely = "hardly ever" if beyond < 1e-6 else f"for {100 * beyond:.2g} % of the time"
    found.append(
        f"Commands, at the valve that needs most: {limits.command_rms:.2f} V RMS of ±{limits.limit:g} V "
        f"({limits.command['noise']:.2f} V of it by noise), beyond their range {rarely}."
        + (" On so strong a floor that does not hold: clipped commands leave more." if beyond > CLIPPED else "")
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


def left_out(design: Design) -> tuple[str, ...]:
    """What the prediction leaves out of a law that linearises its valves."""
    said = (
        "The law linearises its valves, and the prediction has their pressure drop all the same: where nonlinear oil "
        "and valves bind, a run shows more isolation."
    )
    return (said,) if any(valve.numbers.most > 1.0 for valve in design.law.converter.valves) else ()


def _left(wrong: Attenuations) -> list[str]:
    """What is left vertically of the isolation where the law believes all wrongly at once."""
    found = []
    for name, one in wrong.items():
        known = [(band, value) for band in SHOWN if (value := one["z"][band]) is not None]
        if known:
            said = ", ".join(f"{decibel(value)} dB at {band} Hz" for band, value in known)
            found.append(f"With {name}, of which the law knows nothing, vertically: {said}.")
    return found


def _predicted(limits: Budget, driven: Sequence[str]) -> list[str]:
    """What the run will show, axis by axis, and what limits it along those that the mounts drive."""
    found = []
    for motion, name in AXIS_NAMES.items():
        known = {band: value for band, value in limits.attenuation[motion].items() if value is not None}
        if not known:
            continue
        said = [f"{decibel(known[band])} dB at {band} Hz" for band in SHOWN if band in known]
        text = f"Predicted attenuation, {name}: {', '.join(said) or 'none of ' + ', '.join(SHOWN) + ' Hz is decided'}"
        worst = min(known, key=lambda band: known[band])
        if known[worst] < -LOUDER:
            text += f"; louder than the floor by {decibel(-known[worst])} dB at {worst} Hz"
        missing = [band for band in SHOWN if band not in known]
        if said and missing:
            text += f"; undecided at {', '.join(missing)} Hz, where the floor is not known or does not move so"
        found.append(text + ".")
    if not found:
        return ["Attenuation: undecided in every band; the run is too short, or its floor is not known."]
    for axis, words in LIMITED.items():
        binding = dict(zip((band.name for band in limits.bands), limits.binding(axis), strict=True))
        causes: dict[str, list[str]] = {}
        for band in SHOWN:
            if cause := binding[band]:
                causes.setdefault(cause, []).append(band)
        if causes and MOTION_NAMES[axis] in driven:
            said = [f"{cause} at {', '.join(bands)} Hz" for cause, bands in causes.items()]
            found.append(f"What limits it {words}: {'; '.join(said)}.")
    return found


def margin_table(design: Design) -> xr.Dataset:
    """Margins of each pattern of motion on each machine, and of all valves at once."""
    names = list(design.reports)
    patterns = list(next(iter(design.reports.values())).motions)
    values = np.full((4, len(names), len(patterns)), np.nan)
    together = np.array([one.disk for one in design.reports.values()])
    for row, one in enumerate(design.reports.values()):
        for column, pattern in enumerate(patterns):
            m = one.motions[pattern]
            values[:, row, column] = m.gain, m.phase, m.disk, m.peak
    values[~np.isfinite(values)] = np.nan
    return table(
        "margins",
        {"machine": (names, "", "machine"), "pattern": (patterns, "", "pattern of motion")},
        gain_margin=(values[0], "dB", "gain margin"),
        phase_margin=(values[1], "deg", "phase margin"),
        disk_margin=(values[2], "1", "disk margin"),
        peak_sensitivity=(values[3], "1", "peak sensitivity"),
        disk_margin_all_valves=(("machine",), together, "1", "disk margin, all valves at once"),
    )


def loop_table(scenario: Scenario, machines: Machines, law: LinearController) -> xr.Dataset:
    """Loop gain and sensitivity of each motion over frequency, the others closed, on each machine [dB]."""
    f, patterns = grid(law), scenario.plant.central.motions
    f = f[(f >= 0.5) & (f <= 2000.0)]
    gain, sensitivity = np.zeros((2, len(machines), len(patterns), f.size))
    loop = Loop.of(scenario, law)
    for row, model in enumerate(machines.values()):
        moved = in_patterns(opened(model, loop, f).sensitivity, scenario.plant)
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


def valve_table(scenario: Scenario, law: LinearController) -> xr.Dataset | None:
    """Gain and phase of a valve and of what linearises it over the amplitude of the wanted opening, by what the law
    believes of the overlap; of the first mount whose valve is not ideal. None where there is no such valve."""
    own = followed(scenario.plant, law.converter.spools).actuators
    for actuator, valve in zip(own, law.converter.valves, strict=False):
        if not actuator.passive and used_options(actuator):
            found = across(valve, actuator)
            values = np.array(list(found.values()))
            with np.errstate(divide="ignore"):
                gain, phase = 20.0 * np.log10(np.abs(values)), np.degrees(np.angle(values))
            over = {
                "overlap": (list(found), "", "overlap that the law believes"),
                "amplitude": (AMPLITUDES, "mA", "amplitude of the wanted opening"),
            }
            nothing = ~np.isfinite(gain)
            gain[nothing], phase[nothing] = np.nan, np.nan
            columns = {"gain": (gain, "dB", "gain over the ideal valve's"), "phase": (phase, "deg", "phase")}
            return table("describing function", over, **columns)
    return None


def attenuation_table(limits: Budget) -> xr.Dataset:
    """Predicted attenuation of each motion per third-octave band, NaN where undecided."""
    values = [[np.nan if v is None else v for v in limits.attenuation[motion].values()] for motion in SLAB]
    return table(
        "predicted attenuation",
        {
            "band": ([float(band.name) for band in limits.bands], "Hz", "third-octave band"),
            "motion": (list(SLAB), "", "motion of the floor and of the machine"),
        },
        attenuation=(np.array(values).T, "dB", "attenuation"),
    )


def budget_table(limits: Budget) -> xr.Dataset:
    """Vertical velocity of floor and machine, and contributions, per third-octave band."""
    z = SLAB.index("z")
    causes = {
        name.replace(",", "").replace(" ", "_"): (values[:, z], "m/s", f"by {name}")
        for name, values in limits.contributions.items()
    }
    return table(
        "what limits the isolation",
        {"band": ([float(band.name) for band in limits.bands], "Hz", "third-octave band")},
        floor=(limits.floor[:, z], "m/s", "floor, RMS velocity"),
        machine=(limits.total[:, z], "m/s", "machine, RMS velocity"),
        binding=([cause or "" for cause in limits.binding()], "", "largest contribution"),
        **causes,
    )
