"""Levelling: what a slide has tilted is back in the stated time, and the feedforward beside it isolates as it did."""

from typing import Any

import numpy as np
import pytest

from ehamj.control.architectures.levelling import LevellingSettings
from ehamj.linear.loop import Loop
from ehamj.linear.machine import linear_model
from ehamj.linear.response import rigid_floor
from ehamj.run.simulate import observed
from ehamj.scenario.load import load_scenario

STILL = (
    "ground={kind='rest'}",
    "compare=[]",
    "plates=tied",
    "record_rate=1000.0",
    "sensors.ground={kind='geophone'}",
    "control.delay=1e-4",
)
"""Without what costs time: the slide arrives at 3.5 s."""


def tilts(control: str, *others: str) -> tuple[np.ndarray, np.ndarray]:
    """Times after the slide has arrived [s], and pitch since the start [µrad]."""
    run = observed(load_scenario("moving-slide", [*STILL, f"control.parts={control}", *others])).dataset
    pitch = run.machine_displacement.sel(dof="ry").values
    return run.time.values - 3.5, 1e6 * (pitch - pitch[0])


def test_tilt_of_a_slide_is_gone_after_the_stated_time() -> None:
    time, tilted = tilts("[{kind='feedforward'}]", "duration=5.0")
    left = abs(tilted[-1])
    np.testing.assert_allclose(left, 1000 * 9.80665 * 0.8 / (4 * 6.8e8 * 0.81) * 1e6, rtol=0.02)  # carried by membranes
    time, level = tilts("[{kind='feedforward'}, {kind='levelling', time=1.0}]", "duration=5.5")
    assert np.abs(level[time >= 1.0]).max() < 0.05 * left
    # The converter's steps of 0.3 mV over leakage hold a motion to some 1 nrad.
    assert np.abs(level[time >= 1.9]).max() < 0.01 * left


@pytest.mark.parametrize(("time", "band", "most"), [(2.0, 5.0, 1.0), (0.5, 20.0, 1.0)])
def test_isolation_above_the_roll_off_stays(time: float, band: float, most: float) -> None:
    def gains(control: str) -> Any:
        scenario = load_scenario("moving-slide", ["compare=[]", f"control.parts={control}"])
        law = Loop.of(scenario, scenario.controller())
        return np.abs(rigid_floor(linear_model(scenario.plant), [0.05, band], law).response[:, 2, 2])

    alone = gains("[{kind='feedforward'}]")
    both = gains(f"[{{kind='feedforward'}}, {{kind='levelling', time={time}}}]")
    assert 20 * np.log10(both[1] / alone[1]) < most
    assert both[0] > 0.95  # slow motion of the floor is followed


def test_loop_inverts_the_leak_where_there_is_one() -> None:
    law = LevellingSettings(time=3.0)
    s = 2j * np.pi * np.array([0.05, 0.1])
    for slow in (0.0, 40.0):
        A, B, C, D = law.loop(slow)
        loop = np.array([(C @ np.linalg.solve(x * np.eye(len(A)) - A, B) + D)[0, 0] / (x + slow) for x in s])
        # The leak of the integral, 1e-3 of the crossing, counts 1e-5 there.
        np.testing.assert_allclose(np.abs(loop), 1.0 / np.abs(s * (1 + s / 4) ** 2), rtol=1e-4)
