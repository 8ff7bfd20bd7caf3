"""What was simulated, in a few lines and two drawings."""

from collections.abc import Iterator

from ehamj import plots
from ehamj.pages import Picture, Section
from ehamj.pages.words import BAR, exact
from ehamj.plots import Mark
from ehamj.report.shown import Shown, ground_parts
from ehamj.result import Result
from ehamj.scenario.model import Scenario


def machine(shown: Shown) -> Section:
    """The first result's machine, floor, control and instruments."""
    return Section("machine", "What was simulated", list(_drawings(shown.scenario)), facts=list(_facts(shown.first)))


def _drawings(scenario: Scenario) -> Iterator[Picture]:
    plant = scenario.plant
    feet = [
        plots.Foot(name, *position[:2], kind=mount.actuator)
        for name, position, mount in zip(plant.mounts, plant.positions, scenario.mount, strict=True)
    ]
    waves = dict.fromkeys(
        (f"wave\n{part.wave.speed:.4g} m/s", float(part.wave.direction))
        for part in ground_parts(scenario)
        if getattr(part, "wave", None) is not None
    )
    size, cg = scenario.machine.size, scenario.machine.cg
    points = [Mark(name, place) for name, place in scenario.points.items()]
    caption = "To scale; dimensions in metres."
    yield Picture("machine-plan", plots.machine_plan(size, cg, feet, list(waves), points), caption)
    caption = "To scale but for the height of the mounts; dimensions in metres."
    yield Picture("machine-side", plots.machine_side(size, cg, feet, points), caption)


def _facts(result: Result) -> Iterator[tuple[str, str]]:
    scenario, law = result.scenario, result.controller
    plant, supply = scenario.plant, scenario.supply
    count = {4: "four"}.get(len(plant.mounts), str(len(plant.mounts)))
    yield "machine", f"{exact(plant.total_mass)} kg with its plates, on {count} mounts ({scenario.plates} plates)"
    yield "supply", f"{exact(BAR * supply.pressure)} bar, tank {exact(BAR * supply.tank_pressure)} bar (absolute)"
    yield "floor", " + ".join(getattr(part, "kind", "") for part in ground_parts(scenario))
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
