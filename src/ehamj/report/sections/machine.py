"""What was simulated, in a few lines and a drawing; and what the mounts do."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from ehamj import plots
from ehamj.ground.records import RecordGround
from ehamj.isolator.presets import NAMED
from ehamj.pages import Picture, Section, Table
from ehamj.pages.words import BAR, DASH, exact, measured, plain, scaled
from ehamj.plant.axes import DOFS
from ehamj.plant.plant import Plant
from ehamj.plots import Mark
from ehamj.report.shown import Shown, ground_parts
from ehamj.result import Result
from ehamj.run.reserves import support
from ehamj.scenario.model import Scenario
from ehamj.settings import Vector3

FEW: Final = 4
"""Mounts whose names are not in each other's way."""
PATTERNS: Final = 5
"""Patterns of self-stress up to which each has a column."""


def machine(shown: Shown) -> Section:
    """The first result's machine, floor, control and instruments, and what of them the user set otherwise."""
    drawing, _ = _drawings(shown.scenario)
    facts = [*_facts(shown.first), *_given(shown.scenario)]
    return Section("machine", "What was simulated", [drawing], facts=facts, kind="abreast")


def mounts(shown: Shown) -> Section:
    """Where the first result's mounts stand, and what they do."""
    _, drawing = _drawings(shown.scenario)
    return Section("mounts", "Mounts", [drawing], [_mounts(shown.first)], kind="abreast")


def _given(scenario: Scenario) -> Iterator[tuple[str, str]]:
    """Values that are not those of the preset, or of the machine as it is by default."""
    kinds = {f"actuator {name}": own for name, own in scenario.running.items()}
    for name, chosen in scenario.actuators.items():
        fields = type(chosen).model_fields
        named = {key: getattr(chosen, key) for key in NAMED if key in fields}
        other = [f"{key} {value}" for key, value in named.items() if value != fields[key].default]
        if other:
            yield f"chosen, actuator {name}", ", ".join(other)
    for name, own in {"machine": scenario.machine, **kinds, "supply": scenario.supply}.items():
        units = own.quantities()
        keys = [key for key, source in own.sources.items() if source == "given" and key in units]
        if keys:
            said = (f"{key} {plain(getattr(own, key))} {units[key][0].removeprefix('-')}".strip() for key in keys)
            yield f"set, {name}", ", ".join(said)


def _drawings(scenario: Scenario) -> tuple[Picture, Picture]:
    """From above and from the side."""
    plant = scenario.plant
    kinds = {mount.name: mount.actuator for mount in scenario.mount}
    feet = [
        plots.Foot(name, x, y, kinds[name], z, along)
        for name, (x, y, z), along in zip(plant.mounts, plant.positions, plant.directions, strict=True)
    ]
    waves = dict.fromkeys(
        (f"wave\n{part.wave.speed:.4g} m/s", float(part.wave.direction))
        for part in ground_parts(scenario)
        if getattr(part, "wave", None) is not None
    )
    size, cg = scenario.machine.size, plant.machine.cg
    points = [Mark(name, place) for name, place in scenario.points.items()]
    caption = "To scale; dimensions in metres."
    if not plant.flat:
        caption += " Arrows: along which isolators act that are not upright; grey: what they stand on."
    if len(feet) > FEW:
        caption += " Numbers, where there is no room for names: of the table of mounts."
    plan = Picture("machine-plan", plots.machine_plan(size, cg, feet, list(waves), points), caption)
    caption = "To scale but for the height of the mounts; dimensions in metres."
    return plan, Picture("machine-side", plots.machine_side(size, cg, feet, points), caption)


def _mounts(result: Result) -> Table:
    """What each mount does: along what it acts, what it carries, and its share in what moves nothing."""
    plant, data = result.scenario.plant, result.dataset
    kinds, layout = {mount.name: mount.actuator for mount in result.scenario.mount}, plant.layout
    carried = support(data, plant).tolist() if data.time.size else [None] * len(plant.mounts)
    names = layout.stress_names if len(layout.stress_names) <= PATTERNS else ()
    rows = []
    for k, name in enumerate(plant.mounts):
        stands = kinds[name] + (" (passive)" if plant.actuators[k].passive else "")
        along = along_in_words(plant.directions[k])
        shares = [signed(pattern[k] / np.abs(pattern).max()) for pattern in layout.stresses.T[: len(names)]]
        rows.append([str(k + 1), name, along, stands, measured(scaled(carried[k], 1e-3)), *shares])
    head = ["no.", "mount", "acts along", "actuator", "carries at rest [kN]", *names]
    note = "Carries: oil and membrane along its direction."
    if names:
        note += f" {', '.join(names)}: forces in these shares strain the machine and move nothing."
    return Table("What the mounts do", head, rows, note, kind="words")


def along_in_words(direction: Vector3) -> str:
    """A unit vector: an axis by its name, else its parts."""
    for axis, part in zip(("along x", "along y", "up"), direction, strict=True):
        if abs(part) > 1.0 - 1e-9:
            return axis if part > 0.0 else {"up": "down"}.get(axis, axis.replace(" ", " −"))
    return ", ".join(f"{part:.3g}".replace("-", "−") for part in direction)


def signed(share: float) -> str:
    """A share of a pattern with its sign; nothing where there is none."""
    return DASH if abs(share) < 5e-3 else f"{share:+.2f}".replace("-", "−")


def _actuated(plant: Plant) -> str:
    """The motions that the valves drive, and how many patterns of forces move nothing."""
    layout, most = plant.layout, len(DOFS)
    motions = ", ".join(layout.motions) or "none"
    patterns = len(layout.stress_names)
    said = f"{motions} (rank {layout.rank} of {most})"
    return f"{said}; {patterns} pattern{'' if patterns == 1 else 's'} of self-stress" if patterns else said


def _floor(part: Any) -> str:
    """The kind of a floor; of a record its file too, what it is scaled by, and from where it is known."""
    if not isinstance(part, RecordGround):
        return str(getattr(part, "kind", ""))
    scale = "" if part.scale == 1.0 else f" × {part.scale:g}" if isinstance(part.scale, float) else ", scaled"
    return f"record {Path(part.file).name}{scale}" + (f", high-passed at {part.highpass:g} Hz" if part.highpass else "")


def _facts(result: Result) -> Iterator[tuple[str, str]]:
    scenario, law = result.scenario, result.controller
    plant, supply = scenario.plant, scenario.supply
    count = {4: "four"}.get(len(plant.mounts), str(len(plant.mounts)))
    yield "machine", f"{exact(plant.total_mass)} kg with its plates, on {count} mounts ({scenario.plates} plates)"
    yield "actuated", _actuated(plant)
    yield "supply", f"{exact(BAR * supply.pressure)} bar, tank {exact(BAR * supply.tank_pressure)} bar (absolute)"
    yield "floor", " + ".join(map(_floor, ground_parts(scenario)))
    yield "control", scenario.control.kind
    if law is not None:
        rates = (f"{exact(1e-3 / part.period)} kHz, delay {exact(1e3 * part.latency)} ms" for part in law.parts)
        bits = "exact" if law.converter.bits is None else f"{law.converter.bits} bit"
        size = f"{law.states} states, {len(law.inputs)} inputs"
        yield "law", f"{size}, {' + '.join(rates)}, ±{exact(law.converter.voltage_limit)} V, {bits}"
    simulated = exact(result.summary.timing.simulated_s)
    yield "simulated", f"{simulated} of {exact(scenario.duration)} s, seed {scenario.seed}"
    if law is not None:
        sensors = {name: getattr(scenario.sensors, name) for name in type(scenario.sensors).model_fields}
        named = [
            f"{name} ({sensor.kind})" if name in ("ground", "inertial") else name
            for name, sensor in sensors.items()
            if sensor is not None
        ]
        yield "sensors", ", ".join(named) or "exact"
    if scenario.force:
        places = (force.point if isinstance(force.point, str) else str(list(force.point)) for force in scenario.force)
        pushed = (f"{force.kind} at {place}" for force, place in zip(scenario.force, places, strict=True))
        yield "forces on the machine", ", ".join(pushed)
    for slide in scenario.slide:
        course = result.dataset["slide"].sel(slide_name=slide.name).values
        went = f"{exact(round(float(course.min()), 6))} to {exact(round(float(course.max()), 6))} m"
        yield f"slide {slide.name}", f"{exact(slide.mass)} kg, {went if slide.moves else 'stands'}"
    analysis = result.summary.analysis
    yield "levels taken", f"from {exact(analysis.from_s)} to {exact(analysis.to_s)} s"
