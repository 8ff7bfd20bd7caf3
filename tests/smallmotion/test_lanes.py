"""Lanes: a run is the same to the bit alone and in company, whatever strikes beside it; memory of lanes; forms."""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

from ehamj.control import PythonController
from ehamj.errors import SimulationFailed
from ehamj.isolator.actuator import OPTIONS, Actuator
from ehamj.run.many import observe_many, simulate_many
from ehamj.run.simulate import observed
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario
from ehamj.smallmotion.isolators import ANY, LAPPED, OPEN, PLAIN, form_of, forms_of
from ehamj.smallmotion.lanes import lane, stacked

MOUNT = "front-left"


@pytest.fixture(autouse=True)
def _one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """All cases come in one batch, however many processors there are."""
    monkeypatch.setattr("ehamj.run.many.processors", lambda: 1)


def small(name: str = "benchmark", duration: float = 0.06, **values: Any) -> Scenario:
    return load_scenario(name).varied({"engine": "small-motion", "duration": duration, **values})


def same(one: xr.Dataset, other: xr.Dataset) -> None:
    assert set(one.data_vars) == set(other.data_vars)
    for name in one.data_vars:
        np.testing.assert_array_equal(one[name].values, other[name].values, err_msg=str(name))


def in_company(cases: list[Scenario]) -> list[xr.Dataset]:
    return observe_many(cases, lambda run: run.dataset)


VALVES = {
    "masses": [{"machine.mass": mass} for mass in (3600.0, 4056.0, 4500.0)],
    "options": [
        {"actuators.isolator.hysteresis": 0.01},
        {"actuators.isolator.threshold": 0.02, "actuators.isolator.null_offset": 0.1},
        {"actuators.isolator.end_stops": True, "actuators.isolator.null_drift": 1.0,
         "actuators.isolator.null_drift_limit": 1.0},
    ],
    "edges": [
        {"actuators.isolator.overlap": [0.1, 0.1, 0.1, 0.1]},
        {"actuators.isolator.overlap": [-0.1, 0.0, 0.2, 0.1]},
        {"actuators.isolator.flow_curve": [[0, 0], [0.5, 0.4], [1, 1]]},
    ],
    "oil": [{"actuators.isolator.air_fraction": 0.001}, {"actuators.isolator.bulk_modulus": 1e9}, {}],
    "books": [{"output.bookkeeping": True, "machine.mass": mass} for mass in (3600.0, 4056.0)],
    "supply": [{"supply.dynamic": True, "supply.pump_flow": flow} for flow in (1e-4, 3e-4)],
}  # fmt: skip


@pytest.mark.parametrize("kind", VALVES)
def test_a_run_is_the_same_in_any_company(kind: str) -> None:
    cases = [small(**values) for values in VALVES[kind]]
    for case, found in zip(cases, in_company(cases), strict=True):
        same(observed(case).dataset, found)


def test_a_run_under_control_is_the_same_in_any_company() -> None:
    """Own floors, own noise, own laws."""
    cases = [
        small("vc-c-floor", seed=seed, **{"machine.mass": 4000.0 + 100.0 * seed, "sensors.ground.noise": 1e-8})
        for seed in range(3)
    ]
    for case, run in zip(cases, simulate_many(cases), strict=True):
        same(observed(case).dataset, run.dataset)


def test_a_fault_strikes_its_own_lane_alone() -> None:
    fault = {"kind": "valve-stuck", "mount": MOUNT, "time": 0.02}
    cases = [small(), small(fault=[fault]), small(fault=[fault | {"time": 0.031}])]
    found = in_company(cases)
    for case, one in zip(cases, found, strict=True):
        same(observed(case).dataset, one)
    assert np.abs(found[1].spool.values - found[0].spool.values).max() > 0.1  # mA: it struck


def test_a_lane_that_fails_says_so_and_the_others_go_on() -> None:
    """The one, with hardly any oil in its chambers, turns too far within a few steps."""
    bad = small(**{"actuators.isolator.chamber_volume": 1e-8, "timestep": 1e-6, "duration": 0.002})
    good = small(timestep=1e-6, duration=0.002)
    said = r"scenario 1 \(benchmark\): simulation failed at .* turned by more than 1 mrad"
    with pytest.raises(SimulationFailed, match=said):
        observe_many([good, bad, good], lambda run: run)
    kept: list[xr.Dataset] = []
    with pytest.raises(SimulationFailed):
        observe_many([good, good, bad], lambda run: kept.append(run.dataset))
    assert kept
    for found in kept:
        same(observed(good).dataset, found)


def test_of_runs_that_step_together_the_first_that_fails_is_named() -> None:
    """The second is refused before anything steps, the first fails in its steps."""
    turns = small(**{"actuators.isolator.chamber_volume": 1e-8, "timestep": 1e-6, "duration": 0.002})
    with pytest.raises(SimulationFailed, match=r"^scenario 0 "):
        observe_many([turns, small(timestep=0.01)], lambda run: run)


def test_a_lane_that_failed_waits_for_no_fault() -> None:
    """The one turns too far long before its fault, the other goes on."""
    leak = {"kind": "chamber-leak", "mount": MOUNT, "time": 0.05, "settling": 0.01}
    rock = {"kind": "sine", "dof": "ry", "amplitude": 5e-3, "frequency": 30.0}
    good, bad = small(fault=[leak]), small(fault=[leak], ground=rock)
    with pytest.raises(SimulationFailed, match="scenario 1"):
        observe_many([good, bad, good, good], lambda run: run)


def test_a_python_law_begins_anew_with_each_run() -> None:
    class Counting:
        def reset(self) -> None:
            self.calls = 0

        def __call__(self, time: float, measured: np.ndarray, limited: np.ndarray) -> np.ndarray:
            self.calls += 1
            return np.full(4, 1e-4 * self.calls)

    law = PythonController(Counting(), [f"stroke {MOUNT}"], period=1e-3)
    first, second = simulate_many([small(), small()], threads=1, controllers=[law, law])
    same(first.dataset, second.dataset)


def test_runs_of_unequal_structure_run_too() -> None:
    cases = [small(), small(duration=0.05), small(record_rate=500.0), small(engine="mujoco"), small(gravity=9.81)]
    lengths = [found.sizes["time"] for found in in_company(cases)]
    assert lengths == [61, 51, 31, 61, 61]


def test_more_runs_than_lanes_come_in_order() -> None:
    cases = [small(duration=0.02, **{"machine.mass": 3000.0 + 100.0 * k}) for k in range(11)]
    found = observe_many(cases, lambda run: run.scenario.machine.mass)
    assert found == [case.machine.mass for case in cases]


# --- memory of lanes, forms ---------------------------------------------------------------------------------------


@settings(max_examples=30)
@given(st.integers(1, 4), st.integers(1, 5), st.integers(1, 8))
def test_lanes_are_last_and_come_back(rows: int, columns: int, width: int) -> None:
    parts = [np.random.default_rng(k).normal(size=(rows, columns)) for k in range(width)]
    flat = stacked(parts)
    assert flat.ndim == 1
    for number, part in enumerate(parts):
        np.testing.assert_array_equal(lane(flat, (rows, columns), width, number), part)


@pytest.mark.parametrize(
    ("values", "form"),
    [
        ({}, PLAIN),
        ({"hysteresis": 0.1}, OPEN),
        ({"overlap": (0.1, 0.1, 0.1, 0.1)}, LAPPED),
        ({"overlap": (0.1, 0.1, 0.1, 0.1), "threshold": 0.1}, LAPPED),
        ({"flow_curve": ((0.0, 0.0), (1.0, 1.0))}, ANY),
        ({"air_fraction": 0.01}, ANY),
    ],
)
def test_the_simplest_form_serves(values: dict[str, Any], form: int) -> None:
    record = Actuator(**values).record()
    assert form_of(record) == form
    assert forms_of([[Actuator().record()], [record]]).tolist() == [form]


def test_every_option_that_is_on_is_seen() -> None:
    """Of an option with its defaults nothing is left out: what is plain has none of them on."""
    usual = Actuator().record()
    for option in OPTIONS:
        for name in option.Values._fields:
            assert form_of(usual | {name: usual[name] + 1.0}) != PLAIN, name
