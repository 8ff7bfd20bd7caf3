"""A valve that has no slope where it rests has no linear model, and the option that takes it away is named."""

import math

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.linear.loop import closed_at_rest, linear_under
from ehamj.linear.machine import linear_model
from ehamj.linear.smooth import used_options
from ehamj.run.simulate import simulate
from ehamj.run.summarise import loop_margins
from ehamj.scenario.load import parse_scenario

SMOOTH = {"overlap": [0.1, -0.2, 0.1, 0.05], "null_offset": 0.01, "threshold": 0.05, "end_stops": True}


@pytest.mark.parametrize(("option", "value"), [("hysteresis", 0.01), ("threshold", 0.004)])
def test_what_bends_within_the_step_is_refused_by_name(option: str, value: float) -> None:
    """The difference's step is 0.01 mA: one of 0.004 and one of 0.01 mA see other slopes."""
    scenario = parse_scenario({"actuators": {"isolator": {**SMOOTH, option: value}}})
    with pytest.raises(InputError, match=f"{option} = {value}.*front-left.*0.01 mA.*{option} = 0.0"):
        linear_model(scenario.plant)


def test_only_the_valve_that_has_it_is_named() -> None:
    places = {"one": (0.9, 0.0), "two": (-0.8, 0.5), "three": (-0.8, -0.5)}
    mounts = [{"name": name, "position": list(place)} for name, place in places.items()]
    mounts[1]["actuator"] = "sticky"
    actuators = {"isolator": {"threshold": 0.05}, "sticky": {"hysteresis": 0.01}}
    with pytest.raises(InputError, match=r"hysteresis = 0.01 \(Hysteresis\) of mount two"):
        linear_model(parse_scenario({"mount": mounts, "actuators": actuators}).plant)


def test_options_that_are_smooth_at_rest_pass_and_a_default_valve_has_none() -> None:
    plant = parse_scenario({"actuators": {"isolator": SMOOTH}}).plant
    assert np.isfinite(linear_model(plant).A).all()
    assert {option.__name__ for option in used_options(plant.actuators[0])} == {
        "Overlap", "NullOffset", "Threshold", "EndStops"
    }  # fmt: skip
    assert not used_options(parse_scenario({}).plant.actuators[0])


def test_a_run_goes_on_and_says_so() -> None:
    sine = {"kind": "sine", "dof": "z", "amplitude": 1e-6, "frequency": 10.0}
    table = {"duration": 0.3, "actuators": {"isolator": {"hysteresis": 0.01}}, "ground": sine}
    found = simulate(parse_scenario(table)).summary
    assert found.complete
    assert math.isfinite(found.rms["cg_velocity"]["z"])
    (said,) = [warning for warning in found.warnings if "no linear model" in warning]
    assert "hysteresis = 0.01" in said


@pytest.mark.parametrize(("option", "value"), [("overlap", [0.4] * 4), ("hysteresis", 0.1), ("threshold", 0.05)])
def test_a_loop_that_valves_open_at_rest_has_no_margins_unless_that_is_made_good(option: str, value: object) -> None:
    """It would look as if its gain could rise without limit."""
    table = {"plates": "tied", "actuators": {"isolator": {option: value}}}
    bare = parse_scenario({**table, "control": {"kind": "modal"}})
    margins, said = loop_margins(bare, bare.controller())
    assert margins is None
    assert "front-left, front-right, rear-left, rear-right pass nothing" in said[0]
    good = parse_scenario({**table, "control": {"kind": "modal", "linearisation": True}})
    margins, said = loop_margins(good, good.controller())
    assert margins is not None
    assert margins.gain_db < 20.0
    assert not said


def test_ideal_valves_pass_oil_at_rest() -> None:
    scenario = parse_scenario({"plates": "tied", "control": {"kind": "modal"}})
    assert closed_at_rest(linear_under(scenario.plant, scenario.controller())) == ()
