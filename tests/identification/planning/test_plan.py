"""A plan names the test that tells, says what none tells, and leaves files that the tests can be made with."""

import csv
import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from harness import Cli

from ehamj import identify, plan_tests
from ehamj.errors import InputError
from ehamj.identification.planning.outcome import Plan
from ehamj.plant.mounts import MOUNTS
from ehamj.rig.logger import Tap, logged
from ehamj.run.simulate import observed
from ehamj.scenario.load import load_scenario

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


def test_a_fit_to_the_recommended_test_states_the_deviations_that_were_predicted(tmp_path: Path) -> None:
    """The folder's test is run, a logger of 1 % noise writes its file, and its plan.toml identifies from that."""
    channels = ["stroke front-left", "stroke rear-right", "chamber_pressure front-left 1"]
    short = {**VALVES, "period": 0.5}
    own = {"duration": 1.0, "rate": 500.0, "channels": channels, "candidates": [short], "tests": 1}
    before = plan_tests(asked(MEMBRANE, BULK, **own))
    before.save(tmp_path)
    (made,) = before.sequence
    file = tmp_path / "plan.toml"
    (test,) = tomllib.loads(file.read_text())["test"]
    run = observed(load_scenario((tmp_path / test["file"].replace("-measured.csv", ".toml")), ["engine=small-motion"]))
    driving, seen = (Tap(channel=name, bits=None) for name in made.forecast.trial.inputs), channels
    logged(run, [*driving, *(Tap(channel=name, noise=0.01) for name in seen)]).save(tmp_path / test["file"])
    found = identify(file, overrides=["fit.starts=1"])
    for key, spread, true in zip(before.keys, made.deviations, before.at.values(), strict=True):
        one = found.values[key]
        assert one.value is not None
        assert one.deviation == pytest.approx(spread, rel=0.2)
        assert abs(one.value - true) < 4.0 * spread
    again = plan_tests(file, overrides=["fit.starts=1"])  # the same again sharpens by √2
    assert again.done == (made.forecast.trial.name,)
    np.testing.assert_allclose(again.before, [found.values[key].deviation for key in again.keys], rtol=0.05)
    np.testing.assert_allclose(again.forecasts[0].factors, np.sqrt(2.0), rtol=0.1)


def test_the_command_says_the_plan_and_writes_it(cli: Cli, tmp_path: Path) -> None:
    file, out = tmp_path / "rig.toml", tmp_path / "plan"
    file.write_text(tomli_w.dumps(asked(MEMBRANE, VALVE, candidates=[STATIC])))
    told = cli("identify", str(file), "--plan", "--out", str(out))
    assert told.code == 0
    assert f"{VALVE}: no candidate tells it" in told.out
    numbers = json.loads((out / "plan.json").read_text())
    assert numbers["untold"].keys() == {VALVE}
    (static,) = numbers["candidates"]
    assert f"static loads {static['factors'][MEMBRANE]:.3g}" in " ".join(told.out.split())
    assert "or ask which to make: --plan" in cli("identify", str(file)).message


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
