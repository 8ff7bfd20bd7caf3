"""Gains: the limit of stability against a nonlinear run, and the loop against its continuous form."""

import dataclasses

import numpy as np
import pytest

import ehamj
from ehamj.control import Controller
from ehamj.control.instruments import Geophone
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.errors import InputError
from ehamj.linear.loop import Loop
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.linear.sampled import spectral_radius
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario
from ehamj.studies import gains, position_loop, valve_oil

MACHINE = parse_scenario({"name": "a machine", "plates": "tied"})
LAW = position_loop.inertial_position(MACHINE.plant, 40.0)
LOOP = Loop(LAW, IDEAL, 0)


def test_the_law_is_an_integrator_of_velocity() -> None:
    """At 10 Hz: −2πf_c A_p/(K_Q K_v)/(jω); the trapezoidal rule is off by 3e-6, the leak at 0.05 Hz by 0.005j."""
    z = np.exp(2j * np.pi * 10.0 * LAW.period)
    response = LAW.C @ np.linalg.solve(z * np.eye(4) - LAW.A, LAW.B) + LAW.D
    actuator, s = MACHINE.plant.actuators[0], 2j * np.pi * 10.0
    wanted = -2 * np.pi * 40.0 * actuator.piston_area / (actuator.flow_gain * actuator.valve_gain) / s
    assert abs(response[0, 0] / wanted - 1.0) < 5.1e-3
    assert np.abs(response - np.diag(np.diag(response))).max() == 0.0


def test_the_limit_is_where_the_spectral_radius_is_one() -> None:
    model = linear_model(MACHINE.plant)
    limit = position_loop.highest_factor(model, LOOP)
    below, above = (spectral_radius(model, position_loop.scaled(LOOP, factor * limit)) for factor in (0.998, 1.002))
    assert below < 1.0 < above


def end_over_beginning(law: Controller, dof: str = "rx") -> float:
    """Stroke late over stroke early in a nonlinear run after a jolt, of a law with a fine converter."""
    jolt = {"kind": "shock", "dof": dof, "velocity": 1e-7, "pulse_time": 1e-3, "return_time": 1e-2, "begin": 1e-3}
    scenario: Scenario = parse_scenario(MACHINE.model_dump() | {"ground": jolt, "duration": 0.9, "record_rate": 2000.0})
    fine = dataclasses.replace(law, bits=None)
    stroke = ehamj.simulate(scenario, controller=fine).dataset["stroke"].values[:, 0]
    stroke = np.abs(stroke - stroke[0])
    return float(stroke[-200:].max() / stroke[400:600].max())


def test_a_nonlinear_run_grows_above_the_limit_and_decays_below() -> None:
    """1 % off: the margin is that of the simulated loop, hold and delay included."""
    limit = position_loop.highest_factor(linear_model(MACHINE.plant), LOOP)
    assert end_over_beginning(LAW.scaled(0.99 * limit)) < 0.9
    assert end_over_beginning(LAW.scaled(1.01 * limit)) > 1.1


def test_no_gain_gives_the_passive_poles() -> None:
    model = linear_model(MACHINE.plant)
    (poles,) = gains.root_locus(model, LOOP, np.array([0.0]))
    for value in np.linalg.eigvals(model.A):
        assert np.nanmin(np.abs(poles - value)) < 1e-6 * max(1.0, abs(value))


def test_feedforward_is_no_feedback() -> None:
    assert gains.feeds_back(LAW)
    assert not gains.feeds_back(parse_scenario({"name": "f", "control": {"kind": "feedforward"}}).controller())
    assert not gains.feeds_back(None)


def test_an_unstable_law_is_refused() -> None:
    with pytest.raises(InputError, match="unstable even"):
        position_loop.highest_factor(linear_model(MACHINE.plant), Loop(LAW.scaled(-1e4), IDEAL, 0))


def test_oil_stiffens_heave() -> None:
    """Undamped ω² = 4(K_L + K_h)/M; leakage and damping of 10 % move |λ| by less than 1 %."""
    settings = valve_oil.ValveOilSettings(factors=(0.5, 1.0, 2.0))
    heave = valve_oil.modes_over_factors(MACHINE, settings)["frequency"].sel(parameter="bulk_modulus", mode="heave")
    actuator, mass = MACHINE.plant.actuators[0], MACHINE.plant.total_mass
    stiffness = actuator.membrane_stiffness + np.array(settings.factors) * actuator.hydraulic_stiffness
    assert heave.values == pytest.approx(np.sqrt(4 * stiffness / mass) / (2 * np.pi), rel=0.01)


def test_a_slower_valve_makes_a_slower_loop() -> None:
    settings = valve_oil.ValveOilSettings(loops=(0.5,), looped=("valve_frequency",))
    crossover = valve_oil.fastest_loops(MACHINE, settings)["crossover"].sel(parameter="valve_frequency").values
    assert crossover[0] < 0.8 * crossover[1]
    assert crossover[1] == pytest.approx(
        40.0 * position_loop.highest_factor(linear_model(MACHINE.plant), LOOP), rel=5e-3
    )


def test_a_slow_sensor_takes_gain_away() -> None:
    """A low-pass of 200 Hz in every foot's instrument, at the frequency where the loop turns."""
    slow = Sensors(inertial=Geophone(kind="geophone", high=200.0))
    model = linear_model(MACHINE.plant)
    assert position_loop.highest_factor(model, Loop(LAW, slow, 0)) < 0.8 * position_loop.highest_factor(model, LOOP)


def test_branches_end_at_the_modes_that_the_closed_loop_has() -> None:
    """Followed from the passive pole in 13 steps, a mode arrives at what `modes` finds at the gain itself."""
    model = linear_model(MACHINE.plant)
    factors = np.linspace(0.0, 1.0, 13)
    over = gains.modes_over_gain(model, factors, gains.root_locus(model, LOOP, factors))
    there = {mode.name: mode for mode in modes(model, LOOP) if mode.machine_moves}
    for name, mode in there.items():
        end = over.sel(mode=name, factor=1.0)
        assert float(end["frequency"]) == pytest.approx(mode.frequency, rel=1e-6)
        assert float(end["damping"]) == pytest.approx(mode.damping_ratio, rel=1e-5)


def test_a_branch_is_one_pole() -> None:
    """Twice as many steps halve the largest step of every branch, but for those that meet on the real axis."""
    model = linear_model(MACHINE.plant)
    coarse, fine = (gains.root_locus(model, LOOP, np.linspace(0.0, 1.0, n)) for n in (21, 41))
    steps = [np.nanmax(np.abs(np.diff(poles[:, np.abs(poles[0].imag) > 100.0], axis=0))) for poles in (coarse, fine)]
    assert 1.7 < steps[0] / steps[1] < 2.3
