"""Mounts anywhere and in any direction: the engine's accelerations against Newton and Euler with rotation matrices."""

from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.optimize import root
from scipy.spatial.transform import Rotation

from ehamj.arrays import Array
from ehamj.isolator.actuator import Actuator
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import state_matrix
from ehamj.memory import activations
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import Inputs, rates
from ehamj.mujoco.model import build_model
from ehamj.plant.plant import Plant
from ehamj.scenario.load import parse_scenario

SOFT = {"membrane_stiffness": 1e6, "lateral_stiffness": 4e5, "membrane_damping": 3e3, "lateral_damping": 2e3}
LONG = {"chamber_volume": 5e-3}
"""Room for the strokes of soft mounts."""


def skew(mounts: int, plates: str = "tied", seed: int = 3, **values: Any) -> Plant:
    """A machine on mounts of random places, directions, stiffness and shims."""
    draw = np.random.default_rng(seed)
    table = [
        {
            "name": f"m{k}",
            "position": [*draw.uniform(-0.7, 0.7, 2), draw.uniform(-0.5, 0.5)],
            "direction": list(draw.normal(size=3)),
            "height": draw.uniform(0.0, 1e-4),
            "actuator": f"a{k}",
        }
        for k in range(mounts)
    ]
    stiff = {name: getattr(Actuator(), name) for name in SOFT}
    actuators = {
        f"a{k}": {**values, **{name: draw.uniform(0.5, 2.0) * values.get(name, stiff[name]) for name in SOFT}}
        for k in range(mounts)
    }
    machine = {"cg": [0.1, -0.05, 0.8]}
    return parse_scenario({"plates": plates, "machine": machine, "mount": table, "actuators": actuators}).plant


def drawn_state(model: mujoco.MjModel, angle: float, seed: int = 1) -> tuple[Array, Inputs]:
    """A state far from rest, and ground that moves."""
    draw, n = np.random.default_rng(seed), model.actuator_user.shape[0]
    state = np.zeros(model.nq + model.nv + model.na)
    state[:6] = draw.normal(size=6) * ([2e-3] * 3 + [angle] * 3)
    state[model.nq : model.nq + 6] = draw.normal(size=6) * ([0.05] * 3 + [10 * angle] * 3)
    oil = activations(model, state[model.nq + model.nv :]).isolators
    oil["pressure_1"], oil["pressure_2"] = draw.uniform(1e6, 5e6, (2, n))
    return state, Inputs(1e-3 * draw.normal(size=(n, 3)), 0.02 * draw.normal(size=(n, 3)), np.zeros(n))


def turn_of(angles: Array) -> tuple[Array, Array]:
    """R of the hinges rz, rx, ry, and their axes as columns."""
    rz, rx, ry = angles
    yaw = Rotation.from_rotvec([0, 0, rz])
    roll = yaw * Rotation.from_rotvec([rx, 0, 0])
    axes = np.column_stack([[0, 0, 1], yaw.apply([1, 0, 0]), roll.apply([0, 1, 0])])
    return (roll * Rotation.from_rotvec([0, ry, 0])).as_matrix(), axes


def wrench(plant: Plant, q: Array, v: Array, oil: Array, inputs: Inputs) -> Array:
    """Force and moment about the mount plane's centre of everything that acts, (6,); ``v`` has the angular velocity."""
    turned, _ = turn_of(q[3:])
    centre = turned @ plant.machine.body.cg
    weight = np.array([0, 0, -plant.machine.body.mass * plant.gravity])
    total = np.concatenate([weight, np.cross(centre, weight)])
    for k, own in enumerate(plant.actuators):
        r, d = turned @ plant.positions[k], np.array(plant.directions[k])
        left = q[:3] + r - plant.positions[k] - inputs.displacement[k]
        rate = v[:3] + np.cross(v[3:], r) - inputs.velocity[k]
        axial = oil[k] - own.membrane_stiffness * (d @ left - plant.heights[k]) - own.membrane_damping * (d @ rate)
        axial -= own.plate_mass * plant.gravity * d[2]
        lateral = own.lateral_stiffness * left + own.lateral_damping * rate
        f = axial * d - (lateral - d * (d @ lateral))
        total += np.concatenate([f, np.cross(r, f)])
    return total


def acceleration(plant: Plant, q: Array, v: Array, oil: Array, inputs: Inputs) -> Array:
    """Of the mount plane's centre [m/s²], and angular acceleration, (6,), by Newton and Euler.

    Plates move along their actions with their feet: d·(a + α × r + ω × (ω × r)).
    """
    turned, _ = turn_of(q[3:])
    body, spin = plant.machine.body, v[3:]
    skewed, inertia = np.cross(np.eye(3), turned @ body.cg).T, turned @ body.tensor @ turned.T
    reach = np.hstack([np.eye(3), skewed])  # a + α × c
    mass = body.mass * reach.T @ reach
    mass[3:, 3:] += inertia
    swing = np.cross(spin, np.cross(spin, turned @ body.cg))
    force = wrench(plant, q, v, oil, inputs) - body.mass * reach.T @ swing
    force[3:] -= np.cross(spin, inertia @ spin)
    for own, place, d in zip(plant.actuators, plant.positions, plant.directions, strict=True):
        r = turned @ place
        row = np.concatenate([d, np.cross(r, d)])
        mass += own.plate_mass * np.outer(row, row)
        force -= own.plate_mass * row * (d @ np.cross(spin, np.cross(spin, r)))
    return np.linalg.solve(mass, force)


def exact(plant: Plant, model: mujoco.MjModel, state: Array, inputs: Inputs) -> Array:
    """`acceleration` at a state of the compiled model."""
    speed = state[model.nq : model.nq + 6]
    _, axes = turn_of(state[3:6])
    oil = activations(model, state[model.nq + model.nv :]).isolators
    areas = [(own.piston_area, own.piston_area * own.area_ratio) for own in plant.actuators]
    force = [a * p - b * q for (a, b), p, q in zip(areas, oil["pressure_1"], oil["pressure_2"], strict=True)]
    return acceleration(plant, state[:6], np.concatenate([speed[:3], axes @ speed[3:]]), np.array(force), inputs)


def engine(model: mujoco.MjModel, state: Array, inputs: Inputs) -> Array:
    """The same of the compiled model."""
    data = mujoco.MjData(model)
    with hydraulics():
        found = rates(model, data, state, inputs)[model.nq : model.nq + 6]
    _, axes = turn_of(state[3:6])
    spins = state[model.nq + 3 : model.nq + 6]
    turning = spins[0] * np.cross(axes[:, 0], axes[:, 1]) * spins[1]
    turning += np.cross(axes[:, 0] * spins[0] + axes[:, 1] * spins[1], axes[:, 2]) * spins[2]
    return np.concatenate([found[:3], axes @ found[3:] + turning])


@pytest.mark.parametrize("mounts", [3, 8, 32])
@pytest.mark.parametrize("angle", [1e-9, 3e-3, 0.2])
def test_accelerations_are_those_of_newton_and_euler(mounts: int, angle: float) -> None:
    """However far it is turned; rounding of forces of 1e5 N is what is left."""
    plant = skew(mounts, plate_mass=0.0, **SOFT)
    model = build_model(plant, 1e-4)
    state, inputs = drawn_state(model, angle)
    expected = exact(plant, model, state, inputs)
    np.testing.assert_allclose(engine(model, state, inputs), expected, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("angle", [1e-9, 1e-4, 3e-3])
def test_plates_err_by_their_share_of_the_mass_times_the_angle(angle: float) -> None:
    """Their inertia stays on the linear coordinate: docs/physics.md."""
    plant = skew(8, plate_mass=14.0, **SOFT)
    model = build_model(plant, 1e-4)
    state, inputs = drawn_state(model, angle)
    state[model.nq : model.nq + 6] = 0.0
    expected = exact(plant, model, state, inputs)
    error = np.abs(engine(model, state, inputs) - expected).max() / np.abs(expected).max()
    assert error < angle * 8 * 14.0 / 4000.0 + 1e-11


@pytest.mark.parametrize("values", [{}, {**SOFT, **LONG}])
@pytest.mark.parametrize("mounts", [3, 6, 8, 32])
def test_eigenvalues_are_those_of_an_independent_assembly(mounts: int, values: dict[str, float]) -> None:
    """About the machine as it leans on its mounts, with the moment that their forces get when it turns.

    The plates' inertia is on the linear coordinate: 1e-6 where it stands upright, their share times the angle else.
    """
    plant = skew(mounts, plate_mass=14.0, **values)
    model = linear_model(plant)
    still, oil = Inputs(np.zeros((mounts, 3)), np.zeros((mounts, 3)), np.zeros(mounts)), np.zeros(mounts)
    rest = root(lambda q: 1e-4 * wrench(plant, q, np.zeros(6), oil, still), np.zeros(6), tol=1e-15).x
    np.testing.assert_allclose(model.equilibrium[:6], rest, atol=1e-9 * np.abs(rest).max())

    def rate(x: Array) -> Array:
        turning = np.linalg.solve(turn_of(x[3:6])[1], x[9:])
        return np.concatenate([x[6:9], turning, acceleration(plant, x[:6], x[6:], oil, still)])

    at, columns = np.concatenate([rest, np.zeros(6)]), []
    for step in 1e-6 * np.eye(12):
        columns.append((rate(at + step) - rate(at - step)) / 2e-6)
    expected = np.sort_complex(np.linalg.eigvals(np.array(columns).T))
    found = np.sort_complex(np.linalg.eigvals(state_matrix(model, bypassed=True).A))
    bound = max(1e-6, np.abs(rest[3:]).max() * mounts * 14.0 / 4000.0)
    np.testing.assert_allclose(found, expected, rtol=bound)
