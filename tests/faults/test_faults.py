"""What a fault makes of a plant, and what is refused."""

import re
from typing import Any

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.faults import FAULTS
from ehamj.judge.faults import FaultFound
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import Scenario

SPOOLS = np.array([1.5, -3.0, 30.0, 0.0])  # mA; the third has run beyond its full stroke of 20


def with_fault(**table: object) -> Scenario:
    return parse_scenario({"duration": 10.0, "fault": [{"mount": "front-right", "time": 1.0, **table}]})


def test_every_kind_has_its_name() -> None:
    kinds = ("valve-stuck", "spool-drift", "chamber-leak", "supply-lost", "sensor-dead", "sensor-gain")
    assert tuple(kind.model_fields["kind"].annotation.__args__[0] for kind in FAULTS) == kinds


@pytest.mark.parametrize(("mount", "share"), [("front-right", -0.15), ("rear-left", 1.0)])
def test_a_valve_sticks_where_it_is_and_no_further_than_its_stroke(mount: str, share: float) -> None:
    scenario = with_fault(kind="valve-stuck", mount=mount)
    struck = scenario.fault[0].after(scenario.plant, SPOOLS)
    own = struck.actuators[struck.mounts.index(mount)]
    assert (own.spool_stuck, own.spool_stuck_at) == (True, share)
    assert [a.spool_stuck for a in struck.actuators].count(True) == 1


def test_a_leak_across_the_piston_keeps_the_leakage_of_the_edges() -> None:
    scenario = with_fault(kind="chamber-leak", factor=40.0)
    intact, worn = scenario.plant.actuators[1], scenario.fault[0].after(scenario.plant, SPOOLS).actuators[1]
    assert worn.edge_leakage == pytest.approx(intact.edge_leakage, rel=1e-12)
    assert worn.edge_leakage + worn.cross_leakage == pytest.approx(40.0 * intact.flow_pressure, rel=1e-12)


def test_a_leak_to_outside_has_a_conductance_of_its_own() -> None:
    scenario = with_fault(kind="chamber-leak", path="outside", chamber=2)
    leaking = scenario.fault[0].after(scenario.plant, SPOOLS).actuators[1]
    assert (leaking.outside_leakage_1, leaking.outside_leakage_2) == (0.0, pytest.approx(0.05 * 6.6e-11))


def test_a_drift_ends_at_its_bound() -> None:
    scenario = with_fault(kind="spool-drift", rate=-0.2, limit=0.5)
    offsets = [
        scenario.fault[0].settled(scenario.plant, SPOOLS, after).actuators[1].null_offset for after in (0.0, 1.0, 9.0)
    ]
    assert offsets == pytest.approx([0.0, -0.2, -0.5])


def test_a_drift_begins_where_that_of_the_actuator_itself_is() -> None:
    drift = {"kind": "spool-drift", "mount": "front-right", "time": 1.0}
    own = {"null_drift": -0.01, "null_drift_limit": 2.0, "null_offset": 0.5}
    scenario = parse_scenario({"actuators": {"isolator": own}, "fault": [drift]})
    struck = scenario.fault[0].after(scenario.plant, SPOOLS).actuators[1]
    assert struck.null_offset == pytest.approx(0.49)


def test_a_drift_begins_where_an_earlier_one_ended() -> None:
    drift = {"kind": "spool-drift", "mount": "front-right", "rate": -0.5, "limit": 1.0}
    scenario = parse_scenario({"fault": [{**drift, "time": 1.0}, {**drift, "time": 3.0, "rate": 0.2}]})
    first, second = scenario.fault
    own = second.after(first.after(scenario.plant, SPOOLS), SPOOLS).actuators[1]
    assert (own.null_offset, own.null_drift, own.null_drift_from, own.null_drift_limit) == (-1.0, 0.2, 3.0, 1.0)
    with pytest.raises(InputError, match=r"fault\.1\.time = 2\.9 s: the null at front-right drifts until 3 s already"):
        parse_scenario({"fault": [{**drift, "time": 1.0}, {**drift, "time": 2.9}]})


def test_a_branch_or_all_lose_the_supply() -> None:
    one, all_four = with_fault(kind="supply-lost"), parse_scenario({"fault": [{"kind": "supply-lost", "time": 1.0}]})
    assert one.fault[0].after(one.plant, SPOOLS).cut_off == ("front-right",)
    assert all_four.fault[0].after(all_four.plant, SPOOLS).cut_off == all_four.plant.mounts


CHANNELS = (
    "ground_velocity front-right z",
    "foot_velocity front-right z",
    "foot_velocity rear-left z",
    "cg_velocity z",
)


@pytest.mark.parametrize(
    ("sensor", "struck"),
    [("ground", CHANNELS[:1]), ("inertial", CHANNELS[1:2]), ("stroke", ()), (CHANNELS[1], CHANNELS[1:2])],
)
def test_sensors_of_a_class_at_a_mount_fail(sensor: str, struck: tuple[str, ...]) -> None:
    assert with_fault(kind="sensor-dead", sensor=sensor).fault[0].struck(CHANNELS) == struck


def test_a_channel_needs_no_mount() -> None:
    fault = parse_scenario({"fault": [{"kind": "sensor-gain", "sensor": "cg_velocity z", "time": 1.0}]}).fault[0]
    assert fault.struck(CHANNELS) == ("cg_velocity z",)
    assert fault.where == "cg_velocity z"


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"kind": "rust"}, "fault.0.kind = 'rust': must be one of 'valve-stuck'"),
        (
            {"kind": "valve-stuck", "mount": "front"},
            "no mount has this name: 'front' in fault.0.mount; did you mean 'front-left'? [[mount]] has front-left",
        ),
        ({"kind": "valve-stuck", "time": 10.0}, "fault.0.time = 10 s must be before the end, duration = 10 s"),
        ({"kind": "valve-stuck", "opening": 1.2}, "fault.0.opening = 1.2"),
        ({"kind": "spool-drift", "rate": 0.0}, "rate = 0 mA/s must not be zero"),
        ({"kind": "chamber-leak", "path": {}}, "fault.0.path = {}: must be 'piston' or 'outside'"),
        ({"kind": "sensor-dead", "sensor": "nose"}, "fault.0.sensor = 'nose': must be one of ground, inertial"),
        (
            {"kind": "sensor-dead", "sensor": "foot_velocity front z"},
            "no mount has this name: 'front' in fault.0.sensor",
        ),
        ({"kind": "sensor-dead", "sensor": "cg_velocity w"}, "near it are"),
        ({"kind": "sensor-dead", "sensor": "cg_velocity z"}, "fault.0.mount = 'front-right' is not that of sensor"),
    ],
)
def test_what_is_wrong_is_named(table: dict[str, object], said: str) -> None:
    with pytest.raises(InputError) as refused:
        with_fault(**table)
    assert said in str(refused.value)


def test_a_class_of_sensors_needs_a_mount() -> None:
    with pytest.raises(InputError, match="mount is missing"):
        parse_scenario({"fault": [{"kind": "sensor-dead", "time": 1.0}]})


def test_the_shipped_scenario_says_what_is_true_whenever_its_fault_strikes() -> None:
    early = load_scenario("stuck-valve", ["fault.0.time=3.0"])
    assert not re.search(r"\d+ s\b", early.description)


def test_a_fault_in_words_names_the_spool_and_no_code() -> None:
    none: dict[str, Any] = {"before": None, "during": None, "after": None, "expected": None}
    found = FaultFound(
        kind="valve-stuck", where="front-left", time_s=3.0, what="the valve sticks where it is", opening=-0.013,
        channels=[], **none,
    )  # fmt: skip
    words = "at 3 s at front-left: the valve sticks where it is (at −1.3 % of the spool's stroke)"
    assert found.in_words() == words
