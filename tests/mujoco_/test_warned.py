"""What MuJoCo warns of reaches the run in our words, and no file of its own the user's folder."""

import ctypes
from dataclasses import replace
from pathlib import Path

import mujoco
import pytest

from ehamj.mujoco import hydraulics
from ehamj.mujoco.hold import library
from ehamj.mujoco.model import build_model
from ehamj.mujoco.warned import warned
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario


def warn(data: mujoco.MjData) -> None:
    """As the engine does where a pivot of the mass matrix vanishes."""
    call = library().mj_warning
    call.argtypes, call.restype = [ctypes.c_void_p, ctypes.c_int, ctypes.c_int], None
    call(data._address, int(mujoco.mjtWarning.mjWARN_INERTIA), 3)


def test_a_warning_is_counted_and_neither_printed_nor_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    data = mujoco.MjData(build_model(parse_scenario({}).plant, 1e-4))
    assert warned(data) is None
    with hydraulics():
        warn(data)
    assert "machine.inertia" in str(warned(data))
    assert not list(tmp_path.iterdir())
    assert capfd.readouterr() == ("", "")


def test_outside_mujoco_warns_as_it_did(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    data = mujoco.MjData(build_model(parse_scenario({}).plant, 1e-4))
    with hydraulics():
        pass
    warn(data)
    assert [path.name for path in tmp_path.iterdir()] == ["MUJOCO_LOG.TXT"]


def test_a_run_that_was_warned_of_is_incomplete(monkeypatch: pytest.MonkeyPatch) -> None:
    from ehamj.run import simulate as running
    from ehamj.run.failures import Incomplete

    before = running.drive

    def drive(prepared, progress=None):  # type: ignore[no-untyped-def]
        driven = before(prepared, progress)
        warn(prepared.data)
        return driven

    monkeypatch.setattr(running, "drive", drive)
    with pytest.raises(Incomplete, match=r"inertia .* is lost .*marked incomplete") as failed:
        simulate(parse_scenario({"duration": 0.01}))
    assert not failed.value.result.complete


def test_what_the_engine_refuses_to_build_names_keys() -> None:
    plant = parse_scenario({}).plant
    light = plant.machine.model_copy(update={"mass": 0.0, "inertia": (0.0, 0.0, 0.0)})
    with pytest.raises(ValueError, match=r"^machine, part, slide, mount, actuators: the engine cannot build them, "):
        build_model(replace(plant, machine=light), 1e-4)
