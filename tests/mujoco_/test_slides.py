"""Slides in the nonlinear model: against statics, a model with a moving mass, and balances of impulse and moment."""

from typing import Any

import mujoco
import numpy as np
import pytest
import xarray as xr
from oracles.moving_mass import MovingMass
from scipy.integrate import cumulative_simpson

from ehamj.linear.machine import linear_model
from ehamj.mujoco.model import build_model
from ehamj.plant.axes import DOFS
from ehamj.plant.kinematics import points_motion
from ehamj.replay.scene import drawn_model, poses
from ehamj.run.simulate import observed, simulate
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

G, MASS, MOVING, HEIGHT, RAIL = 9.80665, 3000.0, 1000.0, 0.75, 0.9
PLANE = [DOFS.index(dof) for dof in ("x", "z", "ry")]
ISOLATOR = {
    "preset": "elastic-mount",
    "membrane_stiffness": 1e6,
    "membrane_damping": 2e4,
    "lateral_stiffness": 3e5,
    "lateral_damping": 5e3,
    "plate_mass": 10.0,
}


def scenario(step: float, begin: float = 0.1, isolator: dict[str, Any] = ISOLATOR, **given: Any) -> Scenario:
    """A slide of a tonne that goes 0.8 m along x in 1.5 s: all its corners are multiples of 0.1 s after ``begin``."""
    move = {"time": begin, "to": 0.4, "speed": 0.8, "acceleration": 2.0, "jerk": 20.0}
    slide = {
        "name": "table",
        "mass": MOVING,
        "inertia": [40.0, 40.0, 40.0],
        "position": [0.0, 0.0, RAIL],
        "rail": [2.0, 0.0, 0.0],
        "travel": [-0.4, 0.4],
        "start": -0.4,
        "profile": {"kind": "moves", "moves": [move]},
    }
    table = {"duration": 2.2, "timestep": step, "record_rate": 1.0 / step, "plates": "tied", "gravity": G}
    table |= {"actuators": {"isolator": isolator}, "machine": {"mass": MASS, "inertia": [2000.0, 3000.0, 4000.0]}}
    return parse_scenario({**table, "slide": [slide], **given})


def channels(step: float, *args: Any, **given: Any) -> xr.Dataset:
    return observed(scenario(step, *args, **given)).dataset


@pytest.mark.parametrize("plates", ["tied", "sliding"])
def test_machine_stays_tilted_by_the_weight_that_moved(plates: str) -> None:
    run = channels(1e-3, plates=plates, duration=10.0)
    softened = 4 * 1e6 * 0.9**2 - G * (MASS * HEIGHT + MOVING * RAIL)
    tilt = (run.machine_displacement[-1] - run.machine_displacement[0]).sel(dof="ry")
    # Second order in the tilt of 2.4 mrad; the issue asks for 1e-3.
    np.testing.assert_allclose(tilt, MOVING * G * 0.8 / softened, rtol=1e-4)
    strokes = (run.stroke[-1] - run.stroke[0]).values
    np.testing.assert_allclose(strokes, 0.9 * float(tilt) * np.array([-1.0, -1.0, 1.0, 1.0]), rtol=1e-3)
    np.testing.assert_allclose(run.slide[[0, -1], 0], [-0.4, 0.4], atol=1e-12)


def test_transient_is_that_of_a_moving_mass() -> None:
    isolator = {**ISOLATOR, "plate_mass": 0.0}
    run, own = channels(1e-3, isolator=isolator), scenario(1e-3).slide[0].course()

    def place(t: float) -> tuple[float, float, float]:
        x, v, a = own.sample(np.array([t]))
        return float(x[0]), float(v[0]), float(a[0])

    motion = run.machine_displacement.values[:, PLANE]
    oracle = MovingMass(place, (0.9, 0.9, -0.9, -0.9))
    expected = oracle.motion(run.time.values[::20], motion[0])
    for k in range(3):
        peak = np.abs(expected[:, k] - expected[0, k]).max()
        np.testing.assert_allclose(motion[::20, k], expected[:, k], atol=1e-6 * peak)


def imbalance(step: float) -> np.ndarray:
    """What momentum along x and z and moment of momentum about the mount plane's centre miss, over their peaks.

    From the run's motion alone: forces by the springs' law, Σ m v and Σ m r × v + J ω of both bodies.
    """
    isolator = {**ISOLATOR, "membrane_stiffness": 1e7, "lateral_stiffness": 3e6, "plate_mass": 0.0}
    run = channels(step, isolator=isolator)
    t, moved = run.time.values, run.machine_displacement.values[:, PLANE].T
    (x, z, angle), (vx, vz, w) = moved, run.machine_velocity.values[:, PLANE].T
    course = scenario(step).slide[0].course().sample(t)
    c, s, momentum, spin, toppling = np.cos(angle), np.sin(angle), np.zeros((2, t.size)), 3040.0 * w, np.zeros(t.size)
    for mass, along, up, rate in ((MASS, 0.0, HEIGHT, 0.0), (MOVING, course.value, RAIL, course.slope)):
        rx, rz = c * along + s * up, -s * along + c * up
        ux, uz = vx + w * rz + rate * c, vz - w * rx - rate * s
        momentum += mass * np.array([ux, uz])
        spin, toppling = spin + mass * (rz * ux - rx * uz), toppling + mass * G * rx
    feet = np.array([0.9, 0.9, -0.9, -0.9])
    ahead, lifted = feet * c[:, None], -feet * s[:, None]  # where turned feet are; their rates are w times these
    up = run.actuator_force.values - 1e7 * (z[:, None] + lifted) - 2e4 * (vz - w * (c * feet[:, None])).T
    level = -3e6 * (x[:, None] + ahead - feet) - 5e3 * (vx[:, None] + w[:, None] * lifted)
    # About a moving point: d(L)/dt = moment − v × P.
    moment = (lifted * level - ahead * up).sum(axis=1) + toppling - (vz * momentum[0] - vx * momentum[1])
    forces = (level.sum(axis=1), up.sum(axis=1) - (MASS + MOVING) * G, moment)
    gained = [cumulative_simpson(force, x=t, initial=0.0)[::2] for force in forces]
    held = [part[::2] for part in (*momentum, spin)]
    return np.array([np.abs(a - a[0] - b).max() / np.abs(a).max() for a, b in zip(held, gained, strict=True)])


def test_impulse_and_moment_of_momentum_balance() -> None:
    steps = np.array([2e-3, 1e-3, 5e-4]) / 2.0
    missed = np.array([imbalance(step) for step in steps])
    assert missed[-1].max() < 1e-8
    slopes = np.polyfit(np.log(steps), np.log(missed), 1)[0]
    assert slopes.max() >= 3.5


def test_corners_of_the_jerk_within_steps_keep_the_order() -> None:
    steps = np.array([1e-3, 5e-4])
    fine, *coarse = (channels(step, 0.1037, duration=1.0).machine_velocity.values for step in (1.25e-4, *steps))
    errors = []
    for step, one in zip(steps, coarse, strict=True):
        at = fine[:: round(step / 1.25e-4)]
        errors.append(np.abs(one - at).max(axis=0)[PLANE] / np.abs(at).max(axis=0)[PLANE])
    slope = np.log(errors[0] / errors[1]) / np.log(2.0)
    assert slope.min() >= 3.5


def test_locked_slides_are_parts_at_their_places() -> None:
    plant = scenario(1e-3).plant
    for place in (-0.4, 0.25):
        whole = plant.locked({"table": place}).machine
        np.testing.assert_allclose(whole.cg, (0.25 * place, 0.0, (MASS * HEIGHT + MOVING * RAIL) / 4000.0), atol=1e-15)
    np.testing.assert_array_equal(linear_model(plant).A, linear_model(plant.locked({"table": -0.4})).A)


def test_mass_matrix_of_the_moving_machine_is_that_of_the_locked_one() -> None:
    plant = scenario(1e-3).plant
    moving, locked = build_model(plant, 1e-3), build_model(plant.locked({"table": 0.3}), 1e-3)
    matrices = []
    for model in (moving, locked):
        data, matrix = mujoco.MjData(model), np.zeros((model.nv, model.nv))
        if model is moving:
            data.qpos[6] = 0.3 - -0.4
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, matrix)
        matrices.append(matrix[:6, :6])
    np.testing.assert_allclose(*matrices, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(moving.stat.meaninertia * moving.nv, locked.stat.meaninertia * 6 + MOVING, rtol=1e-2)


def test_drawn_slide_goes_along_its_rail_on_the_moving_machine() -> None:
    run = simulate(scenario(1e-3, duration=2.0))
    model = drawn_model(run)
    rows = np.array([0, 800, 2000])
    drawn = poses(run, model, 1.0, rows)
    still, machine = np.zeros((3, 6)), run.dataset.machine_displacement.values
    moved = machine[rows] - machine[0]
    for k, coordinate in enumerate(run.dataset.slide.values[rows, 0]):
        place = (coordinate, 0.0, RAIL)
        by = points_motion(moved, still, still, [place])[0][0][k]
        np.testing.assert_allclose(drawn["slide table"].translation[k], place + by, atol=1e-12)
    assert model.geom("slide table").bodyid == model.body("slide table").id
