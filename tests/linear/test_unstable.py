"""What runs away is named: by the eigenvalue that grows, and by the motion that it is built to be."""

import numpy as np
import pytest

from ehamj.control import Controller
from ehamj.control.sensors import IDEAL
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.sampled import spectral_radius
from ehamj.linear.unstable import unstable_pole
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.load import parse_scenario

HEAVE, WARP = np.full(4, 0.25), np.array([1.0, -1.0, -1.0, 1.0]) / 4.0


@pytest.fixture(scope="module")
def model() -> LinearModel:
    return linear_model(parse_scenario({}).plant)


def pattern_loop(pattern: np.ndarray, quantity: str, gain: float) -> Loop:
    """All valves in a pattern against the same pattern of a quantity, per unit of it [V]."""
    inputs = tuple(f"{quantity} {mount}" for mount in MOUNTS)
    D = gain * 4.0 * np.outer(np.sign(pattern), pattern)
    empty = {"A": np.zeros((0, 0)), "B": np.zeros((0, 4)), "C": np.zeros((4, 0))}
    return Loop(Controller(**empty, D=D, inputs=inputs, bits=None), IDEAL, 0)


def test_what_stands_has_no_such_pole(model: LinearModel) -> None:
    assert unstable_pole(model) is None
    assert unstable_pole(model, pattern_loop(HEAVE, "stroke", -1e5)) is None


def test_strokes_that_are_driven_on_in_heave_run_away_in_heave(model: LinearModel) -> None:
    loop = pattern_loop(HEAVE, "stroke", 1e6)
    pole = unstable_pole(model, loop)
    assert pole is not None
    assert (pole.motion, pole.count) == ("heave", 1)
    assert pole.growth == pytest.approx(np.log(spectral_radius(model, loop)) / 1e-4, rel=1e-6)
    assert (pole.damping_ratio, str(pole)) == (
        pytest.approx(-1.0), f"heave without swinging, growing e-fold in {1.0 / pole.growth:.3g} s",
    )  # fmt: skip


def test_pressures_that_are_driven_on_in_warp_run_away_in_warp(model: LinearModel) -> None:
    pole = unstable_pole(model, pattern_loop(WARP, "load_pressure", 1e-4))
    assert pole is not None
    assert "in warp" in pole.motion
    assert pole.to_dict()["words"] == str(pole)


def test_a_tall_machine_on_soft_mounts_falls_over() -> None:
    mounts = {"preset": "elastic-mount", "membrane_stiffness": 2e4}
    table = {"machine": {"cg": [0.0, 0.0, 1.8], "size": [2.2, 1.6, 3.9]}, "actuators": {"isolator": mounts}}
    pole = unstable_pole(linear_model(parse_scenario(table).plant))
    assert pole is not None
    assert pole.motion.endswith("about x")
    assert "without swinging" in str(pole)
    assert pole.count == 2
