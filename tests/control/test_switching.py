"""Commands that switch within a step, against SciPy that switches when they do, and the order of the whole."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from ehamj.arrays import Array
from ehamj.control import Controller
from ehamj.control.compiled.laws import step_shares
from ehamj.plant.mounts import MOUNTS
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario

PERIOD = 1e-3
GROUND = "ground={kind='multisine', frequencies=[7.0, 31.0], velocities=[2e-4]}"
"""Below a machine whose equations are smooth: its valves have neither laps nor a limited drive."""


def run(law: Controller, timestep: float, duration: float, *more: str, rate: float = 1.0 / PERIOD) -> Result:
    sets = [GROUND, f"duration={duration}", f"timestep={timestep!r}", f"record_rate={rate!r}", *more]
    return simulate(load_scenario("benchmark", sets), controller=law)


def law(what: str, gain: float, **own: Any) -> Controller:
    names = tuple(f"{what}_velocity {mount} z" for mount in MOUNTS)
    D = gain * np.diag([1.0, 0.5, -0.5, 1.2])
    A, C = np.diag([0.9, 0.8, 0.7, 0.6]), gain * np.eye(4)
    return Controller(A, np.eye(4), C, D, names, bits=None, **{"period": PERIOD, **own})


@given(st.floats(0.0, 1.0))
def test_the_moments_of_a_switch_are_exact(fraction: float) -> None:
    """Mean and first two moments, with the weights that the integrator gives to its stages."""
    start, middle, end = step_shares(fraction)
    w = 1.0 - fraction
    found = (start + 4 * middle + end) / 6, (start + 2 * middle) / 6, (start + middle) / 12
    np.testing.assert_allclose(found, [w, w**2 / 2, w**3 / 6], rtol=0, atol=1e-15)


def test_a_switch_at_a_border_of_a_step_is_there_from_that_on() -> None:
    assert step_shares(0.0) == (1.0, 1.0, 1.0)
    assert step_shares(1.0) == (0.0, 0.0, 0.0)


def spools(levels: Array, delay: float, own: Any, times: Array) -> Array:
    """Spools (row, mount) [mA] behind levels (sample, mount) [V], each from its sample's time and the delay on."""
    A = np.array([[0.0, 1.0], [-(own.valve_frequency**2), -2.0 * own.valve_damping * own.valve_frequency]])
    gain, rest = own.valve_gain, np.zeros((2, len(MOUNTS)))
    switches = np.arange(len(levels)) * PERIOD + delay
    state, now, held, found = rest, 0.0, rest[:1], []
    for time, level in sorted(
        [*((t, k) for k, t in enumerate(switches)), *((t, -1) for t in times)], key=lambda each: (each[0], each[1])
    ):
        target = np.vstack([held, rest[:1]])
        state, now = target + expm(A * (time - now)) @ (state - target), time
        if level >= 0:
            held = gain * np.clip(levels[level : level + 1], -own.voltage_limit, own.voltage_limit)
        else:
            found.append(state[0])
    return np.array(found)


@settings(max_examples=12)
@given(st.just(0.0) | st.floats(1e-7, 2.4e-3), st.sampled_from([10.0, 0.15]))
def test_spools_follow_a_command_as_if_it_switched_exactly(delay: float, valve_range: float) -> None:
    """Whatever the delay, with steps of an eighth of a period, and also where the valve limits the command."""
    one = law("ground", 1e3, delay=delay)
    found = run(one, PERIOD / 8, 0.04, f"actuators.isolator.voltage_limit={valve_range}", rate=8.0 / PERIOD)
    levels = found.dataset["valve_command"].values
    assert np.abs(levels).max() > 0.2
    # What a sample commands is in the first row that is not before it acts.
    first = np.ceil((np.arange(40) * PERIOD + delay) / (PERIOD / 8) - 1e-6).astype(int)
    levels = levels[first[first < len(levels)]]
    expected = spools(levels, delay, found.scenario.plant.actuators[0], found.dataset["time"].values)
    # The fourth moment of a switch is out by up to 0.31 (ω h)⁴/24 = 2e-5 of its height; a wrong time of 0.01 h by 2e-3.
    np.testing.assert_allclose(found.dataset["spool"].values, expected, rtol=0, atol=1e-4 * np.abs(expected).max())


def off(found: Array, exact: Array) -> float:
    """Largest error over the range."""
    return float(np.abs(found - exact).max() / np.ptp(exact))


@pytest.mark.parametrize(("what", "gain"), [("ground", 1e3), ("foot", 3e2)])
@pytest.mark.parametrize("delay", [3.7e-4, 1.37e-3])
def test_the_order_is_that_of_the_integrator(what: str, gain: float, delay: float) -> None:
    """An open chain and a closed loop, against steps that divide the delay."""
    one = law(what, gain, delay=delay)
    steps = (4, 5, 6, 8, 10, 12)
    exact, *found = (run(one, PERIOD / n, 0.03).dataset for n in (200, *steps))
    errors = [
        max(off(each[name].values, exact[name].values) for name in ("spool", "cg_displacement")) for each in found
    ]
    assert -np.polyfit(np.log(steps), np.log(errors), 1)[0] > 3.5
    assert errors[0] < 1e-3
