"""Margins in a run's summary, and readings that count from rest."""

import numpy as np
import pytest

from ehamj import Controller, load_scenario, simulate
from ehamj.plant.mounts import MOUNTS
from ehamj.run.summarise import UNSTABLE

SHORT = ("duration=0.2", "plates=tied", "compare=[]", "ground={kind='rest'}")
STROKES = tuple(f"stroke {mount}" for mount in MOUNTS)


def stroke_law(gain: float, from_rest: bool = False) -> Controller:
    """Each valve against its own stroke, ``gain`` [V/m]."""
    empty = np.zeros((0, 0))
    return Controller(
        empty, np.zeros((0, 4)), np.zeros((4, 0)), -gain * np.eye(4), STROKES, bits=None, from_rest=from_rest
    )


def test_a_law_that_feeds_back_has_margins() -> None:
    found = simulate(load_scenario("recorded", SHORT)).summary["margins"]
    assert found["stable"] is True
    assert found["gain_db"] > 6.0
    assert found["phase_deg"] > 45.0
    assert set(found["motions"]) == {"heave", "roll", "pitch", "warp"}


@pytest.mark.parametrize("control", ["{kind='passive'}", "{kind='feedforward'}"])
def test_without_a_loop_there_are_none(control: str) -> None:
    assert simulate(load_scenario("recorded", (*SHORT, f"control={control}"))).summary["margins"] is None


def test_an_unstable_loop_is_said_to_be_unstable() -> None:
    scenario = load_scenario("recorded", SHORT)
    # The oil's resonance at 528 Hz limits 2π f_c to about 2 δ_h ω_h = 686 1/s, 6e6 V/m; this is five times that.
    summary = simulate(scenario, controller=stroke_law(3e7, from_rest=True)).summary
    assert summary["margins"]["stable"] is False
    pole = summary["margins"]["unstable"]
    assert f"{UNSTABLE}: {pole['words']}" in summary["warnings"]
    # Valve and oil swing against each other, near the valve's 250 Hz; three motions of the four valves can do so.
    assert pole["frequency_hz"] == pytest.approx(250.0, rel=0.1)
    assert pole["motion"] == "valves about x"
    assert (pole["damping_ratio"] < 0.0, pole["count"]) == (True, 3)


def test_readings_from_rest_leave_the_machine_where_it_stands() -> None:
    scenario = load_scenario("recorded", (*SHORT, "sensors={}"))  # exact ones: noise would move the valves too
    lifted, left = (simulate(scenario, controller=stroke_law(1e5, rest)).dataset for rest in (False, True))
    # The membranes stand at −14.6 µm under the weight: counted from unloaded membranes that asks for 1.46 V.
    assert float(lifted.valve_command[1].mean()) == pytest.approx(1.46, rel=0.01)
    assert float(np.abs(left.valve_command).max()) < 1e-6
    assert float(np.abs(left.measured).max()) < 1e-11
