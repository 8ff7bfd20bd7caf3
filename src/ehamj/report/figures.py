"""Figures of the machine, and of levels over third-octave bands."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ehamj import plots
from ehamj.criteria.third_octave import bands
from ehamj.criteria.vc import CLASSES, limit
from ehamj.layout import MOUNTS
from ehamj.plots import Levels
from ehamj.report.parts import Picture, Results, ground_parts
from ehamj.report.words import AXIS_NAMES, CRITERION_AXES, MICRO
from ehamj.scenario import Scenario


def machine(scenario: Scenario) -> Iterator[Picture]:
    actuators: dict[str, str] = {mount.name: mount.actuator for mount in scenario.mount}
    feet = [
        plots.Foot(name, *position, kind=actuators[name])
        for name, position in zip(MOUNTS, scenario.plant.positions, strict=True)
    ]
    waves = dict.fromkeys(
        (f"wave\n{part.wave.speed:.4g} m/s", float(part.wave.direction))
        for part in ground_parts(scenario)
        if getattr(part, "wave", None) is not None
    )
    size, cg = scenario.machine.size, scenario.machine.cg
    caption = "To scale; dimensions in metres."
    yield Picture("machine-plan", "machine", plots.machine_plan(size, cg, feet, list(waves)), caption)
    caption = "To scale but for the height of the mounts; dimensions in metres."
    yield Picture("machine-side", "machine", plots.machine_side(size, cg, feet), caption)


def attenuation(results: Results, colors: Mapping[str, str]) -> Iterator[Picture]:
    for axis in AXIS_NAMES:
        curves = [
            curve
            for label, result in results.items()
            if (curve := _curve(label, result.summary.get("attenuation_db", {}).get(axis), 1.0, colors[label]))
        ]
        if curves:
            figure = plots.attenuation(f"Attenuation, {AXIS_NAMES[axis]}", curves)
            yield Picture(f"attenuation-{axis}", "attenuation", figure)


def _curve(label: str, table: Mapping[str, float | None] | None, factor: float, color: str) -> Levels | None:
    """A line over bands; None where no band is decided."""
    if not table or all(value is None for value in table.values()):
        return None
    values = [math.nan if value is None else factor * value for value in table.values()]
    return Levels(label, np.array([float(band) for band in table]), np.array(values), color)


def criterion(results: Results, colors: Mapping[str, str]) -> Iterator[Picture]:
    classes = {}
    for name in CLASSES:
        limits = [(float(band.name), level) for band in bands(1.0, 100.0) if (level := limit(name, band)) is not None]
        frequency, level = np.array(limits).T
        classes[name] = (frequency, MICRO * level)
    known = {result.summary.get("analysis", {}).get("usable_to_hz") for result in results.values()}
    known_to = min((value for value in known if value is not None), default=None)
    for axis in CRITERION_AXES:
        curves = [
            curve
            for label, who, table, color in _velocities(results, axis, colors)
            if (curve := _curve(who or label, table, MICRO, color)) and np.nanmax(curve.values) > plots.QUIETEST
        ]
        if curves:
            figure = plots.criterion(f"Velocity and vibration classes, {AXIS_NAMES[axis]}", curves, classes, known_to)
            yield Picture(f"criterion-{axis}", "criterion", figure)


def _velocities(results: Results, axis: str, colors: Mapping[str, str]) -> Iterator[tuple[str, str, Any, str]]:
    """Label, name of the floor (or nothing), levels per band and colour; floors that are alike once."""
    tables = {label: result.summary.get("third_octave_velocity", {}) for label, result in results.items()}
    floors: list[Any] = []
    for label, table in tables.items():
        floor = table.get("floor", {}).get(axis)
        if floor is not None and floor not in floors:
            floors.append(floor)
            yield label, "floor" if len(floors) == 1 else f"floor of {label}", floor, plots.FLOOR_COLOR
    for label, table in tables.items():
        yield label, "", table.get("machine", {}).get(axis), colors[label]
