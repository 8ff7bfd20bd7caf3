"""Channels that are dead, clipped, reversed, of another unit or clock are named before anything is fitted."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ehamj
from ehamj.errors import InputError
from ehamj.identification.checks import undriven
from ehamj.identification.file import IdentifyFile, load_identify
from ehamj.measured.measured import Measured, MeasuredChannel
from ehamj.plant.mounts import MOUNTS
from ehamj.result import Result
from ehamj.rig.logger import Tap, logged
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario, parse_scenario

MACHINE: dict[str, Any] = {"plates": "tied", "compare": [], "engine": "small-motion", "timestep": 2e-4}
SIGNALS = [
    {"kind": "multisine", "mounts": [mount], "amplitude": 0.1, "frequencies": [5.0 + k, 21.0 + k, 47.0 + k],
     "phases": [1.0, 2.0, 4.0]}
    for k, mount in enumerate(MOUNTS)
]  # fmt: skip
TEST = {"duration": 0.6, "record_rate": 500.0, "control": {"kind": "open-loop", "signals": SIGNALS}}
KEYS = ("actuators.isolator.flow_gain", "machine.mass", "actuators.isolator.lateral_stiffness")
TRUE = dict(zip(KEYS, (2.3e-6, 3100.0, 1.2e8), strict=True))
S, P = "stroke front-left", "chamber_pressure rear-right 1"
V, X, Y = "foot_velocity front-right z", "foot_velocity rear-left x", "foot_velocity front-left y"


@pytest.fixture(scope="module")
def run() -> Result:
    """A machine a fifth beside the one that is believed, measured."""
    return simulate(parse_scenario({**MACHINE, **TEST}).varied(TRUE))


def asked(run: Result, folder: Path, wrong: dict[str, dict[str, Any]], **fit: Any) -> IdentifyFile:
    """What is asked of its file, of which some channels are wrong."""
    taps = [
        Tap(channel=name, name=name.replace(" ", "_"), noise=0.01, **wrong.get(name, {})) for name in (S, P, V, X, Y)
    ]
    logged(run, taps, seed=3).save(folder / "test.csv")
    (folder / "rig.toml").write_text(parse_scenario(MACHINE).to_toml(), encoding="utf-8")
    measurement = {tap.title: {"channel": tap.channel} for tap in taps}
    record = {"name": "sweep", "kind": "record", "file": str(folder / "test.csv"), "measurement": measurement}
    table = {
        "scenario": str(folder / "rig.toml"), "parameters": {key: {} for key in KEYS}, "fit": {"starts": 1, **fit},
        "test": [{**record, "rate": 500.0, "set": TEST}],
    }  # fmt: skip
    return load_identify(table)


def test_dead_and_clipped_channels_are_all_named(run: Result, tmp_path: Path) -> None:
    limit = float(run.dataset["chamber_pressure"].sel(mount="rear-right", chamber=1).quantile(0.9))
    file = asked(run, tmp_path, {S: {"dead": True}, P: {"full_scale": limit}})
    with pytest.raises(InputError) as told:
        ehamj.identify(file)
    first, second = str(told.value).splitlines()
    assert f"test.0.measurement.stroke_front-left: stroke_front-left ({S}) has " in first
    assert 'dead, or its range is far too wide; leave it out, or state accept = ["coarse"]' in first
    assert f"({P}) is clipped" in second


def test_units_signs_and_clocks_are_all_named_before_anything_is_fitted(run: Result, tmp_path: Path) -> None:
    said: list[str] = []
    wrong = {S: {"unit": "mm", "head": "m"}, P: {"gain": -1.0}, V: {"delay": 0.03}}
    with pytest.raises(InputError) as told:
        ehamj.identify(asked(run, tmp_path, wrong), progress=said.append)
    lines = str(told.value).splitlines()
    assert said[-1] == "looking at the channels"
    assert [line.split(" ", 2)[2].split(" is ")[0].split(" comes ")[0] for line in lines[:3]] == [S, P, V]
    assert "times as large as the model has it, as if mm were taken for m: state its unit" in lines[0]
    assert "its sign is reversed (scale = -1 turns it)" in lines[1]
    assert "ms too late: clocks are not synchronised" in lines[2]
    assert lines[3] == '(fit.doubtful = "note" fits them all the same)'


def test_a_doubtful_channel_may_be_fitted_and_a_clock_that_is_a_little_off_is_told(run: Result, tmp_path: Path) -> None:
    found = ehamj.identify(asked(run, tmp_path, {Y: {"gain": -1.0}, V: {"delay": 0.002}}, doubtful="note"))
    said = [note for note in found.notes if Y in note or V in note]
    turned = "is the wrong way round: its sign is reversed (scale = -1 turns it)"
    assert said[0] == f"test 'sweep', beside the machine that was found: {Y} {turned}"
    assert any(f"{V}: comes 2" in note and note.endswith("ms too late beside the others; let its delay be free")
               for note in said)  # fmt: skip
    for key, true in TRUE.items():
        assert found.values[key].value == pytest.approx(true, rel=0.01)


def test_valves_whose_commands_are_left_out_are_told() -> None:
    def record(*names: str) -> Measured:
        return Measured("sweep", 1000.0, tuple(MeasuredChannel(name, "V", np.zeros(9), "input") for name in names))

    machine, commands = load_scenario("recorded"), [f"valve_command {mount}" for mount in MOUNTS]
    (said,) = undriven(machine, {"sweep": record(*commands[:3])})
    assert said.startswith(f"test 'sweep': {commands[3]}: not in its measurement")
    assert undriven(machine, {"all": record(*commands), "hammer": record("force F")}) == []
