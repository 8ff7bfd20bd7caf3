"""Crossings that are chosen under stated margins: on several machines, and how requirements move them."""

from typing import Any

import numpy as np
import pytest

from ehamj.control.architectures.modal import ModalSettings
from ehamj.control.kinds import CombinedSettings
from ehamj.design.tuning import tune
from ehamj.errors import InputError
from ehamj.linear.loop import Loop
from ehamj.linear.machine import linear_model
from ehamj.linear.margins import report
from ehamj.linear.modes import modes
from ehamj.plant.levers import MOTIONS
from ehamj.plant.plant import Plant
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.synthesis.judged import Design
from ehamj.synthesis.requirements import Requirements, Variations, machines_of, with_factors

HEAVY = {"machine": {"mass": 6000.0, "cg": [0.0, 0.0, 1.1], "inertia": [4000.0, 5000.0, 6000.0]}}
LIGHT = {"machine": {"mass": 2500.0, "cg": [0.0, 0.0, 0.6], "inertia": [1200.0, 1800.0, 2400.0]}}
UNEVEN = {"machine": {"mass": 5200.0, "cg": [0.1, 0.05, 0.8]}}
RECOMMENDED = {"actuators": {"isolator": {"preset": "recommended"}}}
MODAL = {"kind": "modal", "delay": 1.5e-4}


def tuned(table: dict[str, Any], control: dict[str, Any] = MODAL, **wanted: float) -> Design:
    scenario = parse_scenario({"plates": "tied", "control": control, **table})
    return tune(scenario, machines_of(scenario.plant), Requirements.model_validate(wanted))


def crossings(design: Design) -> list[float]:
    assert isinstance(design.settings, ModalSettings)
    return [getattr(design.settings, motion).crossing for motion in MOTIONS]


@pytest.fixture(scope="module")
def standard() -> Design:
    return tuned({})


def assert_holds(design: Design, gain: float = 6.0, phase: float = 45.0, disk: float = 0.5) -> None:
    assert design.meets
    assert len(design.reports) == 6
    for name, one in design.reports.items():
        assert one.stable, name
        assert one.worst[0] >= gain, name
        assert one.worst[1] >= phase, name
        assert one.worst[2] >= disk, name


def test_on_the_default_machine_all_margins_are_left(standard: Design) -> None:
    assert_holds(standard)


def test_something_binds(standard: Design) -> None:
    worst = np.min([one.worst for one in standard.reports.values()], axis=0)
    # Steps of 3 % in each crossing are 0.26 dB of gain and about a degree of phase.
    spare = worst - [6.0, 45.0, 0.5]
    assert spare[0] < 0.3 or spare[1] < 1.5 or spare[2] < 0.03


@pytest.mark.parametrize("table", [LIGHT, UNEVEN | RECOMMENDED], ids=["light", "uneven, recommended"])
def test_on_other_machines_too(table: dict[str, Any]) -> None:
    design = tuned(table)
    assert_holds(design)
    assert min(crossings(design)) > 10.0


def test_damping_of_sway_stands_at_the_machine_s_own_modes_however_often_it_is_tuned() -> None:
    scenario = parse_scenario({"plates": "tied", "control": MODAL, **HEAVY})
    machines = machines_of(scenario.plant)
    first = tune(scenario, machines)
    assert_holds(first)
    once = first.settings
    twice = tune(scenario.model_copy(update={"control": once}), machines).settings
    assert isinstance(once, ModalSettings)
    assert isinstance(twice, ModalSettings)
    assert (twice.sway_x, twice.sway_y) == (once.sway_x, once.sway_y)
    found = {mode.name: mode.frequency for mode in modes(machines["as designed"])}
    assert once.sway_x.centre == pytest.approx(found["sway-rocking about y"], rel=0.15)
    assert once.sway_y.centre == pytest.approx(found["sway-rocking about x"], rel=0.15)


def test_stricter_margins_lower_every_crossing(standard: Design) -> None:
    strict = tuned({}, gain_margin=10.0)
    assert_holds(strict, gain=10.0)
    assert all(low < high for low, high in zip(crossings(strict), crossings(standard), strict=True))


@pytest.mark.parametrize("wanted", [{"gain_margin": 45.0}, {"phase_margin": 88.0}, {"disk_margin": 1.8}])
def test_margins_that_cannot_be_left_are_refused(wanted: dict[str, float]) -> None:
    with pytest.raises(InputError, match=r"control: no crossing.* leaves? "):
        tuned({}, **wanted)


@pytest.mark.parametrize("kind", ["skyhook", "stroke-servo"])
def test_loops_at_each_mount_are_tuned_too(kind: str) -> None:
    assert_holds(tuned({}, {"kind": kind, "delay": 1.5e-4}))


def test_of_a_combination_the_loop_is_tuned_and_the_rest_kept() -> None:
    parts = [{"kind": "feedforward", "gain": 0.9}, {"kind": "modal"}]
    design = tuned({}, {"kind": "combined", "delay": 1.5e-4, "parts": parts})
    assert_holds(design)
    settings = design.settings
    assert isinstance(settings, CombinedSettings)
    assert settings.delay == 1.5e-4
    feedforward, modal = settings.parts
    assert feedforward.model_dump()["gain"] == 0.9
    assert isinstance(modal, ModalSettings)
    assert modal.heave.crossing != ModalSettings().heave.crossing


@pytest.mark.parametrize(
    "control",
    [{"kind": "feedforward"}, {"kind": "combined", "parts": [{"kind": "modal"}, {"kind": "skyhook"}]}],
    ids=["none", "two"],
)
def test_one_loop_can_be_tuned_neither_none_nor_two(control: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="there must be one loop to tune"):
        tuned({}, control)


# --- the machines -------------------------------------------------------------------------------------------------


def test_variations_change_one_thing_each() -> None:
    plant = parse_scenario({}).plant
    found = dict(Variations(mass=(0.7,), oil=(0.5,), flow=(1.5,), cg=(0.2,), all=(0.9,)).plants(plant))

    def facts(one: Plant) -> tuple[float, ...]:
        actuator, inertia = one.actuators[0], np.diag(one.machine.tensor)
        return (one.machine.mass, actuator.bulk_modulus, actuator.flow_gain, *one.machine.cg, *inertia)

    base = facts(plant)
    changes = {name: [k for k, value in enumerate(facts(one)) if value != base[k]] for name, one in found.items()}
    assert list(changes.values()) == [[], [0, 6, 7, 8], [1], [2], [3, 4], [0, 1, 2, 6, 7, 8]]
    assert facts(found["mass × 0.7"])[0] == pytest.approx(0.7 * base[0])


def test_a_rated_valve_s_flow_gain_is_varied_with_its_rating() -> None:
    plant = parse_scenario({"actuators": {"isolator": {"rated_flow": 4e-5}}}).plant
    ratio = with_factors(plant, flow=1.5).actuators[0].flow_gain / plant.actuators[0].flow_gain
    assert ratio == pytest.approx(1.5)


@pytest.mark.parametrize("factors", [{"mass": 0.7}, {"mass": 1.3}, {"oil": 0.5}, {"flow": 1.5}], ids=str)
def test_the_default_law_keeps_its_margins_on_the_varied_machine(factors: dict[str, float]) -> None:
    sensors = {"inertial": {"kind": "geophone"}}
    scenario = parse_scenario({"plates": "tied", "sensors": sensors, "control": MODAL})
    law = scenario.controller()
    assert law is not None
    varied = linear_model(with_factors(scenario.plant, **factors))
    gain, phase, disk = report(varied, Loop.of(scenario, law)).worst
    assert gain >= 6.0
    assert phase >= 45.0
    assert disk >= 0.5


def test_factors_and_shifts_are_those_of_the_machine_with_all_that_is_on_it() -> None:
    scenario = load_scenario("moving-slide", ["part=[{name='workpiece', mass=500.0, position=[0.3, 0.1, 1.0]}]"])
    plant = scenario.plant
    heavier = with_factors(plant, mass=1.3)
    (_, shifted) = dict(Variations(mass=(), oil=(), flow=(), cg=(0.02,), all=()).plants(plant)).values()
    for places in ({}, {"table": 0.3}):  # with the slide where it starts, and elsewhere
        base, more, off = (one.locked(places).machine for one in (plant, heavier, shifted))
        assert more.mass == pytest.approx(1.3 * base.mass, rel=1e-12)
        np.testing.assert_allclose(more.tensor, 1.3 * base.tensor, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(np.subtract(off.cg, base.cg), [0.02, 0.02, 0.0], atol=1e-12)
