"""Motion of a point of the machine: against SciPy's rotations, the engine's, and closed small-angle forms."""

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ehamj.mujoco.model import build_model
from ehamj.plant.axes import DOF_OF_JOINT
from ehamj.plant.kinematics import points_motion
from ehamj.scenario.model import Scenario

NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)

angles = st.tuples(*(st.floats(-3.0, 3.0),) * 3)
points = st.tuples(*(st.floats(-2.0, 2.0),) * 3)


def displaced(displacement: np.ndarray, point: np.ndarray) -> np.ndarray:
    """Displacement (n, 3) of a point, from displacements (n, 6)."""
    still = np.zeros_like(displacement)
    return points_motion(displacement, still, still, [point])[0][0]


@given(points, angles, points)
def test_large_turns_are_yaw_then_roll_then_pitch_about_turned_axes(shift: tuple, turn: tuple, point: tuple) -> None:
    rx, ry, rz = turn
    found = displaced(np.array([[*shift, *turn]]), np.array(point))[0]
    turned = Rotation.from_euler("ZXY", [rz, rx, ry]).apply(point)
    # 1e-14: a dozen products of numbers near two, each rounded to 2e-16 of itself.
    np.testing.assert_allclose(found, np.array(shift) + turned - point, rtol=0, atol=1e-14)


@given(points, angles, points)
def test_a_point_moves_as_on_the_engines_machine(shift: tuple, turn: tuple, point: tuple) -> None:
    model = build_model(Scenario().plant, 1e-4)
    data = mujoco.MjData(model)
    motion = np.array([*shift, *turn])
    data.qpos[list(DOF_OF_JOINT)] = motion
    mujoco.mj_kinematics(model, data)
    body = model.body("machine").id
    engine = data.xpos[body] + data.xmat[body].reshape(3, 3) @ point
    # 1e-14: as above; the engine turns by quaternions.
    np.testing.assert_allclose(displaced(motion[None], np.array(point))[0], engine - point, rtol=0, atol=1e-14)


@given(st.lists(st.floats(-2.0, 2.0), min_size=18, max_size=18), points)
def test_velocity_and_acceleration_integrate_to_the_motion(coefficients: list[float], point: tuple) -> None:
    # Each degree of freedom follows a parabola of its own for 0.1 s. The point's path is then smooth on the scale of a
    # second, so twelve Gauss points are exact to rounding.
    a, b, c = np.array(coefficients).reshape(3, 6)
    duration = 0.1

    def motion(times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        t = times[:, None]
        (moved,) = points_motion(a + b * t + c * t * t, b + 2 * c * t, np.tile(2 * c, (times.size, 1)), [point])
        return moved

    place, speed, _ = motion(np.array([0.0, duration]))
    _, speed_between, change_between = motion(0.5 * duration * (1 + NODES))
    np.testing.assert_allclose(0.5 * duration * WEIGHTS @ speed_between, place[1] - place[0], rtol=0, atol=1e-13)
    np.testing.assert_allclose(0.5 * duration * WEIGHTS @ change_between, speed[1] - speed[0], rtol=0, atol=1e-12)


@pytest.mark.parametrize("size", [1e-12, 1e-9, 1e-7])
@given(st.tuples(*(st.floats(-1.0, 1.0),) * 3), points)
def test_tiny_turns_are_not_lost(size: float, direction: tuple, point: tuple) -> None:
    turn = size * np.array(direction)
    found = displaced(np.array([[0.0, 0.0, 0.0, *turn]]), np.array(point))[0]
    # 1 + θ× + half its square, in the order yaw, roll, pitch. The third order is missing: 1e-14 of it at 1e-7 rad.
    x, y, z = (np.cross(axis, np.eye(3)).T for axis in np.eye(3) * turn[:, None])
    second = 0.5 * (x @ x + y @ y + z @ z) + z @ x + z @ y + x @ y
    expected = (x + y + z + second) @ point
    tolerance = 1e-12 * np.abs(turn).max() * np.abs(point).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance)


@pytest.mark.parametrize(("dof", "axis", "lever"), [(3, 2, 0.6), (4, 2, -0.9), (5, 1, 0.9), (5, 0, -0.6)])
def test_a_nanoradian_about_one_axis_moves_a_mount_by_its_lever(dof: int, axis: int, lever: float) -> None:
    displacement = np.zeros((1, 6))
    displacement[0, dof] = 1e-9
    # rel 1e-8: turning in yaw by φ adds φ²/2 of the other lever, 1e-9 of the motion.
    assert displaced(displacement, np.array([0.9, 0.6, 0.0]))[0, axis] == pytest.approx(1e-9 * lever, rel=1e-8)


def test_the_height_of_a_foot_is_linear_to_third_order() -> None:
    x, y = 0.9, -0.6
    direction = np.array([0.7, -1.1, 0.4, 0.8, -0.9, 1.3])
    sizes = np.geomspace(1e-3, 1e-1, 5)
    heights = displaced(sizes[:, None] * direction, np.array([x, y, 0.0]))[:, 2]
    linear = sizes * (direction[2] + y * direction[3] - x * direction[4])
    order = np.polyfit(np.log(sizes), np.log(np.abs(heights - linear)), 1)[0]
    assert order == pytest.approx(3.0, abs=0.05)
