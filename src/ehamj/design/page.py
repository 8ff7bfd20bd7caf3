"""The page of a design: the machine that it is for, what the law leaves and why, in numbers that a person reads."""

from collections.abc import Collection, Iterator
from typing import Final

import numpy as np
from markupsafe import Markup

from ehamj.control.sensors import Sensors
from ehamj.design.budget import Attenuations, Budget
from ehamj.design.figures import telling
from ehamj.design.outcome import SHOWN
from ehamj.isolator.actuator import Actuator
from ehamj.judge.levels import SLAB
from ehamj.pages import ANNEX, Page, Picture, Section, Table
from ehamj.pages.words import AXIS_NAMES, BAR, DASH, LITRE_PER_MINUTE, MICRO, decibel, exact, number, plain
from ehamj.scenario.model import Scenario
from ehamj.studies.outcome import Outcome
from ehamj.studies.page import headline_of, said_besides
from ehamj.synthesis.judged import Design

NANO: Final = 1e9
NOISES: Final = {
    "velocity": (NANO, "nm/s"), "displacement": (NANO, "nm"), "acceleration": (MICRO, "µm/s²"), "position": (1e3, "µA"),
}  # fmt: skip
"""Factor and unit in which the noise of an instrument is said, by what it measures; others in Pa."""
HEADS: Final = {"z": "vertical z", "x": "along x", "y": "along y", "rx": "roll rx", "ry": "pitch ry", "rz": "yaw rz"}


def design_page(
    outcome: Outcome, scenario: Scenario, design: Design, limits: Budget, wrong: Attenuations, files: str
) -> Page:
    """The page.

    Args:
        outcome: of the design.
        scenario: under the designed control.
        design: the law with its margins.
        limits: its budget.
        wrong: what is left on machines of which the law believes all wrongly at once.
        files: what stands beside the page, in words.
    """
    pictures = [Picture(name, one.draw(), one.caption) for name, one in outcome.drawings.items()]
    sections = [
        *said_besides(outcome),
        Section("figures", figures=pictures),
        Section("tables", tables=[margins(design), left(limits, wrong)]),
        Section("notes", "What holds, and what does not", items=outcome.notes),
        ANNEX,
        Section("machine", "The machine that it is for", facts=list(facts(scenario, design))),
        Section("numbers", "Numbers", tables=[attenuations(limits), contributions(limits)]),
        Section("files", "Files", notes=[files]),
    ]
    lead = f"{outcome.question} Machine: {scenario.name}, {exact(scenario.plant.machine.mass)} kg."
    return Page(f"{outcome.title}: {scenario.name}", outcome.title, lead, sections, headline_of(outcome))


def facts(scenario: Scenario, design: Design) -> Iterator[tuple[str, str]]:
    """What the law was designed for, and what it is."""
    machine, law = scenario.machine, design.law
    yield "machine", f"{scenario.name}: {exact(machine.mass)} kg, inertia {plain(machine.inertia)} kg m²"
    yield "centre of gravity", f"{plain(machine.cg)} m (x, y, z from the mount plane's centre)"
    for name, actuator in scenario.running.items():
        at = [mount.name for mount in scenario.mount if mount.actuator == name]
        if at:
            yield f"actuator {name}", f"{_actuator(actuator)}; at {', '.join(at)}"
    yield (
        "supply",
        f"{exact(BAR * scenario.supply.pressure)} bar, tank {exact(BAR * scenario.supply.tank_pressure)} bar",
    )
    ground = scenario.ground.model_dump(exclude_defaults=True, exclude_none=True)
    said = ", ".join(f"{key} {plain(value)}" for key, value in ground.items() if key != "kind")
    yield (
        "floor",
        f"{scenario.ground.kind}{': ' if said else ''}{said}; {exact(scenario.duration)} s, seed {scenario.seed}",
    )
    yield "sensors", _sensors(scenario.sensors)
    rates = " + ".join(f"{exact(1e-3 / one.period)} kHz, delay {exact(1e3 * one.latency)} ms" for one in law.parts)
    yield "law", f"{design.settings.kind}: {law.states} states, {len(law.inputs)} inputs, {rates}"


def _actuator(actuator: Actuator) -> str:
    a = actuator
    return (
        f"piston {number(1e4 * a.piston_area)} cm², {number(LITRE_PER_MINUTE * a.flow_gain * a.spool_stroke)} l/min at "
        f"full stroke, valve {number(a.valve_frequency / (2 * np.pi))} Hz, membrane "
        f"{number(1e-6 * a.membrane_stiffness)} N/µm, oil {number(1e-9 * a.bulk_modulus)} GPa"
    )


def _sensors(sensors: Sensors) -> str:
    found = []
    for name in type(sensors).model_fields:
        one = getattr(sensors, name)
        if name == "upstream":
            found += [] if one is None else [f"{name} {one.said}"]
            continue
        if one is None:
            found.append(f"{name} exact")
            continue
        factor, unit = NOISES.get(one.measures, (1.0, "Pa"))
        kind = f"{one.kind} of " if name in ("ground", "inertial") else ""
        found.append(f"{name} {kind}{number(factor * one.noise)} {unit}/√Hz")
    return ", ".join(found)


def margins(design: Design) -> Table:
    """Margins of each motion on each machine, and of all valves at once."""
    rows: list[list[str]] = []
    for name, one in design.reports.items():
        stable = "" if one.stable else ", UNSTABLE"
        rows.append([f"{name}: disk margin of all valves at once {number(one.disk)}{stable}"])
        for pattern, m in one.motions.items():
            rows.append([pattern, f"{decibel(m.gain) if np.isfinite(m.gain) else number(m.gain)}",
                         number(m.phase), number(m.disk), number(m.peak)])  # fmt: skip
    head = ["motion", "gain [dB]", "phase [°]", "disk", "peak S"]
    return Table("Margins, the other motions closed", head, rows, folded=worst_margins(design) if rows else "")


def worst_margins(design: Design) -> str:
    """The least of each margin, and the machine that has it: the line for which the table stands."""
    words = (("gain", decibel, " dB"), ("phase", number, "°"), ("disk", number, ""))
    said = (
        f"{name} {written(value) if np.isfinite(value) else number(value)}{unit} ({machine})"
        for (name, written, unit), (value, machine) in zip(words, design.least, strict=True)
    )
    return f"least on {len(design.reports)} machines: {', '.join(said)}"


def attenuations(limits: Budget, only: Collection[str] | None = None) -> Table:
    """Predicted attenuation per band, or ``only`` in some, and motion; what is undecided everywhere is left out."""
    shown = [m for m in AXIS_NAMES if any(value is not None for value in limits.attenuation[m].values())]
    rows = [
        [band.name, *(decibel(limits.attenuation[motion][band.name]) for motion in shown)]
        for band in limits.bands
        if (only is None or band.name in only)
        and any(limits.attenuation[motion][band.name] is not None for motion in shown)
    ]
    note = (
        f"{DASH}: undecided, since the floor is not known there, or does not move so. Positive: quieter than the floor."
    )
    return Table("Predicted attenuation [dB]", ["band [Hz]", *(HEADS[motion] for motion in shown)], rows, note)


def left(limits: Budget, wrong: Attenuations) -> Table:
    """Vertical attenuation on each machine of which the law believes all wrongly at once, beside that as designed."""
    machines = {"as designed": limits.attenuation, **wrong}
    if not wrong or all(limits.attenuation["z"][band] is None for band in SHOWN):
        return Table("", [], [])
    rows = [[name, *(decibel(one["z"][band]) for band in SHOWN)] for name, one in machines.items()]
    return Table(
        "Vertical attenuation where the law is wrong [dB]", ["machine", *(f"{band} Hz" for band in SHOWN)], rows
    )


def contributions(limits: Budget) -> Table:
    """Vertical velocities at some bands by cause, the largest of each band marked."""
    z, names = SLAB.index("z"), [band.name for band in limits.bands]
    shown = [names.index(band) for band in SHOWN if limits.attenuation["z"][band] is not None]
    if not shown:
        return Table("", [], [])
    causes, binding = telling(limits), limits.binding()
    rows = [["floor", *(_nano(limits.floor[k, z]) for k in shown)]]
    rows.append(["machine, all together", *(_nano(limits.total[k, z]) for k in shown)])
    for name, values in causes.items():
        cells = [(_nano(values[k, z]), binding[k] == name) for k in shown]
        rows.append([f"by {name}", *(Markup("<b>{}</b>").format(text) if most else text for text, most in cells)])
    head = ["vertical", *(f"{names[k]} Hz" for k in shown)]
    return Table("What limits it: RMS velocity per band [nm/s]", head, rows, "Bold: the largest cause of each band.")


def _nano(value: float) -> str:
    """A velocity in nm/s, of which nobody reads less than a tenth."""
    return "< 0.1" if 0.0 <= NANO * value < 0.1 else number(NANO * value)
