"""Runs in which something fails: the same until then, afterwards what the linear machine with the fault does."""

from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import xarray as xr

from ehamj.judge.faults import NOTHING
from ehamj.mujoco import hydraulics
from ehamj.run.aftermath import linear
from ehamj.run.drive import Driven, drive
from ehamj.run.failures import Incomplete
from ehamj.run.observe import observe
from ehamj.run.prepare import Prepared, prepare
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import Scenario

TIME = 0.60003
"""Of the faults [s]: between two steps."""
AFTER = (1.0, 3.0)
"""When they have settled [s]; each line of the floor has whole periods in half of it."""
LINES = [10.0, 16.0, 25.0, 40.0, 63.0]
"""Of the floor [Hz]; small motions, far from the valves' limits and above their converter's steps."""
FLOOR = {"kind": "multisine", "dof": "z", "frequencies": LINES, "velocities": [5e-6], "wave": {"speed": 200.0}}


def scenario(*faults: dict[str, Any], **tables: Any) -> Scenario:
    placed = [{"mount": "front-left", "time": TIME, "settling": AFTER[0] - TIME, **fault} for fault in faults]
    table = {"duration": AFTER[1], "record_rate": 1000.0, "plates": "tied", "ground": FLOOR}
    table |= {"control": {"kind": "combined"}, "supply": {"tank_pressure": 2e5}}
    return parse_scenario({**table, **tables, "fault": placed})


class Ran(NamedTuple):
    """A run that nobody judged."""

    prepared: Prepared
    driven: Driven
    dataset: xr.Dataset


def ran(one: Scenario) -> Ran:
    with hydraulics():
        prepared = prepare(one, None)
        driven = drive(prepared)
    return Ran(prepared, driven, observe(prepared, driven.rows, driven.struck))


@cache
def intact() -> Ran:
    return ran(scenario())


KINDS: dict[str, dict[str, Any]] = {
    "stuck where it is": {"kind": "valve-stuck"},
    "stuck open": {"kind": "valve-stuck", "opening": 0.05},
    "drift": {"kind": "spool-drift", "rate": 0.4, "limit": 0.3},
    "leak across": {"kind": "chamber-leak", "factor": 5.0},
    "leak to outside": {"kind": "chamber-leak", "path": "outside", "factor": 0.02},
    "branch": {"kind": "supply-lost"},
    "ground dead": {"kind": "sensor-dead", "sensor": "ground"},
    "inertial dead": {"kind": "sensor-dead", "sensor": "inertial"},
    "gain": {"kind": "sensor-gain", "sensor": "ground", "factor": 0.5},
}


@cache
def failed(name: str) -> Ran:
    return ran(scenario(KINDS[name]))


@pytest.mark.parametrize("name", KINDS)
def test_until_the_fault_the_run_is_bit_for_bit_the_one_without(name: str) -> None:
    """And not after it: the fault did something."""
    run, plain = failed(name), intact()
    assert run.prepared.timestep == plain.prepared.timestep
    for channel in plain.dataset.data_vars:
        before = [one.dataset[channel].sel(time=slice(0.0, TIME)).values for one in (run, plain)]
        np.testing.assert_array_equal(*before, err_msg=str(channel))
    moved = [one.dataset["foot_velocity"].sel(time=slice(TIME + 0.01, None)).values for one in (run, plain)]
    assert np.abs(moved[0] - moved[1]).max() > 1e-9


@pytest.mark.parametrize("name", KINDS)
def test_after_the_fault_the_run_does_what_the_linear_machine_does(name: str) -> None:
    """By the heave of the CG at each line; what linear and nonlinear machine leave apart is below 0.3 % of the floor,
    as it is without a fault, and of the rest 3 %."""
    # Edges of a lost branch have no pressure across them, so that what they conduct follows their opening (8 % here),
    # which the linear machine has at null: on a tenth of the floor it is a tenth of that.
    quiet = {"ground": {**FLOOR, "velocities": [5e-7]}, "control": {"kind": "combined", "bits": 40}}
    run = ran(scenario(KINDS[name], **quiet)) if name == "branch" else failed(name)
    found, note = linear(run.prepared, run.driven.struck, run.dataset, AFTER)
    assert found is not None, note
    assert found.stable
    assert set(found.attenuation_db) == {f"{line:g}" for line in LINES}
    for band, expected in found.attenuation_db.items():
        residual, own = (10 ** (-dB / 20) for dB in (expected, found.run_db[band]))
        assert own == pytest.approx(residual, rel=0.03, abs=3e-3), band


def test_a_stuck_spool_stays_exactly_where_it_was() -> None:
    spool = failed("stuck where it is").dataset["spool"].sel(mount="front-left", time=slice(TIME, None)).values
    np.testing.assert_allclose(spool, spool[0], rtol=1e-14)


def test_a_dead_sensor_reads_nothing_or_its_last_value() -> None:
    dead = failed("ground dead").dataset["measured"].sel(sensor="ground_velocity front-left z")
    assert np.any(dead.sel(time=slice(0.0, TIME)))
    assert not np.any(dead.sel(time=slice(TIME + 1e-3, None)))
    kept = ran(scenario({"kind": "sensor-dead", "sensor": "ground", "reads": "last"}, duration=1.1)).dataset
    held = kept["measured"].sel(sensor="ground_velocity front-left z", time=slice(TIME + 1e-3, None)).values
    assert held[0] != 0.0
    np.testing.assert_array_equal(held, held[0])


@pytest.mark.parametrize("dynamic", [False, True])
def test_a_supply_that_is_lost_falls(dynamic: bool) -> None:
    """A constant one to the tank's pressure at once, a dynamic one as its accumulator empties."""
    supply = {"tank_pressure": 2e5, "dynamic": dynamic}
    run = ran(scenario({"kind": "supply-lost", "mount": None}, supply=supply)).dataset
    pressure = run["supply_pressure"].values
    assert pressure[590] > 66e5
    assert pressure[-1] == 2e5 if not dynamic else 10e5 < pressure[-1] < 60e5
    chambers = run["chamber_pressure"].values[-1].mean()
    assert chambers == pytest.approx(0.5 * (pressure[-1] + 2e5), rel=0.05)  # leakage over the edges: in the middle


def test_faults_add_up_and_what_was_judged_between_them_is_judged_once() -> None:
    two = ({"kind": "sensor-gain", "sensor": "ground", "factor": 0.5}, {"kind": "valve-stuck", "time": 1.8})
    run = simulate(scenario(*two[::-1]))  # written in any order
    gain, stuck = run.summary.fault
    assert (gain.kind, stuck.kind) == ("sensor-gain", "valve-stuck")
    assert gain.after is not None
    assert stuck.before is not None
    assert (gain.after.from_s, gain.after.to_s) == (stuck.before.from_s, stuck.before.to_s)
    alone = ran(scenario(two[0]))
    early = {"time": slice(0.0, 1.799)}
    np.testing.assert_array_equal(run.dataset["stroke"].sel(early), alone.dataset["stroke"].sel(early))


def test_the_resolved_scenario_runs_again_to_the_same_result(tmp_path: Path) -> None:
    path = tmp_path / "scenario.toml"
    path.write_text(failed("leak to outside").prepared.scenario.to_toml(), encoding="utf-8")
    again = ran(load_scenario(path))
    np.testing.assert_array_equal(again.dataset["stroke"], failed("leak to outside").dataset["stroke"])


def test_a_sensor_that_is_not_read_is_named() -> None:
    passive = ran(scenario({"kind": "sensor-dead"}, control={"kind": "passive"}, duration=0.7)).prepared
    assert any("does not read sensor = 'inertial'" in text for text in passive.notes)


def test_a_reversed_sensor_does_not_run_away_unnoticed() -> None:
    """The loop that it closes is unstable, and the valves reach their limits."""
    run = simulate(scenario({"kind": "sensor-gain", "sensor": "inertial", "factor": -3.0}))
    found = run.summary.fault[0]
    assert found.expected is not None
    assert not found.expected.stable
    said = " ".join(run.summary.warnings)
    assert f"the loop is unstable: {found.expected.pole}" in said
    assert "commands are at their limit" in said


def test_the_step_follows_the_machine_that_a_fault_makes() -> None:
    """A worn seal makes the chambers a hundred times as fast; a stated step that is too long for them fails the run."""
    quick = ran(scenario({"kind": "chamber-leak"}, duration=0.61)).prepared
    assert quick.timestep < 0.5 * intact().prepared.timestep
    assert any("the step is" in text for text in quick.notes)
    with pytest.raises(Incomplete, match=r"ran empty.*; step 0\.0001 s"):
        simulate(scenario({"kind": "chamber-leak"}, timestep=1e-4))


def test_a_run_that_ends_before_it_settles_says_so_and_what_it_would_come_to() -> None:
    """The linear machine is that of a run long enough; what is needed is what the part after takes to be judged."""
    summary = simulate(scenario({"kind": "valve-stuck", "settling": 2.0}, duration=1.6)).summary
    (found,) = summary.fault
    assert found.after is None
    assert found.expected is not None
    whole = failed("stuck where it is")
    known, _ = linear(whole.prepared, whole.driven.struck, whole.dataset, AFTER)
    assert known is not None
    near = set(found.expected.attenuation_db) & set(known.attenuation_db)
    assert near
    for band in near:  # windows of other lengths: they leak otherwise
        assert found.expected.attenuation_db[band] == pytest.approx(known.attenuation_db[band], abs=0.3)
    assert found.settled_s == pytest.approx(TIME + 2.0, abs=1e-3)
    assert found.needed_s is not None
    said = summary.lines()[f"after the fault at front-left at {found.time_s:g} s"]
    assert said.startswith("not settled, it would be judged from 2.6 s on; at least ")
    assert f"(duration = {found.needed_s:g} s)" in said
    assert "the linear machine with the fault settles to" in said
    assert "by itself" in summary.lines()["judged by"]


@pytest.mark.parametrize("fault", [{"kind": "valve-stuck"}, {"kind": "sensor-dead"}])
def test_a_fault_that_changes_nothing_is_said_to(fault: dict[str, Any]) -> None:
    """It is said of runs only that are bit for bit the one without it."""
    passive: dict[str, Any] = {"control": {"kind": "passive"}, "duration": 1.2}
    run, plain = simulate(scenario(fault, **passive)), simulate(scenario(**passive))
    for channel in plain.dataset.data_vars:
        np.testing.assert_array_equal(run.dataset[channel], plain.dataset[channel], err_msg=str(channel))
    assert run.summary.fault[0].idle
    assert run.summary.lines() == plain.summary.lines()
    assert any(f"{NOTHING}" in text for text in run.summary.warnings)


def test_a_fault_that_changes_something_is_not_said_to_change_nothing() -> None:
    for moving in ({"kind": "valve-stuck", "opening": 0.05}, {"kind": "spool-drift", "rate": 0.4}):
        run = simulate(scenario(moving, control={"kind": "passive"}, duration=1.2))
        assert not run.summary.fault[0].idle
        assert run.summary.mixed
