"""Laws that a scenario finds for the machine at hand: which machine, with which margins, and what is said of it."""

from typing import Any

import numpy as np
import pytest

from ehamj.control import Controller
from ehamj.control.settings import DigitalSettings
from ehamj.errors import InputError
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.margins import report
from ehamj.linear.response import rigid_floor
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import Scenario

pytestmark = pytest.mark.filterwarnings("ignore::ehamj.DerivedAnew")
SENSORS = {"ground": {"kind": "geophone"}, "inertial": {"kind": "geophone"}, "stroke": {}, "pressure": {}}
HEAVY = {"machine.mass": 5200.0}


def scenario(**table: Any) -> Scenario:
    control = {"kind": "lqg", "delay": 1.5e-4}
    return parse_scenario({"plates": "tied", "sensors": SENSORS, "control": control, **table})


def law_of(one: Scenario) -> Controller:
    law = one.controller()
    assert isinstance(law, Controller)
    return law


def test_another_machine_gets_a_law_of_its_own_unless_it_is_held() -> None:
    """Of a machine 1.3 times as heavy: derived anew it leaves 6 dB with half the oil, as held it does not."""
    own = scenario()
    bulk = own.actuators["isolator"].bulk_modulus
    anew, held = own.varied(HEAVY, law="derived"), own.varied(HEAVY)
    np.testing.assert_array_equal(law_of(held).A, law_of(own).A)
    weak = linear_model(own.varied(HEAVY | {"actuators.isolator.bulk_modulus": 0.5 * bulk}).plant)
    (leaves, _, _), (lacks, _, _) = (report(weak, Loop.of(one, law_of(one))).worst for one in (anew, held))
    assert leaves > 6.0 > lacks


def test_a_run_says_for_which_machine_its_law_was_found() -> None:
    still = {"kind": "rest"}
    own = scenario(duration=0.02, ground=still)
    found = [simulate(one).summary.law for one in (own, own.varied(HEAVY), own.varied(HEAVY, law="derived"))]
    assert [(one.mass_kg, one.held, one.machines) for one in found if one] == [
        (4000.0, False, 6),
        (4000.0, True, 6),
        (5200.0, False, 6),
    ]
    assert found[0] is not None
    law = law_of(own)
    gain, phase, disk = np.min([report(linear_model(one), Loop.of(own, law)).worst for one in varied(own)], axis=0)
    said = [one.margin for one in (found[0].gain_db, found[0].phase_deg, found[0].disk)]
    np.testing.assert_allclose(said, [gain, phase, disk], rtol=1e-6)
    assert "lqg, found for this machine (4000 kg) in" in found[0].words
    assert simulate(scenario(duration=0.02, ground=still, control={"kind": "combined"})).summary.law is None


def varied(own: Scenario) -> list[Any]:
    """The machines that a law must hold on, by the keys of a scenario."""
    isolator = own.actuators["isolator"]
    keys: list[dict[str, float]] = [{}, {"machine.mass": 2800.0}, {"machine.mass": 5200.0}]
    keys += [{"actuators.isolator.bulk_modulus": 0.5 * isolator.bulk_modulus}]
    keys += [{"actuators.isolator.flow_gain": 1.5 * isolator.flow_gain}]
    keys += [
        {
            "machine.mass": 0.95 * own.machine.mass,
            **{f"actuators.isolator.{key}": 0.95 * getattr(isolator, key) for key in ("bulk_modulus", "flow_gain")},
        }
    ]
    return [own.varied(one).plant for one in keys]


def test_margins_that_no_law_leaves_refuse_the_run_and_name_the_way_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ehamj.synthesis.search.TRIES", 1)
    greedy = {"kind": "lqg", "delay": 1.5e-4, "margins": {"gain_margin": 30.0}}
    with pytest.raises(InputError, match=r"no lqg law was found that leaves 30 dB.*control\.margins"):
        simulate(scenario(duration=0.02, control=greedy))


def test_what_is_the_whole_law_s_is_stated_once() -> None:
    with pytest.raises(InputError, match=r"feedforward\.rate: is stated once"):
        scenario(control={"kind": "lqg", "feedforward": {"rate": 5000.0}})


def test_it_is_written_and_read_again(tmp_path: Any) -> None:
    own = scenario(control={"kind": "h-infinity", "margins": {"gain_margin": 7.0}, "feedforward": {"rolloff": 900.0}})
    own.save(tmp_path / "scenario.toml")
    again = load_scenario(tmp_path / "scenario.toml")
    assert again.control == own.control
    assert "rate" not in again.to_toml().split("[control.feedforward]")[1].split("[")[0]


def test_isolating_from_a_frequency_leaves_what_is_slower_to_the_floor() -> None:
    """Feedforward and loops alike, as the law tuned by hand does it: far below, both follow the floor as much."""
    model, moved = linear_model(scenario().plant), []
    combined = parse_scenario({"control": {"kind": "combined", "delay": 1.5e-4}}).control
    assert isinstance(combined, DigitalSettings)
    alike = {"blend": {"restore": 0.05}, "feedforward": {"restore": 0.05}}
    late = {"kind": "lqg", "isolate_from": 5.0, **alike}
    for control in (scenario().control, scenario(control=late).control):
        one = scenario().model_copy(update={"control": control})
        moved.append(moves(model, Loop.of(one, law_of(one))))
    one = scenario().model_copy(update={"control": combined.isolating_from(5.0)})
    by_hand = moves(model, Loop.of(one, law_of(one)))
    assert moved[1][0] > 2.0 * moved[0][0]
    assert moved[1][0] == pytest.approx(by_hand[0], rel=0.1)
    assert moved[1][1] < 0.05


def moves(model: LinearModel, loop: Loop) -> np.ndarray:
    """How much of a heaving floor the machine follows at 0.5 and 20 Hz."""
    return np.abs(rigid_floor(model, [0.5, 20.0], loop, ("cg_displacement z",), ("z",)).response[:, 0, 0])


def test_valves_that_rest_within_their_overlap_get_the_law_of_those_without() -> None:
    """Nothing passes them at rest; where nothing is made good of it, the law is that of the valves outside."""
    lapped = scenario(actuators={"isolator": {"overlap": [0.4] * 4, "threshold": 0.04}})
    np.testing.assert_array_equal(law_of(lapped).A, law_of(scenario()).A)
