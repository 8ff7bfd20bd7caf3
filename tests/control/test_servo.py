"""Stroke servos: against closed forms, fighting each other without balance, and damped by pressure."""

from typing import Any

import numpy as np
import pytest

from ehamj.control.architectures.servo import StrokeServoSettings
from ehamj.control.sensors import IDEAL
from ehamj.linear.loop import Loop, opened
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.modes import modes
from ehamj.plant.mounts import MOUNTS
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

SUPPLY = 70e5
STROKES = [f"stroke {mount}" for mount in MOUNTS]


@pytest.fixture(scope="module")
def model() -> LinearModel:
    return linear_model(parse_scenario({"plates": "tied"}).plant)


def servo(**given: Any) -> StrokeServoSettings:
    return StrokeServoSettings.model_validate({"kind": "stroke-servo", **given})


@pytest.mark.parametrize("hertz", [1.0, 5.0, 12.0])
def test_the_loop_of_heave_is_crossing_over_frequency(hertz: float, model: LinearModel) -> None:
    # L = f_c/(j f)·(1 + f_i/(j f))·valve·e^(−sτ), oil and inertia left out: 0.04°/Hz.
    law = servo(loop={"crossing": 40.0, "integral": 2.0, "notch_depth": 1.0}).controller(model.plant, IDEAL)
    found = opened(model, Loop(law, IDEAL, 0), hertz).gain[0].sum(axis=1).mean()
    s = 2j * np.pi * hertz
    valve = 1 / (1 + 2 * 0.65 * s / 1571 + (s / 1571) ** 2)
    expected = 40.0 / (1j * hertz) * (1 + 2.0 / (1j * hertz)) * valve * np.exp(-1.5e-4 * s)
    # The integrals end at 0.01 Hz: 1 % at 1 Hz.
    assert complex(found) == pytest.approx(complex(expected), rel=0.02)


def fought(sensors: dict[str, Any], **given: Any) -> Result:
    ground = {"kind": "broadband", "level": "VC-C"}
    control = {"kind": "stroke-servo", **given}
    table = {"plates": "tied", "duration": 3.0, "seed": 3, "sensors": {"stroke": sensors}}
    return simulate(parse_scenario({**table, "ground": ground, "control": control}))


def warp(run: Result) -> float:
    pressure = run.dataset["chamber_pressure"].values
    load = (pressure[:, :, 0] - pressure[:, :, 1]) @ np.array([1.0, -1.0, -1.0, 1.0]) / 4
    return float(np.abs(load - load[0]).max() / SUPPLY)


@pytest.mark.parametrize(("sensors", "least"), [({"drift": 1e-7}, 0.015), ({"random_walk": 1e-8}, 0.04)], ids=str)
def test_servos_that_disagree_fight_unless_they_are_balanced(sensors: dict[str, float], least: float) -> None:
    # Measured without balance: 0.3 µm of drift build 1.7 % of the supply's pressure, a walk of 10 nm/√s 8 %.
    assert warp(fought(sensors, balance={"crossing": 0.0})) > least
    assert warp(fought(sensors)) < 0.001


def damping(model: LinearModel, gain: float, mode: str) -> float:
    law = servo(pressure={"gain": gain}, rate=40_000.0).controller(model.plant, IDEAL)
    found = modes(model, Loop(law, IDEAL, 0))
    return max(m.damping_ratio for m in found if m.name.endswith(mode) and m.frequency < 600.0)


def test_dynamic_pressure_feedback_damps_what_lies_below_the_valve(model: LinearModel) -> None:
    assert damping(model, 3.0, "sway-rocking about x") > 1.5 * damping(model, 0.0, "sway-rocking about x")


def test_with_a_fast_valve_it_damps_the_oil_too() -> None:
    fast = linear_model(parse_scenario({"plates": "tied", "actuators": {"isolator": {"valve_frequency": 2e4}}}).plant)
    for mode in ("heave", "rocking about y"):
        assert damping(fast, 1.0, mode) > 1.5 * damping(fast, 0.0, mode)


def test_dynamic_pressure_feedback_leaves_static_loads_alone(model: LinearModel) -> None:
    law = servo(pressure={"gain": 3.0}, balance={"crossing": 0.0}, loop={"crossing": 0.0}).controller(
        model.plant, IDEAL
    )
    gains = np.abs(law.response([0.02, 200.0])[:, 0]).max(axis=1)
    assert gains[0] < 2e-3 * gains[1]  # a high-pass at 20 Hz: 1e-3


def test_a_servo_whose_reference_is_the_ground_isolates_and_one_at_rest_does_not() -> None:
    ground = {"kind": "multisine", "frequencies": [10.0], "velocities": [1e-5], "fade_in": 0.5}
    ratio = {}
    for reference in ("rest", "ground"):
        control = {"kind": "stroke-servo", "reference": reference}
        run = simulate(parse_scenario({"plates": "tied", "duration": 2.0, "ground": ground, "control": control}))
        late = run.dataset.sel(time=slice(1.0, None))
        heave = late["cg_velocity"].sel(axis="z").std() / late["ground_velocity"].sel(axis="z").std()
        ratio[reference] = float(heave)
    assert ratio["rest"] == pytest.approx(1.0, abs=0.02)
    # |1 − T| = |S| with |L| = 4 at 10 Hz and −107°: 0.25.
    assert ratio["ground"] == pytest.approx(0.25, abs=0.04)
