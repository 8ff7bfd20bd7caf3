"""Designs as machines: values all at once, and which machine a law was derived for."""

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.merits.applied import designs_of, scenario_of
from ehamj.merits.merit import Machine
from ehamj.scenario.load import load_scenario

BASE = load_scenario("vc-c-floor", ["control.kind='combined'"])
HEAVY, WEAK = {"machine.mass": 5000.0}, {"actuators.isolator.flow_gain": 1e-6}


def law_of(scenario):  # type: ignore[no-untyped-def]
    return scenario.controller().to_dict()


def test_a_law_is_held_or_derived_for_the_design_or_for_what_it_knows_of_it() -> None:
    """Three machines of one set of values; the law of each is that of another machine."""
    both = HEAVY | WEAK
    held = scenario_of(Machine(BASE, "held"), both)
    derived = scenario_of(Machine(BASE, "derived"), both)
    within = scenario_of(Machine(BASE, "derived"), both, known=HEAVY)
    assert held.machine.mass == derived.machine.mass == within.machine.mass == 5000.0
    assert held.actuators["isolator"].flow_gain == within.actuators["isolator"].flow_gain == 1e-6
    assert law_of(held) == law_of(BASE)
    assert law_of(within) == law_of(scenario_of(Machine(BASE, "derived"), HEAVY))
    gains = [np.abs(law_of(one)["D"]).max() for one in (derived, within)]
    assert gains[0] > 1.5 * gains[1]  # which asks a weaker valve for more


def test_one_isolator_by_itself_is_as_the_others_become_but_for_its_own_value() -> None:
    values = {"mount.rear-left.actuator.flow_gain": 1e-6, "actuators.isolator.bulk_modulus": 9e8}
    found = scenario_of(Machine(BASE), values)
    own, others = found.actuators["rear-left"], found.actuators["isolator"]
    assert (own.flow_gain, own.bulk_modulus, others.bulk_modulus) == (1e-6, 9e8, 9e8)
    assert others.flow_gain == BASE.actuators["isolator"].flow_gain
    assert [mount.actuator for mount in found.mount].count("rear-left") == 1


def test_one_isolator_by_itself_begins_with_the_preset_that_all_have() -> None:
    """Twice the area, half the volume and twice K_C, by the paper's section 5."""
    preset = {"actuators.isolator.preset": "recommended"}
    found = scenario_of(Machine(BASE), preset | {"mount.rear-left.actuator.flow_gain": 1e-6}).actuators
    first = BASE.actuators["isolator"]
    assert found["rear-left"].flow_gain == 1e-6
    for one in found.values():
        assert one.piston_area == pytest.approx(2 * first.piston_area, rel=1e-12)
        assert one.chamber_volume == pytest.approx(first.chamber_volume / 2, rel=1e-12)


def test_another_mass_keeps_the_inertia_and_a_footprint_scales_what_is_set_beside_it() -> None:
    found = scenario_of(Machine(BASE), HEAVY | {"mount.0.position.0": 1.0, "footprint.x": 2.0})
    assert found.machine.inertia == BASE.machine.inertia
    places = np.array([mount.position[:2] for mount in found.mount])
    front, rear = places[places[:, 0] > 0, 0], places[places[:, 0] < 0, 0]
    assert front.mean() - rear.mean() == pytest.approx(2.0, rel=1e-12)
    assert front[0] / front[1] == pytest.approx(1.0 / BASE.mount[1].position[0], rel=1e-12)


def test_a_stack_has_the_same_values_as_each_scenario() -> None:
    values = [{"machine.mass": 3500.0, "supply.pressure": 9e6}, {"machine.mass": 4500.0, "supply.pressure": 8e6}]
    stack = designs_of(Machine(BASE), values)
    assert stack.dims == {"design": 2}
    for k, one in enumerate(values):
        own = scenario_of(Machine(BASE), one)
        assert stack.values.common["mass"][k] == own.machine.mass
        assert stack.values.common["pressure"][k] == own.supply.pressure


@pytest.mark.parametrize("key", ["mount.0.actuator.flow_gian", "mount.9.position.0", "machine.weight"])
def test_a_key_that_is_none_is_refused_by_its_name(key: str) -> None:
    with pytest.raises(InputError, match=key.split(".")[-1] if "9" not in key else "mount"):
        scenario_of(Machine(BASE), {key: 1.0})
