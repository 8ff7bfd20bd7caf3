"""Inertia as three moments or a tensor, and parts that add up: against closed forms and the compiled model."""

from typing import Any

import mujoco
import numpy as np
import pytest

from ehamj.designs.designs import Designs
from ehamj.designs.many import modes_of
from ehamj.errors import InputError
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.mujoco.model import build_model
from ehamj.plant.axes import DOF_OF_JOINT
from ehamj.plant.bodies import box_inertia
from ehamj.scenario.load import parse_scenario

TENSOR = [[2000.0, 300.0, -200.0], [300.0, 3000.0, 150.0], [-200.0, 150.0, 4000.0]]
PART = {"name": "workpiece", "mass": 600.0, "position": [0.3, -0.2, 1.1], "inertia": [30.0, 20.0, 25.0]}


def spatial(mass: float, cg: Any, tensor: Any) -> np.ndarray:
    """Mass matrix (6, 6) at the origin, from kinetic energy ½m|u + θ × c|² + ½θᵀJθ."""
    x, y, z = cg
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.block([[mass * np.eye(3), -mass * skew], [mass * skew, np.array(tensor) - mass * skew @ skew]])


def test_two_halves_make_a_whole_box() -> None:
    half = {
        "name": "half",
        "mass": 2000.0,
        "position": [0.55, 0.0, 0.95],
        "inertia": box_inertia(2000.0, (1.1, 1.6, 1.9)),
    }
    rest = {"mass": 2000.0, "cg": [-0.55, 0.0, 0.95], "inertia": list(half["inertia"])}
    whole = parse_scenario({"machine": rest, "part": [half]}).plant.machine
    assert whole.mass == 4000.0
    np.testing.assert_allclose(whole.cg, (0.0, 0.0, 0.95), atol=1e-15)
    np.testing.assert_allclose(whole.inertia, box_inertia(4000.0, (2.2, 1.6, 1.9)), rtol=1e-14)


def test_compiled_model_has_the_products_of_inertia_of_machine_and_parts() -> None:
    plant = parse_scenario({"machine": {"inertia": TENSOR}, "part": [PART], "plates": "tied"}).plant
    model = build_model(plant, 1e-4)
    data, matrix = mujoco.MjData(model), np.zeros((model.nv, model.nv))
    mujoco.mj_forward(model, data)
    mujoco.mj_fullM(model, data, matrix)
    up = np.array([[0.0, 0.0, 1.0, y, -x, 0.0] for x, y, _ in plant.positions])
    expected = spatial(4000.0, (0.0, 0.0, 0.75), TENSOR) + plant.actuators[0].plate_mass * up.T @ up
    expected += spatial(600.0, PART["position"], np.diag(PART["inertia"]))
    at = list(DOF_OF_JOINT)
    np.testing.assert_allclose(matrix[np.ix_(at, at)], expected, rtol=1e-12, atol=1e-9)


def test_closed_forms_have_the_modes_of_a_machine_with_products_and_parts() -> None:
    scenario = parse_scenario({"machine": {"inertia": TENSOR, "cg": [0.1, -0.05, 0.8]}, "part": [PART]})
    heavier = scenario.varied({"machine.inertia.0.0": 2400.0})
    many = modes_of(Designs.of(scenario, {"machine.inertia.0": np.array([2000.0, 2400.0])}))
    for k, one in enumerate((scenario, heavier)):
        expected = sorted(mode.frequency for mode in modes(linear_model(one.plant)) if mode.machine_moves)
        # Differences of the compiled model hold to 1e-7 of its stiffness.
        np.testing.assert_allclose(np.sort(many["frequency"][k]), expected, rtol=1e-6)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"machine": {"inertia": [[1.0, 2.0, 0.0], [3.0, 4.0, 0.0], [0.0, 0.0, 4.0]]}}, "must be symmetric"),
        ({"machine": {"inertia": [[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 4.0]]}}, "must be positive definite"),
        ({"machine": {"inertia": [[1.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 4.0]]}}, "is of no rigid body"),
        ({"machine": {"inertia": [1.0, 1.0, 3.0]}}, "is of no rigid body"),
        ({"part": [{**PART, "inertia": [1.0, 1.0, 3.0]}]}, "is of no rigid body"),
        ({"part": [{**PART, "position": [0.3, -0.2, 4.1]}]}, "must lie within 1 m of the machine's outline"),
        ({"part": [PART, PART]}, "part.1.name = 'workpiece' must be unique"),
        ({"part": [{**PART, "mass": 0.0}]}, "part.0.mass"),
    ],
)
def test_what_is_no_body_is_refused(table: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said.replace(".", r"\.")):
        parse_scenario(table)
