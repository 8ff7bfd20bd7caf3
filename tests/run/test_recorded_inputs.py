"""What a logger wrote drives the model as what it was written of."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.records.choices import Reading
from ehamj.records.picked import Pick, read_picked
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario, parse_scenario

RATE, DELAY = 2000.0, 0.004
TIME = np.arange(0.0, 0.3, 1 / RATE)
VOLTS = 0.05 * np.sin(2 * np.pi * 40.0 * TIME)
NEWTONS = 200.0 * np.sin(2 * np.pi * 30.0 * TIME)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    rows = (f"{7.0 + t:.6f},{1e3 * u:.12g},{1e-3 * f:.12g}" for t, u, f in zip(TIME, VOLTS, NEWTONS, strict=True))
    (tmp_path / "drive.csv").write_text("\n".join(["time [s],U [mV],F [kN]", *rows, ""]))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def driven(signal: dict[str, Any], force: dict[str, Any], **table: Any) -> dict[str, Any]:
    control = {"kind": "open-loop", "signals": [{"mounts": ["front-left"], **signal}]}
    pushed = {"point": [0.5, 0.0, 0.9], **force}
    return {"duration": 0.1, "record_rate": 2000.0, "plates": "tied", "control": control, "force": [pushed], **table}


def recorded(component: str, **more: Any) -> dict[str, Any]:
    return {"kind": "recorded", "file": "drive.csv", "component": component, **more}


@pytest.mark.parametrize("engine", ["mujoco", "small-motion"])
def test_a_recorded_sine_drives_as_the_sine(engine: str) -> None:
    """From 0.1 s on in the file, 4 ms later, and with the sign of the force turned: phases by hand."""
    since = 0.1 - DELAY
    sine = {"kind": "sine", "amplitude": 0.05, "frequency": 40.0, "phase": 2 * np.pi * 40.0 * since}
    push = {"kind": "sine", "amplitude": -200.0, "frequency": 30.0, "phase": 2 * np.pi * 30.0 * 0.1}
    exact = simulate(parse_scenario(driven(sine, push, engine=engine))).dataset
    replayed = driven(recorded("U", start=0.1, delay=DELAY), recorded("F", start=0.1, scale=-1.0), engine=engine)
    found = simulate(parse_scenario(replayed)).dataset
    for name in ("spool", "stroke_velocity", "machine_velocity"):
        size = float(np.abs(exact[name]).max())
        np.testing.assert_allclose(found[name], exact[name], atol=1e-5 * size)


def test_held_samples_jump_where_the_file_has_them() -> None:
    scenario = parse_scenario(driven(recorded("U", hold="held"), recorded("F", hold="straight")))
    command = scenario.commands()[0]
    at = np.array([0.0123, 0.0150001])
    np.testing.assert_allclose(command.sample(at).value, VOLTS[[24, 30]], rtol=1e-9)
    assert not scenario.commands()[1].sample(at).value.any()
    push = scenario.load().sample(at)[0][:, 2]
    np.testing.assert_allclose(push, np.interp(at, TIME, NEWTONS), rtol=1e-9)


WRONG = {
    "too long": (driven(recorded("U", start=0.25), recorded("F")), ["control.signals.0.start = 0.25", "0.1 s", "0.3"]),
    "before it begins": (driven(recorded("U"), recorded("F", start=-1.0)), ["force.0.start = -1 s", "from 0 to 0.3 s"]),
    "another kind": (driven(recorded("F"), recorded("F")), ["control.signals.0: 'F'", "'kN'", "V, mV"]),
    "unit of another kind": (driven(recorded("U"), recorded("F", unit="V")), ["force.0.unit = 'V'", "kN"]),
    "not there": (driven(recorded("U"), recorded("G")), ["force.0.component = 'G'", "'U', 'F'"]),
    "which": (
        driven({"kind": "recorded", "file": "drive.csv"}, recorded("F")),
        ["control.signals.0.component is missing", "'U', 'F'"],
    ),
    "no file": (driven(recorded("U"), recorded("F") | {"file": "no.csv"}), ["force.0.file = 'no.csv'", "No such file"]),
    "full scale": (driven(recorded("U", full_scale=2.0), recorded("F")), ["control.signals.0.full_scale", "*.wav"]),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_cannot_drive_is_refused_by_its_key(what: str) -> None:
    table, told = WRONG[what]
    with pytest.raises(InputError) as error:
        simulate(parse_scenario(table))
    for part in told:
        assert part in str(error.value)
    assert "ground." not in str(error.value)


def test_a_file_is_read_once_and_again_when_it_is_another(folder: Path) -> None:
    pick = Pick("force.0", "force", "force", "F")

    def samples() -> np.ndarray:
        return read_picked(Path("drive.csv"), (pick,), Reading(), "force.0")[0].samples

    first = samples()
    assert samples() is first
    (folder / "drive.csv").write_text((folder / "drive.csv").read_text().replace("[kN]", "[N]"))
    np.testing.assert_allclose(samples(), first / 1e3)


def test_the_scenario_that_was_run_names_its_file_from_anywhere(
    folder: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = parse_scenario(driven(recorded("U"), recorded("F"))).to_toml()
    (folder / "mine.toml").write_text(text)
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    found = load_scenario(folder / "mine.toml")
    np.testing.assert_allclose(found.commands()[0].sample(TIME[:50]).value, VOLTS[:50], atol=1e-12)
