"""Mounts anywhere and in any direction: the engine's accelerations against Newton and Euler with rotation matrices."""

from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ehamj.arrays import Array
from ehamj.memory import activations
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import Inputs, rates
from ehamj.mujoco.model import build_model
from ehamj.plant.plant import Plant
from ehamj.scenario.load import parse_scenario

SOFT = {"membrane_stiffness": 1e6, "lateral_stiffness": 4e5, "membrane_damping": 3e3, "lateral_damping": 2e3}


def skew(mounts: int, plates: str = "tied", seed: int = 3, **values: Any) -> Plant:
    """A machine on mounts of random places, directions, stiffness and shims."""
    draw = np.random.default_rng(seed)
    table = [
        {
            "name": f"m{k}",
            "position": [*draw.uniform(-0.7, 0.7, 2), draw.uniform(-0.5, 0.5)],
            "direction": list(draw.normal(size=3)),
            "height": draw.uniform(0.0, 2e-3),
            "actuator": f"a{k}",
        }
        for k in range(mounts)
    ]
    actuators = {
        f"a{k}": {**{name: value * draw.uniform(0.5, 2.0) for name, value in SOFT.items()}, **values}
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


def motion(state: Array, model: mujoco.MjModel) -> tuple[Array, Array, Array, Array, Array]:
    """u and its rate, R, axes of the hinges rz, rx, ry as columns, angular velocity."""
    u, (rz, rx, ry) = state[:3], state[3:6]
    speed = state[model.nq : model.nq + 6]
    yaw = Rotation.from_rotvec([0, 0, rz])
    roll = yaw * Rotation.from_rotvec([rx, 0, 0])
    axes = np.column_stack([[0, 0, 1], yaw.apply([1, 0, 0]), roll.apply([0, 1, 0])])
    turned = (roll * Rotation.from_rotvec([0, ry, 0])).as_matrix()
    return u, speed[:3], turned, axes, axes @ speed[3:]


def newton_euler(plant: Plant, model: mujoco.MjModel, state: Array, inputs: Inputs) -> Array:
    """Acceleration of the mount plane's centre and angular acceleration, (6,), of a machine on plates without mass."""
    u, speed, turned, _, spin = motion(state, model)
    oil = activations(model, state[model.nq + model.nv :]).isolators
    machine = plant.machine
    centre = turned @ machine.body.cg
    force, moment = np.array([0, 0, -machine.body.mass * plant.gravity]), np.zeros(3)
    for k, own in enumerate(plant.actuators):
        r, d = turned @ plant.positions[k], np.array(plant.directions[k])
        left = u + r - plant.positions[k] - inputs.displacement[k]
        rate = speed + np.cross(spin, r) - inputs.velocity[k]
        area_2 = own.piston_area * own.area_ratio
        axial = own.piston_area * oil["pressure_1"][k] - area_2 * oil["pressure_2"][k]
        axial -= own.membrane_stiffness * (d @ left - plant.heights[k]) + own.membrane_damping * (d @ rate)
        lateral = own.lateral_stiffness * left + own.lateral_damping * rate
        f = axial * d - (lateral - d * (d @ lateral))
        force, moment = force + f, moment + np.cross(r - centre, f)
    inertia = turned @ machine.body.tensor @ turned.T
    bent = np.linalg.solve(inertia, moment - np.cross(spin, inertia @ spin))
    return np.concatenate(
        [force / machine.body.mass - np.cross(bent, centre) - np.cross(spin, np.cross(spin, centre)), bent]
    )


def engine(model: mujoco.MjModel, state: Array, inputs: Inputs) -> Array:
    """The same of the compiled model."""
    data = mujoco.MjData(model)
    with hydraulics():
        found = rates(model, data, state, inputs)[model.nq : model.nq + 6]
    _, _, _, axes, _ = motion(state, model)
    spins = state[model.nq + 3 : model.nq + 6]
    turning = spins[0] * np.cross(axes[:, 0], axes[:, 1]) * spins[1]
    turning += np.cross(axes[:, 0] * spins[0] + axes[:, 1] * spins[1], axes[:, 2]) * spins[2]
    return np.concatenate([found[:3], axes @ found[3:] + turning])


@pytest.mark.parametrize("mounts", [3, 8, 32])
@pytest.mark.parametrize("angle", [1e-9, 3e-3, 0.2])
def test_accelerations_are_those_of_newton_and_euler(mounts: int, angle: float) -> None:
    """However far it is turned; rounding of forces of 1e5 N is what is left."""
    plant = skew(mounts, plate_mass=0.0)
    model = build_model(plant, 1e-4)
    state, inputs = drawn_state(model, angle)
    exact = newton_euler(plant, model, state, inputs)
    np.testing.assert_allclose(engine(model, state, inputs), exact, atol=1e-11 * np.abs(exact).max())
