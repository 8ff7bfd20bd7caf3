"""A law travels with its instruments and its seed; cut open, its loop is law times machine as each is known alone."""

import numpy as np
import pytest

from ehamj.control import Controller
from ehamj.control.sensors import IDEAL
from ehamj.linear.loop import Loop, opened
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.sampled import opened_at_samples, sampled_loop, spectral_radius
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.load import parse_scenario

NOTHING = np.zeros((4, 0))
INPUTS = tuple(f"{what} {mount} z" for what in ("foot_velocity", "ground_velocity") for mount in MOUNTS)
LAW = Controller(NOTHING.T @ NOTHING, np.zeros((0, 8)), NOTHING, np.hstack([-1e3 * np.eye(4), np.eye(4)]), INPUTS)


@pytest.fixture(scope="module")
def model() -> LinearModel:
    return linear_model(parse_scenario({"plates": "tied"}).plant)


def test_nothing_of_a_loop_may_be_left_out() -> None:
    for given in ((LAW,), (LAW, IDEAL)):
        with pytest.raises(TypeError, match="missing"):
            Loop(*given)  # type: ignore[call-arg]


def test_a_scenario_without_a_law_has_no_loop() -> None:
    scenario = parse_scenario({"seed": 7})
    assert Loop.of(scenario, scenario.controller()) is None
    loop = Loop.of(scenario, LAW)
    assert (loop.law, loop.sensors, loop.seed) == (LAW, scenario.sensors, 7)


def test_the_ground_does_not_answer_commands(model: LinearModel) -> None:
    plant = opened(model, Loop(LAW, IDEAL, 0), [3.0, 80.0]).plant
    assert np.abs(plant[:, :4]).min() > 0.0
    assert np.abs(plant[:, 4:]).max() == 0.0


def test_the_sensitivity_is_that_of_the_closed_loop(model: LinearModel) -> None:
    """1 + L is singular at the eigenvalues of the loop that the law sees, all but yaw and the valves in warp; on
    the circle the sensitivity is its inverse."""
    loop = Loop(LAW, IDEAL, 0)
    values = np.linalg.eigvals(sampled_loop(model, loop).A)
    swings = values[(values.imag > 1e-3) & (np.abs(values) > 0.9)]
    cut = opened_at_samples(model, loop, swings)
    least = np.linalg.svd(np.eye(4) + cut.gain, compute_uv=False)[:, -1]
    assert (swings.size, int(np.sum(least < 1e-6))) == (10, 8)
    on_circle = opened_at_samples(model, loop, np.exp(1j * np.array([0.01, 0.3])))
    np.testing.assert_allclose(
        on_circle.sensitivity @ (np.eye(4) + on_circle.gain), np.array([np.eye(4)] * 2), atol=1e-9
    )
    seen = np.ones((2, 8, 1))
    np.testing.assert_allclose(on_circle.commands(seen), on_circle.sensitivity @ on_circle.law @ seen, rtol=1e-9)


def test_the_spectral_radius_is_above_one_where_a_loop_grows(model: LinearModel) -> None:
    assert spectral_radius(model, Loop(LAW, IDEAL, 0)) < 1.0 + 1e-9
    assert spectral_radius(model, Loop(LAW.scaled(1e3), IDEAL, 0)) > 1.0
