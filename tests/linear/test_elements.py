"""Closed forms of mounts in any direction against the energy they come from, by finite rotations and differences."""

from typing import Any

import numpy as np
import pytest
from harness import SKEW_MOUNTS
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from ehamj.linear.elements import Elements
from ehamj.linear.values import Values
from ehamj.plant.plant import Plant
from ehamj.scenario.load import parse_scenario

SKEW: dict[str, Any] = {
    "machine": {"mass": 900.0, "cg": [0.1, -0.05, 0.7], "inertia": [300.0, 400.0, 500.0]},
    "mount": SKEW_MOUNTS,
    "actuators": {"isolator": {"membrane_stiffness": 3e5, "lateral_stiffness": 2e5, "area_ratio": 0.999}},
}


def energy(plant: Plant, q: np.ndarray) -> float:
    """Of membranes, weights and the oil at its mean pressure [J], at x, y, z, rz, rx, ry."""
    turn = Rotation.from_euler("ZXY", q[3:])
    machine = plant.machine
    total = machine.mass * plant.gravity * float((q[:3] + turn.apply(machine.cg))[2])
    middle = 0.5 * (plant.supply.pressure + plant.supply.tank_pressure)
    for r, d, height, a in zip(plant.positions, plant.directions, plant.heights, plant.actuators, strict=True):
        moved = q[:3] + turn.apply(r) - r
        along = float(moved @ d)
        across = moved - along * np.array(d)
        total += 0.5 * a.membrane_stiffness * (along - height) ** 2 + 0.5 * a.lateral_stiffness * float(across @ across)
        total += (a.plate_mass * plant.gravity * d[2] - a.piston_area * (1.0 - a.area_ratio) * middle) * along
    return total


def gradient(plant: Plant, q: np.ndarray, step: float = 1e-3) -> np.ndarray:
    """First derivatives by differences of fourth order."""
    weights = {-2: 1.0, -1: -8.0, 1: 8.0, 2: -1.0}
    moves = step * np.eye(6)
    return np.array(
        [sum(w * energy(plant, q + n * move) for n, w in weights.items()) / (12.0 * step) for move in moves]
    )


def hessian(plant: Plant, q: np.ndarray, step: float = 1e-3) -> np.ndarray:
    """Second derivatives by differences of fourth order."""
    weights = {-2: 1.0, -1: -8.0, 1: 8.0, 2: -1.0}
    moves = step * np.eye(6)
    found = np.empty((6, 6))
    for i in range(6):
        for j in range(6):
            terms = (
                wi * wj * energy(plant, q + ni * moves[i] + nj * moves[j])
                for ni, wi in weights.items()
                for nj, wj in weights.items()
            )
            found[i, j] = sum(terms) / (12.0 * step) ** 2
    return found


def test_rest_and_stiffness_of_skew_mounts_are_those_of_the_energy() -> None:
    plant = parse_scenario(SKEW).plant
    at_rest = Elements.at_rest(Values.of(plant))
    lowest = root(lambda q: gradient(plant, q), np.zeros(6)).x
    strokes = [
        float((lowest[:3] + Rotation.from_euler("ZXY", lowest[3:]).apply(r) - r) @ d) - height
        for r, d, height in zip(plant.positions, plant.directions, plant.heights, strict=True)
    ]
    # Differences of some 100 J over 0.2 mm are good to 1e-9 N, on springs of 1e5 N/m.
    np.testing.assert_allclose(at_rest.stroke, strokes, rtol=0, atol=1e-8)
    assert np.abs(lowest[3:]).max() > 1e-3  # it does tilt
    expected = hessian(plant, lowest)
    np.testing.assert_allclose(at_rest.stiffness, expected, rtol=0, atol=1e-7 * np.abs(expected).max())


@pytest.mark.parametrize("height", [0.0, 1e-3])
def test_flat_mounts_have_linear_strokes(height: float) -> None:
    """Of a machine that leans: a shim below one mount adds its own stroke and load."""
    table = {"actuators": {"isolator": {"membrane_stiffness": 2e8}}, "machine": {"cg": [0.2, -0.1, 1.0]}}
    mounts = [mount.model_dump() for mount in parse_scenario({}).mount]
    mounts[0]["height"] = height
    plant = parse_scenario(table | {"mount": mounts}).plant
    assert plant.level_enough
    rest = Elements.at_rest(Values.of(plant))
    weight = (4000.0 + 4 * 14.0) * 9.80665
    assert float(-2e8 * rest.stroke.sum()) == pytest.approx(weight, rel=1e-12)
    level = Elements.at_rest(Values.of(parse_scenario(table).plant)).stroke
    # The machine follows the plane that fits the shim, the rest is warp: ± a quarter of the shim. Tilting adds 1 %.
    np.testing.assert_allclose(
        rest.stroke - level, -0.25 * height * np.array([1, -1, -1, 1]), rtol=0, atol=2e-2 * height
    )
