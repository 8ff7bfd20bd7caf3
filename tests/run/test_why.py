"""Why an axis gets worse: the mode that is excited, what drives it, whether the law does it, or a limit."""

import math
from typing import Any

import pytest

from ehamj.control import PythonController
from ehamj.judge.worse import CAUSES, Worse, made_worse
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.plant.mounts import MOUNTS
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario, parse_scenario

WAVE = {"kind": "broadband", "level": "VC-C", "axes": ["x", "y", "z"], "highest": 200.0}


def found(**table: Any) -> dict[str, Worse]:
    """What gets worse by axis, of the band that is worst along each."""
    result = simulate(parse_scenario({"plates": "tied", "duration": 4.0, "ground": WAVE, **table}))
    assert {one.in_words() for one in result.summary.worse} <= set(result.summary.warnings)
    return {one.axis: one for one in sorted(result.summary.worse, key=lambda one: one.amplification_db or 0.0)}


def told(**table: Any) -> dict[str, str]:
    """The reasons of `found`."""
    return {axis: one.why for axis, one in found(**table).items()}


def test_a_passive_machine_names_the_mode_of_each_axis() -> None:
    reasons = told()
    found = {mode.name: mode for mode in modes(linear_model(parse_scenario({"plates": "tied"}).plant))}
    for axis, name in (("x", "sway-rocking about y"), ("y", "sway-rocking about x")):
        mode = found[name]
        named = f"{name} at {mode.frequency:.3g} Hz (damping {mode.damping_ratio:.2g}) is excited"
        assert reasons[axis] == named


def test_what_drives_it_is_named_where_it_is_another_motion_of_the_floor() -> None:
    """A wave along x lifts front and rear in turn; along x itself the floor stands still."""
    reasons = told(ground={"kind": "broadband", "level": "VC-C", "highest": 200.0, "wave": {"speed": 200.0}})
    assert "driven by the floor's pitch" in reasons["x"]


def test_a_law_that_helps_is_said_to_help() -> None:
    scenario = load_scenario("vc-c-floor", ("duration=3.0", "compare=[]", "plates=tied"))
    (along,) = (one for one in simulate(scenario).summary.worse if one.axis == "x")
    assert "driven by the floor's pitch; with the valves held it would be " in along.why
    assert along.why.endswith(" dB more")
    assert f"{abs(along.beside_db or 0.0):.1f} dB below the floor's vertical motion; " in along.in_words()


def test_a_law_that_does_it_itself_is_told_from_one_that_cannot_reach_it() -> None:
    """A roll-off at 30 Hz turns the feedforward's phase: in the bands above it adds to the floor's motion."""
    control = {"kind": "feedforward", "delay": 4e-3}
    worse = found(control=control)
    assert "with the valves held as well (" in worse["x"].why
    assert "the valves act vertically" in worse["x"].why
    assert "by the law: with the valves held it is " in worse["z"].why
    assert (worse["x"].by, worse["z"].by) == ("mounts", "law")
    sentence = made_worse(list(worse.values()))
    assert f"along x by {worse['x'].amplification_db:.1f} dB at {worse['x'].band} Hz" in sentence
    assert sentence.index("along z") < sentence.index(CAUSES["law"]) < sentence.index("along x")
    assert sentence.endswith(CAUSES["mounts"])


def test_a_limit_that_was_reached_is_named_where_the_linear_machine_says_nothing() -> None:
    """A weak valve drive: the linear machine isolates, this one cannot follow and shakes at other frequencies."""
    loud = {**WAVE, "level": "workshop", "axes": ["z"], "first": 4.0, "last": 20.0}
    tone = {"kind": "sine", "dof": "z", "amplitude": 1e-9, "frequency": 63.0}
    worse = found(ground={"kind": "sum", "parts": [loud, tone]}, control={"kind": "feedforward"})
    assert "the command was at its limit for " in worse["z"].why
    assert worse["z"].by == "limits"


def test_a_python_function_is_named() -> None:
    """It lifts the machine with the floor, twice as far."""
    scenario = parse_scenario({"plates": "tied", "duration": 2.0, "ground": {**WAVE, "axes": ["z"]}})
    channels = [f"ground_velocity {mount} z" for mount in MOUNTS]
    law = PythonController(lambda time, measured, limited: 8e3 * measured, channels)
    reasons = [one.why for one in simulate(scenario, controller=law).summary.worse if one.axis == "z"]
    assert reasons
    assert all("a Python function commands the valves" in why for why in reasons)


def test_its_decibel_is_the_measured_one() -> None:
    result = simulate(parse_scenario({"plates": "tied", "duration": 4.0, "ground": WAVE}))
    worst = max((one for one in result.summary.worse if one.axis == "x"), key=lambda one: one.amplification_db or 0.0)
    levels = {place: table["x"][worst.band] for place, table in result.summary.third_octave_velocity.items()}
    floor = levels.pop("floor")
    loudest = max(value for value in levels.values() if value is not None)
    assert floor is not None
    # Relative to the loudest mount: the mean of the mounts is smaller where they do not move as one.
    assert worst.amplification_db == pytest.approx(20.0 * math.log10(loudest / floor))
