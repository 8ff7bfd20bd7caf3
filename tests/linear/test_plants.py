"""What `linearise` hands out survives python-control: responses, poles and margins against exact arithmetic."""

from typing import Any

import control
import numpy as np
import pytest
from oracles.exact import exact_response

from ehamj.linear.machine import linear_model
from ehamj.linear.plants import LinearPlant
from ehamj.linear.refined import refined_response
from ehamj.scenario.load import parse_scenario
from ehamj.views.linear import linearise

UNEQUAL: dict[str, Any] = {
    "machine": {"mass": 5200.0, "inertia": [2500.0, 3600.0, 4100.0], "cg": [0.12, -0.07, 0.9]},
    "mount": [
        {"name": "front-left", "position": [0.9, 0.6], "actuator": "soft"},
        {"name": "front-right", "position": [0.8, -0.7]},
        {"name": "rear-left", "position": [-0.9, 0.6]},
        {"name": "rear-right", "position": [-0.9, -0.6], "actuator": "soft"},
    ],
    "actuators": {
        "isolator": {"flow_gain": 1.96e-6},
        "soft": {"membrane_stiffness": 9e7, "air_fraction": 0.01, "valve_frequency": 900.0, "area_ratio": 0.95},
    },
    "supply": {"dynamic": True},
}
MACHINES: dict[str, dict[str, Any]] = {
    "default": {},
    "gain": {"actuators": {"isolator": {"flow_gain": 1.96e-6}}},
    "recommended": {"actuators": {"isolator": {"preset": "recommended"}}},
    "unequal": UNEQUAL,
    "flexible feet": {"actuators": {"isolator": {"foot_stiffness": 2e9, "foot_damping": 1e4}}},
}
HERTZ = np.array([0.01, 0.4, 70.4, 9000.0])
WITHIN = 1e-10
"""Share of a channel's largest response, 200 dB, down to which it is judged."""
AGREES = 1e-6


def plant_of(name: str) -> LinearPlant:
    found = linearise(parse_scenario(MACHINES[name]))
    assert isinstance(found, LinearPlant)
    return found


@pytest.fixture(scope="module", params=MACHINES)
def plant(request: pytest.FixtureRequest) -> LinearPlant:
    return plant_of(request.param)


def test_single_channels_are_those_of_exact_arithmetic(plant: LinearPlant) -> None:
    exact = np.array([exact_response(plant, 2j * np.pi * hertz) for hertz in HERTZ])
    exact[np.abs(exact) < 1e-50] = 0.0  # nothing leads there
    draw = np.random.default_rng(1)
    for _ in range(40):
        i, j = int(draw.integers(plant.noutputs)), int(draw.integers(plant.ninputs))
        expected = exact[:, i, j]
        found = control.frequency_response(plant[i, j], 2 * np.pi * HERTZ).complex
        judged = np.abs(expected) > WITHIN * np.abs(expected).max()
        np.testing.assert_allclose(found[judged], expected[judged], rtol=AGREES, atol=0)
        assert not found[expected == 0.0].any()


def test_gains_at_rest_are_those_of_exact_arithmetic(plant: LinearPlant) -> None:
    expected = exact_response(plant, 0j).real
    # A channel that rests at zero is judged against its size where it moves, 200 dB below which all is zero.
    moving = np.abs(exact_response(plant, 2j * np.pi * 70.4))
    found = np.array([[plant[i, j].dcgain() for j in range(4)] for i in range(0, plant.noutputs, 5)])
    judged = np.abs(expected[::5, :4]) > WITHIN * moving[::5, :4]
    assert judged.any()
    np.testing.assert_allclose(found[judged], expected[::5, :4][judged], rtol=AGREES, atol=0)


@pytest.mark.parametrize("name", MACHINES)
def test_scaling_changes_no_digit_and_is_taken_back(name: str) -> None:
    model, plant = linear_model(parse_scenario(MACHINES[name]).plant), plant_of(name)
    scales = plant.scales
    np.testing.assert_array_equal(scales[:, None] * plant.A / scales, model.A)
    np.testing.assert_array_equal(scales[:, None] * plant.B, model.B)
    np.testing.assert_array_equal(plant.operating_point, model.equilibrium)
    assert plant.state_labels == list(model.states)
    np.testing.assert_array_equal(plant[:, :4].scales, scales)
    units = dict(zip(model.states, plant.state_units, strict=True))
    assert (units["displacement z"], units["velocity rx"], units["spool front-left"]) == ("m", "rad/s", "mA")
    np.testing.assert_allclose(np.sort(np.abs(plant.poles())), np.sort(np.abs(np.linalg.eigvals(model.A))), rtol=1e-7)


@pytest.mark.parametrize("output", ["cg_displacement z", "foot_velocity front-left z", "foot_acceleration rear-left z"])
def test_margins_of_a_channel_are_read_off_its_response(output: str) -> None:
    plant = plant_of("gain")[output, "valve_command front-left"]
    hertz = np.geomspace(1.0, 3000.0, 1500)
    size = 3.0 / np.abs(control.frequency_response(plant, 2 * np.pi * hertz).complex).max()
    gain, phase, _, _ = control.margin(size * plant)
    # Independent of polynomials: crossings of the response, between which it is straight.
    loop = refined_response(2j * np.pi * hertz, plant.A, plant.B, plant.C, plant.D)[:, 0, 0] * size
    real = np.flatnonzero((loop.imag[:-1] * loop.imag[1:] < 0) & (loop.real[:-1] < 0))
    share = loop.imag[real] / (loop.imag[real] - loop.imag[real + 1])
    gains = -1.0 / (loop.real[real] + share * (loop.real[real + 1] - loop.real[real]))
    if loop[0].real < 0.0 and output == "cg_displacement z":
        gains = np.append(gains, -1.0 / loop[0].real)
    assert gain == pytest.approx(gains[np.argmin(np.abs(np.log(gains)))], rel=1e-3)
    log = np.log(np.abs(loop))
    crossed = np.flatnonzero(log[:-1] * log[1:] < 0)
    share = log[crossed] / (log[crossed] - log[crossed + 1])
    turn = np.unwrap(np.angle(loop))
    angles = np.degrees(turn[crossed] + share * (turn[crossed + 1] - turn[crossed])) % 360.0 - 180.0
    assert phase == pytest.approx(angles[np.argmin(np.abs(angles))], abs=0.1)


def test_multiples_series_and_feedback_stay_accurate() -> None:
    plant = plant_of("default")["cg_velocity z", "valve_command rear-left"]
    lag = control.ss(-300.0, 300.0, 1.0, 0.0)
    for system in (-2.0 * plant, plant * lag, lag * plant, control.feedback(plant * lag, 5.0)):
        expected = [exact_response(system, 2j * np.pi * hertz)[0, 0] for hertz in HERTZ]
        np.testing.assert_allclose(system(2j * np.pi * HERTZ), expected, rtol=1e-9)


def test_a_neutral_valve_hides_no_channel_that_does_not_show_it() -> None:
    # Within its threshold a spool stays where it is: a pole at zero, which the ground does not drive.
    plant = linearise(parse_scenario({"actuators": {"isolator": {"threshold": 0.05}}}))
    assert np.abs(plant.poles()).min() == 0.0
    free = linearise(parse_scenario({}))
    at = ("cg_displacement z", "cg_force z")
    np.testing.assert_allclose(plant[at].dcgain(), free[at].dcgain(), rtol=1e-9)
    integrator = control.ss(0.0, 1.0, 1.0, 0.0) * plant[at]
    assert integrator.dcgain() == np.inf
