"""Both engines side by side: what they compute, how they fail, and what a result says of its engine.

The whole campaign (every shipped scenario under its own and every standard control, 3 s at 52 bits, 120 runs) was run
once: 84 of them agree to 1e-6 of the larger of each channel's peak and its floor (`ehamj.verify.small_motion.FLOORS`),
all to `SECOND_ORDER` turns of their variable's; the differences of the rest fall as the square of the floor's motion.
16 s of `stuck-valve`, whose fault comes at 12 s, agree to 4e-7. As shipped, bits of the converters flip; played the
same commands, the engines agree to 7e-8 where they are 1e-3 apart without.
"""

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from harness import SKEW_MOUNTS, Cli

from ehamj.control import PythonController
from ehamj.errors import InputError
from ehamj.result import load_result
from ehamj.run.failures import Incomplete
from ehamj.run.simulate import Observed, observed, simulate
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import Scenario
from ehamj.verify.conservation import imbalance
from ehamj.verify.setup import ALL_OPTIONS, SHARED_SUPPLY, open_loop, sines
from ehamj.verify.small_motion import apart, on_small_motions

FIRST_ORDER = 1e-6
"""What two exact solutions of one machine may differ by: rounding, and the matrices' central differences."""
SECOND_ORDER = 3.0
"""Of what a variable's channels do, per radian that the machine turns: forces act on levers as they were (θ), and what
they cause is up to three times as large."""


def with_engines(scenario: Scenario) -> list[Scenario]:
    return [scenario, on_small_motions(scenario)]


def both(scenario: Scenario, controller: Any = None) -> tuple[Observed, Observed]:
    return observed(scenario, controller), observed(on_small_motions(scenario), controller)


def turn(run: Observed) -> float:
    angles = run.dataset["machine_displacement"].values[:, 3:]
    return float(np.abs(angles - angles[0]).max())


def agree(one: Observed, other: Observed) -> None:
    assert one.prepared.timestep == other.prepared.timestep
    for name, (_, difference) in apart(one.dataset, other.dataset).items():
        assert difference <= FIRST_ORDER + SECOND_ORDER * turn(one), name
    limits, drawn = (run.driven.tally.limits for run in (one, other))
    for name in limits.dtype.names:
        np.testing.assert_array_equal(limits[name], drawn[name], err_msg=name)


FLOOR = {
    "kind": "sum",
    "parts": [
        {"kind": "sine", "dof": dof, "amplitude": size, "frequency": hertz, "fade_in": 0.05}
        for dof, size, hertz in (("x", 3e-6, 9.0), ("y", 2e-6, 14.0), ("z", 5e-6, 23.0), ("rx", 1e-6, 12.0))
    ],
}
LAW = {"kind": "combined", "bits": 52, "parts": [{"kind": "feedforward"}, {"kind": "modal"}]}
BASE: dict[str, Any] = {
    "plates": "tied", "duration": 0.2, "ground": FLOOR, "control": open_loop(*sines(1.0, (13.0, 17.0, 23.0, 29.0)))
}  # fmt: skip
SLIDE = {
    "name": "table", "mass": 800.0, "position": [0.1, 0.05, 0.9], "rail": [1.0, 0.3, 0.2], "travel": [-0.5, 0.5],
    "profile": {"kind": "moves", "moves": [{"time": 0.05, "to": 0.1, "speed": 0.4, "acceleration": 3.0, "jerk": 60.0}]},
}  # fmt: skip
SOFT = {"foot_stiffness": 1e9, "foot_damping": 1e4}
FAULTS: dict[str, dict[str, Any]] = {
    "valve-stuck": {}, "spool-drift": {}, "chamber-leak": {}, "supply-lost": {"mount": None}, "sensor-dead": {},
    "sensor-gain": {},
}  # fmt: skip


def fault(kind: str) -> dict[str, Any]:
    struck = {"kind": kind, "time": 0.0737, "mount": "front-left", **FAULTS[kind]}
    return {"control": LAW, "fault": [{key: value for key, value in struck.items() if value is not None}]}


CASES: dict[str, dict[str, Any]] = {
    "every option": {"actuators": {"isolator": ALL_OPTIONS}, "supply": SHARED_SUPPLY},
    "elastic feet": {"plates": "sliding", "actuators": {"isolator": SOFT}},
    "sliding plates": {"plates": "sliding"},
    "a slide": {"slide": [SLIDE]},
    "a force": {
        "force": [
            {"kind": "sine", "point": [0.3, 0.2, 1.0], "direction": [1, 0.5, 1], "amplitude": 500.0, "frequency": 40.0}
        ]
    },
    "skew mounts": {
        "mount": SKEW_MOUNTS, "actuators": {"isolator": {"chamber_volume": 5e-3}},
        "control": open_loop(*sines(0.3, (13.0, 17.0, 23.0, 29.0, 31.0), [mount["name"] for mount in SKEW_MOUNTS])),
    },
    "a delay between steps": {"control": {**LAW, "delay": 1.3e-4}},
    "no delay": {"control": {**LAW, "delay": 0.0}},
    "noise": {
        "control": LAW,
        "sensors": {"ground": {"kind": "geophone"}, "inertial": {"kind": "geophone"}, "stroke": {}, "pressure": {}},
    },
    **{kind: fault(kind) for kind in FAULTS},
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_both_engines_compute_the_same(name: str) -> None:
    agree(*both(parse_scenario({**BASE, **CASES[name]})))


@pytest.mark.parametrize("delay", [0.0, 1.5e-4])
def test_python_laws_see_and_do_the_same(delay: float) -> None:
    def law(time: float, measured: np.ndarray, limited: np.ndarray) -> np.ndarray:
        return np.array([1.0, -0.5, 0.3, 0.2]) * np.sin(300.0 * time) + np.array([20.0, 20.0, -10.0, 5.0]) * measured[0]

    controller = PythonController(law, ["foot_velocity front-left z", "stroke rear-left"], bits=None, delay=delay)
    agree(*both(parse_scenario({**BASE, "control": {"kind": "passive"}}), controller))


def test_as_shipped_levels_are_the_same() -> None:
    # One bit of 16 that flips is 7e-5 of a command: 0.05 dB in any band that is louder than 0.1 µm/s.
    scenario = load_scenario("recorded").varied({"plates": "tied", "duration": 3.0, "compare": []})
    summaries = [simulate(each).summary for each in with_engines(scenario)]
    one, other = (summary.third_octave_velocity["machine"] for summary in summaries)
    compared = 0
    for axis, levels in one.items():
        for band, level in levels.items():
            if level is not None and level > 1e-7:
                assert 20.0 * abs(np.log10(other[axis][band] / level)) <= 0.05, (axis, band)
                compared += 1
    assert compared > 10


def test_bits_that_flip_are_all_that_parts_the_engines_as_shipped() -> None:
    # Of 15 shipped scenarios the loudest bands that differ by more than 0.05 dB are in this one, at 30 nm/s.
    course = {"plates": "tied", "duration": 1.5, "compare": [], "record_rate": 1e4}
    scenario = load_scenario("vc-c-floor").variant("skyhook").varied(course)
    one, other = both(scenario)
    law, commands = one.prepared.controller, one.dataset["valve_command"].values
    assert law is not None
    part = law.parts[0]
    rounded = np.abs(commands - other.dataset["valve_command"].values) / law.converter.resolution
    np.testing.assert_allclose(rounded, np.round(rounded), rtol=0, atol=1e-6)
    assert 0.0 < np.mean(rounded > 0.5) < 0.1
    assert rounded.max() < 1.5
    ahead = round(part.latency / part.period)

    def played(time: float, measured: np.ndarray, limited: np.ndarray) -> np.ndarray:
        return commands[min(round(time / part.period) + ahead, len(commands) - 1)]

    player = PythonController(played, (), period=part.period, delay=part.latency, bits=None)
    alike = observed(on_small_motions(scenario), player)
    np.testing.assert_array_equal(alike.dataset["valve_command"], commands)
    for name in ("machine_velocity", "foot_velocity", "stroke_velocity", "spool", "chamber_pressure"):
        values = one.dataset[name].values
        apart_now, apart_before = (np.abs(run.dataset[name].values - values).max() for run in (alike, other))
        assert apart_now <= (FIRST_ORDER + SECOND_ORDER * turn(one)) * np.abs(values).max(), name
        assert apart_now < 0.02 * apart_before, name


def test_a_machine_that_may_fall_falls_alike() -> None:
    nudge = {"kind": "shock", "dof": "ry", "velocity": 1e-2, "pulse_time": 0.05, "return_time": 0.2, "begin": 0.01}
    isolator = {"isolator": {"preset": "pneumatic-mount"}}
    course = {"duration": 3.0, "record_rate": 200.0, "ground": nudge, "may_fall": True}
    machine = {"cg": [0.0, 0.0, 12.0], "size": [2.2, 1.6, 14.0]}
    table = {**BASE, **course, "machine": machine, "actuators": isolator, "control": {"kind": "passive"}}
    one, other = both(parse_scenario(table))
    agree(one, other)
    assert 3e-5 < turn(one) < 1e-3
    for each in with_engines(parse_scenario({**table, "may_fall": False})):
        with pytest.raises(InputError, match=r"^mount: the machine cannot stand.*may_fall = true"):
            simulate(each)


def test_what_is_left_out_falls_as_the_square_of_the_motion() -> None:
    def difference(scale: float) -> np.ndarray:
        scenario = load_scenario("press-shop").variant("passive")
        one, other = both(scenario.varied({"plates": "tied", "duration": 1.0, "ground.scale": scale}))
        names = ("machine_velocity", "foot_acceleration", "stroke_velocity")
        return np.array([np.abs(one.dataset[name].values - other.dataset[name].values).max() for name in names])

    np.testing.assert_allclose(np.log2(difference(2.0) / difference(1.0)), 2.0, atol=0.05)


def test_the_ledger_balances_as_on_the_other_engine() -> None:
    # What is missing is what RK4 loses where the oil tears: of one step on both engines, so the same.
    isolator = {"vapour_pressure": 5e3}
    table = {**BASE, "actuators": {"isolator": isolator}, "output": {"bookkeeping": True}, "supply": {"pressure": 20e5}}
    blow = {"kind": "shock", "velocity": 0.3, "pulse_time": 0.015, "begin": 0.05}
    one, other = (simulate(each) for each in with_engines(parse_scenario({**table, "ground": blow})))
    assert other.dataset["chamber_void"].values.max() > 0.0
    np.testing.assert_allclose(imbalance(other), imbalance(one), rtol=0.05)


# failures


def failed(scenario: Scenario, controller: Any = None) -> Incomplete:
    with pytest.raises(Incomplete) as caught:
        simulate(scenario, controller=controller)
    kept = caught.value.result
    assert not kept.complete
    assert kept.summary["failure"] == str(caught.value)
    assert all(np.isfinite(values).all() for values in kept.dataset.data_vars.values())
    return caught.value


def breaks(time: float, measured: np.ndarray, limited: np.ndarray) -> np.ndarray:
    if time > 0.02:
        raise ZeroDivisionError("by nothing")
    return np.zeros(4)


STEP = {"kind": "open-loop", "signals": [{"kind": "step", "mounts": ["rear-left"], "amplitude": 10.0}]}
WILD = {"isolator": {"valve_frequency": 3e4, "spool_drive_limit": np.inf}}
FAILURES: dict[str, tuple[dict[str, Any], Callable[..., Any] | None]] = {
    "an empty chamber": ({"timestep": 2e-3, "record_rate": 500, "control": STEP, "ground": {"kind": "rest"}}, None),
    "only voids kept it bounded": ({"timestep": 1e-3, "control": STEP, "ground": {"kind": "rest"}}, None),
    "a spool beyond all numbers": (
        {"timestep": 1e-3, "actuators": WILD, "control": STEP, "ground": {"kind": "rest"}},
        None,
    ),
    "a law that raises": ({"control": {"kind": "passive"}}, breaks),
    "a law without numbers": ({"control": {"kind": "passive"}}, lambda *_: [np.nan, 0.0, 0.0, 0.0]),
}


@pytest.mark.parametrize("name", FAILURES)
def test_what_fails_fails_alike(name: str) -> None:
    table, function = FAILURES[name]
    law = None if function is None else PythonController(function, ("stroke front-left",))
    one, other = (failed(each, law) for each in with_engines(parse_scenario({**BASE, "duration": 0.1, **table})))
    assert str(one) == str(other)
    assert one.result.dataset.sizes == other.result.dataset.sizes
    assert repr(one.__cause__) == repr(other.__cause__)


TILTING = {"kind": "sine", "dof": "ry", "amplitude": 2e-3, "frequency": 3.0, "fade_in": 0.2}


def test_a_turn_that_is_not_small_ends_the_run_with_the_way_out() -> None:
    scenario = parse_scenario({**BASE, "ground": TILTING})
    whole = observed(scenario).dataset
    large = np.abs(whole["machine_displacement"].values[:, 3:]).max(axis=1) > 1e-3
    when = float(whole["time"][np.argmax(large)])  # of 1 kHz; a step is shorter
    error = failed(on_small_motions(scenario))
    assert float(str(error).split()[3]) == pytest.approx(when, abs=1e-3)
    last = float(error.result.dataset["time"][-1])
    assert f"is no small motion. Kept until {last:g} s, marked incomplete. engine = 'mujoco' follows any turn" in str(
        error
    )
    assert np.abs(error.result.dataset["machine_displacement"].values[:, 3:]).max() <= 1e-3


# where people look


def test_the_command_line_chooses_the_engine_and_the_result_keeps_it(cli: Cli) -> None:
    own = ("--set", "duration=0.05", "--no-replay", "--no-report", "--out", "run")
    said = cli("run", "benchmark", "--engine", "small-motion", *own)
    assert said.code == 0
    assert "on the small-motion engine" in said.out
    result = load_result("run")
    assert result.scenario.engine == result.summary.timing.engine == "small-motion"
    assert tomllib.loads(Path("run/scenario.toml").read_text(encoding="utf-8"))["engine"] == "small-motion"


def test_another_engine_is_refused_by_name(cli: Cli) -> None:
    assert (
        cli("run", "benchmark", "--engine", "drake").message == "engine = 'drake': must be 'mujoco' or 'small-motion'"
    )


def test_a_failing_run_exits_with_3_and_keeps_its_rows(cli: Cli) -> None:
    Path("tilting.toml").write_text(tomli_w.dumps({**BASE, "ground": TILTING}), encoding="utf-8")
    said = cli("run", "tilting.toml", "--engine", "small-motion", "--no-replay", "--no-report", "--out", "run")
    assert said.code == 3
    assert "it turned by more than 1 mrad" in said.err
    assert load_result("run").summary["complete"] is False
