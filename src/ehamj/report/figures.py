"""Figures of the machine, and of levels over third-octave bands."""

import math
from collections.abc import Iterator, Mapping

import numpy as np

from ehamj import plots
from ehamj.pages import Picture
from ehamj.pages.words import AXIS_NAMES
from ehamj.plant.mounts import MOUNTS
from ehamj.plots import Levels, Mark
from ehamj.report.shown import Results, ground_parts
from ehamj.scenario.model import Scenario


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
    points = [Mark(name, place) for name, place in scenario.points.items()]
    caption = "To scale; dimensions in metres."
    yield Picture("machine-plan", plots.machine_plan(size, cg, feet, list(waves), points), caption)
    caption = "To scale but for the height of the mounts; dimensions in metres."
    yield Picture("machine-side", plots.machine_side(size, cg, feet, points), caption)


def attenuation(results: Results, colors: Mapping[str, str]) -> Iterator[Picture]:
    for axis in AXIS_NAMES:
        curves = [
            curve
            for label, result in results.items()
            if (curve := _curve(label, result.summary.get("attenuation_db", {}).get(axis), 1.0, colors[label]))
        ]
        if curves:
            figure = plots.attenuation(f"Attenuation, {AXIS_NAMES[axis]}", curves)
            yield Picture(f"attenuation-{axis}", figure)


def _curve(label: str, table: Mapping[str, float | None] | None, factor: float, color: str) -> Levels | None:
    """A line over bands; None where no band is decided."""
    if not table or all(value is None for value in table.values()):
        return None
    values = [math.nan if value is None else factor * value for value in table.values()]
    return Levels(label, np.array([float(band) for band in table]), np.array(values), color)
