"""A plan names the test that tells, says what none tells, and leaves files that the tests can be made with."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ehamj import plan_tests
from ehamj.errors import InputError
from ehamj.identification.planning.outcome import Plan
from ehamj.measured.measured import Measured, MeasuredChannel
from ehamj.plant.mounts import MOUNTS
from ehamj.rig.logger import Tap, logged
from ehamj.run.simulate import observed
from ehamj.scenario.load import changed, load_scenario

SHARE, MEMBRANE, VALVE, BULK = (
    f"actuators.isolator.{name}"
    for name in ("edge_leakage_share", "membrane_stiffness", "valve_frequency", "bulk_modulus")
)
VALVES = {"kind": "valves", "band": [5.0, 60.0], "lines": 8}
LEAK, STATIC = {"kind": "leak-down", "watched": 0.3}, {"kind": "static", "loads": [{"force": 1000.0}]}
COMMON: dict[str, Any] = {"duration": 3.0, "rate": 1000.0}


def asked(*keys: str, **table: Any) -> dict[str, Any]:
    """An identification file that only plans."""
    return {
        "title": "Rig",
        "scenario": "recorded",
        "set": {
            "ground": {"kind": "rest"},
            "control": {"kind": "passive"},
            "sensors": {},
            "compare": [],
            "timestep": 1e-4,
        },
        "parameters": {key: {} for key in keys},
        "plan": COMMON | table,
    }


@pytest.fixture(scope="module")
def plan() -> Plan:
    return plan_tests(asked(SHARE, MEMBRANE, VALVE, candidates=[VALVES, LEAK, STATIC], tests=2))


def test_each_parameter_has_its_test(plan: Plan) -> None:
    """Leakage over the edges is what empties the chambers; a static load feels membranes and never the valve."""
    valves, leak, static = plan.forecasts
    assert plan.best_for(SHARE) is leak
    assert plan.best_for(VALVE) is valves
    assert static.factors[1] > 10.0
    assert static.factors[[0, 2]] == pytest.approx([1.0, 1.0], rel=1e-6)
    assert {step.forecast.trial.kind for step in plan.sequence} == {"valves", "leak-down"}
    assert not plan.untold


def test_a_static_load_tells_the_membranes_as_by_hand() -> None:
    """1000 N on four springs k: strokes F/4k, whose logarithmic slope is as large; each reading is a mean of T·rate
    samples of deviation σ, less another one."""
    noise, rate, stroke = 1e-8, COMMON["rate"], 1000.0 / (4 * 6.8e8)
    channels = [f"stroke {mount}" for mount in MOUNTS]
    table = asked(MEMBRANE, candidates=[STATIC], channels=channels, noise={"stroke": noise})
    (found,) = plan_tests(table).forecasts
    expected = 4 * stroke**2 / (2.0 * noise**2 / rate)
    assert found.information[0, 0] == pytest.approx(expected, rel=1e-3)


def test_the_nonlinear_engine_agrees_on_the_recommended_tests(plan: Plan) -> None:
    last = plan.sequence[-1]
    assert last.nonlinear is not None
    np.testing.assert_allclose(last.nonlinear, last.deviations, rtol=0.1)


def test_what_no_candidate_tells_is_named() -> None:
    found = plan_tests(asked(MEMBRANE, VALVE, candidates=[STATIC]))
    assert list(found.untold) == [VALVE]
    assert found.best_for(VALVE) is None
    assert any(VALVE in answer and "no candidate tells it" in answer for answer in found.answers)


def test_limits_hold_in_the_nonlinear_run(plan: Plan) -> None:
    trial = plan.forecasts[0].trial
    run = observed(trial.scenario.model_copy(update={"engine": "small-motion", "record_rate": 5000.0}))
    own = trial.scenario.plant.actuators[0]
    spool, command = run.dataset["spool"].values, run.dataset["valve_command"].values
    drive = own.valve_frequency**2 * np.abs(own.valve_gain * command - spool)
    late = run.dataset["time"].values >= trial.settle
    assert np.abs(command).max() <= own.voltage_limit
    assert np.abs(spool[late]).max() < own.spool_stroke
    assert 0.7 * own.spool_drive_limit < drive[late].max() < own.spool_drive_limit  # 80 % of it, by the words
    assert "spool_drive_limit" in trial.words


def test_the_folder_holds_what_it_takes_to_make_the_tests(plan: Plan, tmp_path: Path) -> None:
    plan.save(tmp_path)
    numbers = json.loads((tmp_path / "plan.json").read_text())
    assert [one["name"] for one in numbers["sequence"]] == [step.forecast.trial.name for step in plan.sequence]
    (signals,) = tmp_path.glob("*.csv")
    head, *rows = list(csv.reader(signals.open()))
    assert head == ["time [s]", *(f"valve_command {mount} [V]" for mount in plan.machine.plant.mounts)]
    values = np.array(rows, float)
    played = load_scenario(signals.with_suffix(".toml")).commands()
    np.testing.assert_allclose(values[:, 2], played[1].sample(values[:, 0]).value, atol=1e-4)
    assert (tmp_path / "plan.html").is_file()


def test_a_test_that_was_made_counts_for_what_its_measurement_tells() -> None:
    """What a fit to a simulated measurement of 1 % noise says of its deviations was predicted before it was made."""
    channels = ["stroke front-left", "stroke rear-right", "chamber_pressure front-left 1"]
    own = {"duration": 2.0, "rate": 500.0, "channels": channels, "candidates": [VALVES], "tests": 1}
    table = asked(MEMBRANE, BULK, **own)
    before = plan_tests(table)
    (made,) = before.sequence
    run = observed(changed(made.forecast.trial.scenario, {"engine": "small-motion"}))
    log = logged(run, [Tap(channel=name, noise=0.01) for name in channels])
    columns = zip(log.names, log.units, strict=True)
    measured = Measured("made", log.rate, tuple(MeasuredChannel(name, unit, log[name]) for name, unit in columns))
    # The commands are the scenario's own, so that only outputs are measured.
    signals = [one.model_dump() for one in made.forecast.trial.scenario.control.signals]
    driven = {"control": {"kind": "open-loop", "signals": signals}, "duration": 2.0}
    test: dict[str, Any] = {"name": "made", "kind": "record", "rate": 500.0, "settle": 1.0, "set": driven}
    test["measurement"] = {name: {"channel": name, "offset": "free"} for name in channels}
    found = plan_tests({**table, "test": [test], "fit": {"starts": 1}}, measured={"made": measured})
    assert found.done == ("made",)
    np.testing.assert_allclose(found.before, made.deviations, rtol=0.2)
    for one, spread in zip(found.unknowns, found.before, strict=True):
        assert abs(found.at[one.name] - one.start) < 4.0 * spread


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"sharpen": ["machine.mas"]}, "plan.sharpen: 'machine.mas' must be one of"),
        ({"channels": ["strok front-left"]}, "plan.channels: channel 'strok front-left' is unknown"),
        ({"channels": ["ground_velocity front-left z"]}, "an input of a test, not compared"),
        ({"noise": {"spool": 1.0}}, "plan.noise: 'spool' must be one of the channels"),
        ({"candidates": [{**VALVES, "mounts": ["front"]}]}, "mounts: 'front'"),
        ({"candidates": [{**VALVES, "period": 2.0}]}, "period = 2 s: must fit twice into plan.duration = 3 s"),
        ({"candidates": [{"kind": "floor"}]}, "the scenario's floor is at rest"),
    ],
)
def test_what_cannot_be_is_refused(table: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        plan_tests(asked(MEMBRANE, **table))
