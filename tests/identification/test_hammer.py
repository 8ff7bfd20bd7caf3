"""Blows of a hammer on the simulated machine, as a logger writes them, tell the machine that was hit."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ehamj
from ehamj.errors import InputError
from ehamj.plant.mounts import MOUNTS
from ehamj.run.many import observe_many
from ehamj.scenario.load import changed

HITS = {"x": (0.9, 0.6, 1.5), "y": (-0.9, 0.6, 1.5)}
"""Where it was hit, by the direction [m]."""
START = {"machine.inertia.2": 3600.0, "machine.cg.2": 0.75, "actuators.isolator.lateral_stiffness": 2e8}
TRUTH = {"machine.inertia.2": 3100.0, "machine.cg.2": 0.85, "actuators.isolator.lateral_stiffness": 1.7e8}
MACHINE = (
    'plates = "tied"\n[machine]\ninertia = [2400.0, 3000.0, 3600.0]\n[actuators.isolator]\nlateral_damping = 4e4\n'
)
FELT = [f"{mount} {axis}" for mount in MOUNTS[:2] for axis in "xyz"]
CORNERS = {"far": (-1.0, -0.7, 1.8), "near": (1.0, -0.7, 1.8)}
RATE, APART, BLOWS = 5000.0, 0.35, 3
Logs = dict[str, dict[str, np.ndarray]]


def table(folder: Path) -> dict[str, Any]:
    """An identification of what hits in x and y tell: two feet, and accelerometers on two upper corners."""
    measured: dict[str, Any] = {"F": {"force": {}}}
    measured |= {name: {"channel": f"foot_acceleration {name}"} for name in FELT}
    measured |= {
        f"{name} {axis}": {"accelerometer": {"point": place, "direction": [float(axis == one) for one in "xyz"]}}
        for name, place in CORNERS.items()
        for axis in "xy"
    }
    hits = [
        {"file": str(folder / f"{axis}.csv"), "point": place, "direction": [float(axis == one) for one in "xyz"]}
        for axis, place in HITS.items()
    ]
    return {
        "scenario": str(folder / "machine.toml"),
        "parameters": {key: {"bounds": [0.6 * value, 1.4 * value]} for key, value in START.items()},
        "test": [{"name": "blows", "kind": "hammer", "hit": hits, "measurement": measured, "band": [10.0, 300.0]}],
        "fit": {"starts": 1},
    }


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Logs:
    """Three blows along x and three along y, with noise of 1 % of the largest value on all channels."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "machine.toml").write_text(MACHINE)
    machine = changed(ehamj.load_scenario(folder / "machine.toml").varied(TRUTH), {"control": {"kind": "passive"}})
    duration = 0.05 + BLOWS * APART
    machine = changed(machine, {"points": CORNERS, "record_rate": RATE, "duration": duration})
    time = np.arange(round(duration * RATE) + 1) / RATE
    pulses = sum(2000.0 * np.exp(-0.5 * ((time - 0.04 - APART * k) / 8e-4) ** 2) for k in range(BLOWS))
    np.savetxt(
        folder / "blows.csv", np.column_stack([time, pulses]), delimiter=",", header="time [s],F [N]", comments=""
    )
    blow = {"kind": "recorded", "file": str(folder / "blows.csv"), "component": "F"}
    cases = [
        changed(machine, {"force": [blow | {"point": place, "direction": [float(axis == one) for one in "xyz"]}]})
        for axis, place in HITS.items()
    ]
    random, found = np.random.default_rng(3), {}
    for axis, run in zip(HITS, observe_many(cases, lambda run: run), strict=True):
        feet, points = run.dataset["foot_acceleration"], run.dataset["point_acceleration"]
        clean = {"F": pulses}
        clean |= {name: feet.sel(mount=name[:-2], axis=name[-1]).values for name in FELT}
        clean |= {f"{name} {along}": points.sel(point=name, axis=along).values for name in CORNERS for along in "xy"}
        size = min(map(len, clean.values()))
        found[axis] = {
            name: one[:size] + 0.01 * np.abs(one).max() * random.standard_normal(size) for name, one in clean.items()
        }
    return found


def written(folder: Path, logs: Logs) -> dict[str, Any]:
    (folder / "machine.toml").write_text(MACHINE)
    for axis, channels in logs.items():
        rows = np.column_stack([np.arange(len(channels["F"])) / RATE, *channels.values()])
        head = ",".join(["time [s]", *(f"{name} [{'N' if name == 'F' else 'm/s^2'}]" for name in channels)])
        np.savetxt(folder / f"{axis}.csv", rows, fmt="%.7g", delimiter=",", header=head, comments="")
    return table(folder)


def test_blows_tell_stiffness_inertia_and_centre_of_gravity(logs: Logs, tmp_path: Path) -> None:
    found = ehamj.identify(written(tmp_path, logs))
    for key, value in TRUTH.items():
        one = found.values[key]
        assert one.value is not None
        assert one.deviation is not None
        assert abs(one.value - value) < 3.5 * one.deviation, key
        assert one.deviation < 0.015 * value
    (noisy,) = [note for note in found.notes if "makes all modes wrong together" in note]
    assert noisy.startswith("test 'blows': force F at ")
    modes = found.tests[0].found
    assert "blows at 2 places, 10 motions" in modes["method"]
    paired = [pair for pair in modes["after"]["modes"] if pair["name"]]
    assert len(paired) == 3
    assert min(pair["mac_of_close_modes"] or pair["mac"] for pair in paired) > 0.98


def test_a_sensor_that_is_turned_or_exchanged_is_named(logs: Logs, tmp_path: Path) -> None:
    first = FELT[0]
    turned = {axis: one | {first: -one[first]} for axis, one in logs.items()}
    with pytest.raises(InputError, match=f"foot_acceleration {first} is the wrong way round"):
        ehamj.identify(written(tmp_path, turned))
    swapped = {axis: one | {"far x": one["far y"], "far y": one["far x"]} for axis, one in logs.items()}
    with pytest.raises(InputError, match="acceleration far x and acceleration far y are exchanged"):
        ehamj.identify(written(tmp_path, swapped))


def test_what_shows_no_blows_is_refused(logs: Logs, tmp_path: Path) -> None:
    size = round((0.04 + 0.8 * APART) * RATE)
    once = {axis: {name: one[:size] for name, one in channels.items()} for axis, channels in logs.items()}
    with pytest.raises(InputError, match="shows 1 blow; 2 at a place are needed"):
        ehamj.identify(written(tmp_path, once))
    steady = {axis: one | {"F": np.cos(np.arange(len(one["F"])))} for axis, one in logs.items()}
    with pytest.raises(InputError, match="is it the hammer's channel"):
        ehamj.identify(written(tmp_path, steady))
    asked = written(tmp_path, logs)
    for key, value, said in (
        ("point", "spindle-nos", r"hit\.1\.point = 'spindle-nos': did you mean 'spindle-nose'\? must be one of"),
        ("point", [900.0, 600.0, 1500.0], r"test\.0\.hit\.1\.point"),
        ("file", str(tmp_path / "z.csv"), r"test\.0\.hit\.1\.file = 'z.csv' cannot be read"),
    ):
        wrong = written(tmp_path, logs)
        wrong["test"][0]["hit"][1][key] = value
        with pytest.raises(InputError, match=said):
            ehamj.identify(wrong)
    asked["test"] = [{"name": "r", "kind": "record", "file": str(tmp_path / "x.csv"),
                      "measurement": asked["test"][0]["measurement"]}]  # fmt: skip
    with pytest.raises(InputError, match=r"far x\.accelerometer: is of kind = 'hammer' only"):
        ehamj.identify(asked)
