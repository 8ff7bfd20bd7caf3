"""Adaptive cancellation of lines: how far a line comes down, how fast, and what it does when the valves saturate."""

from typing import Any

import numpy as np
import pytest

from ehamj.control.kinds import CombinedSettings
from ehamj.design.adaptive import LineSettings, line_cancellation
from ehamj.errors import InputError
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

DELAY = 1.5e-4
LINES = (24.5, 49.0)
TIME, LEAK = 0.08, 2.4
"""The line comes down to 1/31 = TIME/(TIME + LEAK)."""
GEOPHONE = {"kind": "geophone", "noise": 0.0}


def scenario(duration: float, **table: Any) -> Scenario:
    floor = {"kind": "multisine", "frequencies": list(LINES), "velocities": [1e-5], "fade_in": 0.02}
    table = {"plates": "tied", "duration": duration, "record_rate": 2000.0, "ground": floor, **table}
    return parse_scenario(table)


def settings(**changes: Any) -> LineSettings:
    return LineSettings(**({"lines": LINES, "time": TIME, "leak": LEAK, "delay": DELAY} | changes))


def heave(case: Scenario, law: Any, start: float, stop: float) -> np.ndarray:
    """Amplitude of the machine's heave at each line over a part of a run [m/s]."""
    run = simulate(case, controller=law).dataset
    part = run["cg_velocity"].sel(axis="z", time=slice(start, stop))
    times = part["time"].values
    waves = [trig(2 * np.pi * f * times) for f in LINES for trig in (np.sin, np.cos)]
    basis = np.column_stack([*waves, np.vander(times - times.mean(), 3)])
    fitted = np.linalg.lstsq(basis, part.values, rcond=None)[0]
    return np.hypot(fitted[0 : 2 * len(LINES) : 2], fitted[1 : 2 * len(LINES) : 2])


def test_a_line_comes_down_to_what_the_leak_leaves() -> None:
    case = scenario(0.9)
    # 0.65 s, eight times TIME, leave e⁻⁸; the lines' skirts touch each other at TIME/(2π·24.5 Hz) of 31: 8e-2 of
    # the rest, in quadrature; the turbulent valve adds 1e-3.
    ratio = heave(case, line_cancellation(case, settings()), 0.65, 0.9) / heave(case, None, 0.65, 0.9)
    np.testing.assert_allclose(ratio * (1 + LEAK / TIME), 1.0, atol=0.05)


def test_it_comes_down_by_e_in_its_time() -> None:
    slow = settings(time=0.5, leak=500.0)
    case = scenario(0.7)
    ratio = heave(case, line_cancellation(case, slow), 0.5, 0.7) / heave(case, None, 0.5, 0.7)
    # Mean of e^(−t/0.5) over the part; it began while the floor faded in, 0.02 s.
    mean = 0.5 / 0.2 * (np.exp(-1.0) - np.exp(-1.4))
    np.testing.assert_allclose(ratio, mean, rtol=0.05)


def test_on_top_of_a_broadband_law_it_takes_that_law_into_account() -> None:
    sensors = {"ground": GEOPHONE, "inertial": GEOPHONE, "stroke": {"noise": 0.0}, "pressure": {"noise": 0.0}}
    case = scenario(0.9, sensors=sensors)
    law = CombinedSettings(delay=DELAY, bits=52).controller(case.plant, case.sensors)
    both = line_cancellation(case, settings(), beside=law)
    assert set(law.inputs) <= set(both.inputs)
    ratio = heave(case, both, 0.65, 0.9) / heave(case, law, 0.65, 0.9)
    # The broadband law settles at the same time: its slow transients leave some of the line's fit.
    np.testing.assert_allclose(ratio * (1 + LEAK / TIME), 1.0, atol=0.15)


def test_a_run_begins_anew() -> None:
    case = scenario(0.05)
    law = line_cancellation(case, settings())
    first, second = (simulate(case, controller=law).dataset["valve_command"].values for _ in range(2))
    assert np.abs(first).max() > 1e-3
    np.testing.assert_array_equal(first, second)


def test_it_does_not_learn_while_a_valve_is_limited() -> None:
    law = line_cancellation(scenario(0.05), settings())
    measured, free, limited = np.full(4, 1e-5), np.zeros(4), np.array([0.0, -1.0, 0.0, 0.0])
    for k in range(50):
        law.wanted(k * 1e-4, measured, limited)
    np.testing.assert_array_equal(law.wanted(50e-4, measured, limited), 0.0)
    for k in range(50, 100):
        law.wanted(k * 1e-4, measured, free)
    assert np.abs(law.wanted(100e-4, measured, free)).max() > 1e-3


def test_a_line_above_half_the_rate_is_refused() -> None:
    with pytest.raises(InputError, match="lines: 6000 Hz must be below half the sampling rate, 5000 Hz"):
        line_cancellation(scenario(0.05), settings(lines=(50.0, 6000.0)))
