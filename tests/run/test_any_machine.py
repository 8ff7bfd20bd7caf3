"""Machines on any mounts, beside the oracle that turns them in space: what stands, swings and answers is the same.

Three mounts carry the machine in one way only, eight and thirty-two in many; directions are skew, active and passive
mounts stand side by side, and soft ones half a metre above and below the mount plane tilt by milliradians. The whole
campaign (0.2 s, sliding plates too, more layouts) gave the same errors.
"""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from oracles import general, linear
from scipy.interpolate import CubicHermiteSpline

from ehamj.linear.machine import linear_model
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario
from ehamj.views.statics import static_loads

UP = (0.0, 0.0, 1.0)
LEANING = {"cg": [0.05, -0.1, 0.9], "inertia": [[2100, 120, -80], [120, 2900, 60], [-80, 60, 3900]]}
KINDS = {
    "isolator": {},
    "strong": {"preset": "recommended"},
    "passive": {"preset": "elastic-mount", "membrane_stiffness": 4e6, "lateral_stiffness": 2e6},
    "soft": {"preset": "elastic-mount", "lateral_stiffness": 7e5},
}


def skew(seed: int, n: int) -> list[list[float]]:
    """Directions that mostly go up."""
    return (np.random.default_rng(seed).normal(size=(n, 3)) * 0.7 + UP).tolist()


def places(seed: int, n: int) -> list[list[float]]:
    draw = np.random.default_rng(seed).uniform(size=(n, 3))
    return ((draw - [0.5, 0.5, 0.4]) * [2.0, 1.5, 1.3]).tolist()


LAYOUTS: dict[str, tuple[Any, Any, list[str], dict[str, Any], float]] = {
    # CG over the middle: at rest level mounts in the mount plane have the levers that the engine keeps for them.
    "three": (((0.9, 0.1), (-0.8, 0.6), (-0.7, -0.5)), [UP] * 3, ["isolator"] * 3, {"cg": [-0.2, 0.2 / 3, 0.9]}, 1.0),
    "six": (
        ((0.9, 0.5, 0.0), (0.9, -0.5, 0.3), (-0.2, 0.7, -0.4), (-0.8, 0.4, 0.2), (-0.8, -0.5, 0.0), (0.0, -0.7, 0.1)),
        skew(7, 6), ["isolator"] * 6, LEANING, 1.0,
    ),
    "eight, mixed": (
        (
            (0.9, 0.6, 0.3), (0.9, -0.6, 0.0), (-0.9, 0.6, -0.4), (-0.9, -0.6, 0.1),
            (0.9, 0.1, 0.4), (-0.9, -0.1, 0.2), (0.2, 0.6, 0.3), (-0.1, -0.6, 0.5),
        ),
        (UP, UP, (0.2, 0.1, 1.0), UP, (-1.0, 0.0, 0.0), (1.0, 0.1, 0.0), (0.0, -1.0, 0.1), (0.3, 1.0, 0.0)),
        ["isolator", "passive", "strong", "isolator", "isolator", "passive", "isolator", "strong"], LEANING, 1.0,
    ),
    "thirty-two": (places(3, 32), skew(4, 32), ["isolator"] * 20 + ["passive"] * 12, LEANING, 1.0),
    "soft, high and low": (
        ((0.9, 0.6, 0.5), (0.9, -0.6, -0.5), (-0.9, 0.6, -0.5), (-0.9, -0.6, 0.5)), [UP] * 4, ["soft"] * 4,
        {"cg": [0.05, -0.1, 0.9]}, 300.0,
    ),
    "soft, in the plane": (
        ((0.9, 0.6), (0.9, -0.6), (-0.9, 0.6), (-0.9, -0.6)), [UP] * 4, ["soft"] * 4, {"cg": [0.05, -0.1, 0.9]}, 300.0
    ),
}  # fmt: skip
"""Places, directions, actuators, machine, and a factor on the floor's motion."""

FLOOR = (("x", 3e-6, 9.0), ("y", 2e-6, 14.0), ("z", 2e-6, 23.0), ("rx", 1e-6, 12.0), ("rz", 2e-6, 7.0))
"""Sines of a slab that turns: degree of freedom, amplitude [m, rad], frequency [Hz]."""

every = pytest.mark.parametrize("name", LAYOUTS)


def tones(mount: int) -> list[tuple[float, float]]:
    """Amplitudes [V] and frequencies [Hz] of three sines that begin with neither slope nor third derivative, since what
    begins abruptly rings with modes that the automatic step follows to a few per cent only."""
    hertz = np.array([9.0, 14.0, 19.0]) + 0.3 * mount % 9.0
    amplitudes = np.linalg.solve([np.ones(3), hertz / 10.0, (hertz / 10.0) ** 3], [0.2, 0.0, 0.0])
    return list(zip(amplitudes.tolist(), hertz.tolist(), strict=True))


@cache
def scenario(name: str) -> Scenario:
    spots, ways, kinds, machine, factor = LAYOUTS[name]
    parts = [
        {"kind": "sine", "dof": dof, "amplitude": factor * size, "frequency": hertz, "fade_in": 0.1}
        for dof, size, hertz in FLOOR
    ]
    signals = [
        {"kind": "sine", "mounts": [f"m{k}"], "amplitude": size, "frequency": hertz}
        for k in range(len(kinds))
        for size, hertz in tones(k)
    ]
    return parse_scenario({
        "mount": [
            {"name": f"m{k}", "position": spot, "direction": way, "actuator": kind}
            for k, (spot, way, kind) in enumerate(zip(spots, ways, kinds, strict=True))
        ],
        "actuators": KINDS, "machine": machine, "plates": "tied", "duration": 0.1,
        "ground": {"kind": "sum", "parts": parts}, "control": {"kind": "open-loop", "signals": signals},
    })  # fmt: skip


def oracle(name: str, result: Result) -> general.GeneralRun:
    """The same run; of the floor it takes what the scenario says at instants, and cubics between."""
    own = scenario(name)
    grid = np.arange(0.0, own.duration + 2e-4, 1e-4)
    motion = own.motion().sample(grid)
    floor = CubicHermiteSpline(grid, motion.displacement, motion.velocity)
    rate = floor.derivative()
    sines = np.array([tones(k) for k in range(len(own.mount))])

    def command(t: float) -> np.ndarray:
        return np.asarray((sines[:, :, 0] * np.sin(2 * np.pi * sines[:, :, 1] * t)).sum(axis=1))

    times = result.dataset["time"].values
    return general.simulate(general.of_plant(own.plant), times, command, lambda t: (floor(t), rate(t)), rtol=1e-7)


def deviation(found: np.ndarray, exact: np.ndarray) -> float:
    """Largest deviation about the start, of each channel's own peak."""
    found, exact = found - found[0], exact - exact[0]
    return float((np.abs(found - exact).max(axis=0) / np.abs(exact).max(axis=0)).max())


@pytest.mark.parametrize("name", [name for name in LAYOUTS if name != "six"])  # which `ehamj verify` runs
def test_the_response_at_the_automatic_step_is_the_oracle_s(name: str) -> None:
    large = name.startswith("soft")
    results = [
        simulate(scenario(name).model_copy(update={"engine": engine}))
        for engine in ("mujoco", *(() if large else ("small-motion",)))
    ]
    exact = oracle(name, results[0])
    for data in (result.dataset for result in results):
        pressure = data["chamber_pressure"].values
        assert deviation(data["machine_displacement"].values, exact.q) <= 1e-4
        assert deviation(data["stroke"].values, exact.stroke) <= 1e-4
        assert deviation(pressure[:, :, 0] - pressure[:, :, 1], exact.load_pressure) <= 1e-4
    if large:
        assert np.abs(exact.q[:, 3:]).max() > 1e-3  # constant levers would err by as much


@every
def test_modes_are_those_of_the_oracle(name: str) -> None:
    # Both by differences: 1e-7 of the engine's, on rows whose largest entries are 1e3 of what makes the slowest mode.
    own = scenario(name).plant
    found, exact = (
        linear.oscillators(np.linalg.eigvals(matrix).astype(complex))
        for matrix in (linear_model(own).A, general.jacobian(general.of_plant(own)))
    )
    np.testing.assert_allclose(found, exact, rtol=1e-6)


@every
def test_static_loads_are_those_of_the_oracle_and_carry_the_weight(name: str) -> None:
    own = scenario(name).plant
    machine, loads = general.of_plant(own), static_loads(scenario(name))
    rest = general.equilibrium(machine)
    stroke = machine.equations.strokes(rest, np.zeros((len(own.mounts), 3)))
    springs = np.array([actuator.membrane_stiffness for actuator in own.actuators])
    np.testing.assert_allclose(loads.along, -springs * stroke, rtol=0, atol=1e-6 * loads.weight)
    np.testing.assert_allclose(loads.displacement, rest[:6], rtol=0, atol=1e-6 * np.abs(rest[:6]).max())
    carried = loads.along[:, None] * np.array(own.directions) + loads.across + loads.guided
    np.testing.assert_allclose(carried.sum(axis=0), [0.0, 0.0, loads.weight], rtol=0, atol=1e-8 * loads.weight)


SLIDE = {
    "name": "table", "mass": 1000.0, "inertia": [[60, 10, -5], [10, 80, 8], [-5, 8, 70]], "position": [0.05, -0.1, 0.9],
    "rail": [0.7, 0.6, 0.1], "travel": [-0.45, 0.45], "start": -0.4,
    "profile": {
        "kind": "moves", "moves": [{"time": 0.05, "to": 0.4, "speed": 1.5, "acceleration": 6.0, "jerk": 150.0}]
    },
}  # fmt: skip
"""A tonne that travels 0.8 m along a skew rail."""


def test_a_slide_on_a_leaning_machine_moves_it_as_the_balance_of_both_bodies_says() -> None:
    table = scenario("soft, high and low").model_dump(include={"mount", "actuators", "plates"})
    tensor = [[2000, 100, -60], [100, 2500, 50], [-60, 50, 3500]]
    machine = {"mass": 3000.0, "cg": [0.05, -0.1, 0.8], "inertia": tensor}
    own = parse_scenario({**table, "machine": machine, "slide": [SLIDE], "duration": 1.0})
    slide, course = own.slide[0], own.slide[0].course()
    along = np.array(slide.along)

    def path(t: float) -> Any:
        place, speed, acceleration = (float(part[0]) * along for part in course.sample(np.array([t])))
        return slide.position + place, speed, acceleration

    moving = (general.MovingMass(slide.mass, slide.inertia, path),)
    alone = replace(own.plant, machine=own.plant.carrier)
    result = simulate(own)
    exact = general.simulate(general.of_plant(alone, moving), result.dataset["time"].values, rtol=1e-8, max_step=5e-3)
    assert np.ptp(exact.q[:, 4]) > 4e-3
    assert deviation(result.dataset["machine_displacement"].values, exact.q) <= 1e-4
