"""The replay, written to real files and read back."""

import dataclasses
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader
from scipy.spatial.transform import Rotation

import ehamj
from ehamj import replay
from ehamj.mujoco.model import build_spec
from ehamj.plant.mounts import MOUNTS
from ehamj.replay import attenuation, open_viewer, plots, scene, write_replay
from ehamj.replay.about import page
from ehamj.replay.recording import check_whole, nanoseconds
from ehamj.result import Result


def simulated(**settings: Any) -> Result:
    ground = {"kind": "sine", "dof": "z", "amplitude": 2e-6, "frequency": 10.0}
    return ehamj.simulate(ehamj.parse_scenario({"name": "a floor", "duration": 0.3, "ground": ground, **settings}))


@pytest.fixture(scope="module")
def sliding() -> Result:
    return simulated(plates="sliding")


@pytest.fixture(scope="module")
def tied() -> Result:
    """All six degrees of freedom move."""
    sine = {"kind": "sine", "mounts": ["front-left"], "amplitude": 0.5, "frequency": 13.0}
    return simulated(plates="tied", control={"kind": "open-loop", "signals": [sine]})


def changed(result: Result, rows: int | None = None, **summary: Any) -> Result:
    """The result with fewer rows and another summary."""
    dataset = result.dataset.isel(time=slice(0, rows))
    return dataclasses.replace(result, dataset=dataset, summary=result.summary.changed(**summary))


def entities(path: Path) -> set[str]:
    return {chunk.entity_path for chunk in RrdReader(path).store().stream().to_chunks()}


def read(path: Path, entity: str, component: str) -> tuple[np.ndarray, np.ndarray]:
    """Time stamps [ns] and values of a component over time, (n, …)."""
    stream = RrdReader(path).store().stream().filter(content=entity, has_timeline="sim_time")
    batches = [chunk.to_record_batch() for chunk in stream.to_chunks()]
    times = [batch.column("sim_time").to_numpy(zero_copy_only=False) for batch in batches]
    stamps = np.concatenate(times).astype(np.int64)
    values = np.concatenate([np.array(batch.column(component).to_pylist(), float) for batch in batches])
    order = np.argsort(stamps)
    return stamps[order], values[order]


def text(path: Path, entity: str) -> str:
    (chunk,) = RrdReader(path).store().stream().filter(content=entity).to_chunks()
    return str(chunk.to_record_batch().column("TextDocument:text").to_pylist()[0][0])


def verify(path: Path) -> None:
    done = subprocess.run([sys.executable, "-m", "rerun", "rrd", "verify", str(path)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_times_are_exact_and_scalars_equal(sliding: Result, tmp_path: Path) -> None:
    path = tmp_path / "replay.rrd"
    write_replay(path, {"passive": sliding})
    verify(path)
    data = sliding.dataset
    turned = data.machine_displacement.values[:, 3:4]
    pressure = 1e-5 * data.chamber_pressure.values
    expected = {
        "/plots/vertical/00-ground": 1e6 * data.ground_velocity.values[:, :, 2].mean(axis=1, keepdims=True),
        "/plots/vertical/01-passive": 1e6 * data.cg_velocity.values[:, 2:],
        "/plots/along_x/01-passive": 1e6 * data.cg_velocity.values[:, :1],
        "/plots/roll/01-passive": 1e6 * (turned - turned[0]),
        "/plots/stroke/passive": 1e6 * (data.stroke.values - data.stroke.values[0]),
        "/plots/pressure_1/passive": pressure[:, :, 0],
        "/plots/pressure_2/passive": pressure[:, :, 1],
    }
    for entity, values in expected.items():
        stamps, found = read(path, entity, "Scalars:scalars")
        np.testing.assert_array_equal(stamps, np.arange(301) * 1_000_000)
        np.testing.assert_array_equal(found, values.astype(np.float32))


def test_stamps_are_exact_after_a_minute() -> None:
    for period in (1e-3, 1 / 3000, 0.7e-4):
        k = np.arange(900_000)
        exact = np.array([round(int(i) * period * 1e9) for i in k[-5:]])
        np.testing.assert_array_equal(nanoseconds(k * period)[-5:], exact)
    np.testing.assert_array_equal(nanoseconds(np.arange(60_001) * 1e-3), np.arange(60_001) * 1_000_000)


def test_machine_and_pads_move_as_computed(tied: Result, tmp_path: Path) -> None:
    path = tmp_path / "replay.rrd"
    write_replay(path, {"run": tied}, exaggeration=4000.0)
    stamps, translation = read(path, "/run/world/machine", "Transform3D:translation")
    _, turned = read(path, "/run/world/machine", "Transform3D:quaternion")
    rows = np.round(stamps / 1e6).astype(int)
    assert 1 <= np.diff(rows).max() <= 5, "at least 200 poses per second"
    motion = tied.dataset.machine_displacement.values
    motion = 4000.0 * (motion - motion[0])[rows]
    assert np.abs(motion).max(axis=0)[[2, 3, 4]].min() > 1e-4
    np.testing.assert_allclose(translation[:, 0], motion[:, :3], rtol=1e-6, atol=1e-9)
    # yaw, then rx, then ry, each about the already turned axis
    wanted = Rotation.from_euler("ZXY", motion[:, [5, 3, 4]])
    assert (wanted.inv() * Rotation.from_quat(turned[:, 0])).magnitude().max() < 1e-6
    ground = tied.dataset.ground_displacement.values
    _, pad = read(path, r"/run/world/pad\ rear-left", "Transform3D:translation")
    np.testing.assert_allclose(
        pad[:, 0] - pad[0, 0], 4000.0 * (ground - ground[0])[rows, MOUNTS.index("rear-left")], atol=1e-7
    )


def test_quaternion_is_what_the_engine_makes_of_the_joints() -> None:
    angles = np.array([0.3, -0.2, 0.5])  # rx, ry, rz
    model = mujoco.MjModel.from_xml_path(str(ehamj.mujoco.model.template()))
    data = mujoco.MjData(model)
    for name, angle in zip(("rx", "ry", "rz"), angles, strict=True):
        data.joint(name).qpos = angle
    mujoco.mj_kinematics(model, data)
    np.testing.assert_allclose(scene.quaternion(angles[None])[0], data.body("machine").xquat[[1, 2, 3, 0]], atol=1e-14)


def test_sliding_plates_are_bodies_that_follow_their_stroke(sliding: Result, tmp_path: Path) -> None:
    path = tmp_path / "replay.rrd"
    write_replay(path, {"run": sliding}, exaggeration=1e4)
    stamps, plate = read(path, r"/run/world/plate\ front-left", "Transform3D:translation")
    rows = np.round(stamps / 1e6).astype(int)
    height = sliding.dataset.stroke.values[:, 0] + sliding.dataset.ground_displacement.values[:, 0, 2]
    np.testing.assert_allclose(plate[:, 0, 2] + 0.03, 1e4 * (height - height[0])[rows], atol=1e-7)
    np.testing.assert_allclose(plate[0, 0, :2], (0.9, 0.6), rtol=1e-6)
    assert r"/run/world/plate\ front-left/geoms/plate\ front-left" in entities(path)


def test_tied_plates_are_part_of_the_machine(tied: Result, tmp_path: Path) -> None:
    path = tmp_path / "replay.rrd"
    write_replay(path, {"run": tied})
    found = entities(path)
    assert r"/run/world/machine/geoms/plate\ front-left" in found
    assert not any(name.startswith(r"/run/world/plate") for name in found)
    assert {"/run/world/floor/geoms/floor", "/run/world/machine/geoms/spindle", "/run/world/ghost/bed"} <= found


def test_every_drawn_geom_is_logged(sliding: Result, tmp_path: Path) -> None:
    path = tmp_path / "replay.rrd"
    write_replay(path, {"run": dataclasses.replace(sliding, model_xml="")})  # as if the model had not been stored
    model = build_spec(sliding.scenario.plant, 1e-4, drawn=True).compile()
    assert sum("/geoms/" in name for name in entities(path)) == model.ngeom


def test_two_results_stand_side_by_side(sliding: Result, tied: Result, tmp_path: Path) -> None:
    path = tmp_path / "replay.rrd"
    write_replay(path, {"passive": sliding, "driven / now": tied})
    verify(path)
    found = entities(path)
    assert {"/passive/world/machine", r"/driven\ \/\ now/world/machine"} <= found
    # the same floor, so one line; the louder machine behind the quieter
    loud, quiet = (float(np.std(result.dataset.cg_velocity.values[:, 2])) for result in (tied, sliding))
    order = [r"driven\ \/\ now", "passive"] if loud > quiet else ["passive", r"driven\ \/\ now"]
    wanted = {f"/plots/vertical/{place:02d}-{name}" for place, name in enumerate(["ground", *order])}
    assert {name for name in found if name.startswith("/plots/vertical/")} == wanted
    assert len(RrdReader(path).blueprints()) == 1
    written = text(path, "/about")
    for expected in ("passive", "driven / now", "K_Q", "1.94e-6 m³/s/mA", "identified", "times** larger"):
        assert expected in written


def test_automatic_exaggeration_draws_the_largest_motion_well_visible(sliding: Result, tied: Result) -> None:
    for results in ([sliding], [tied], [sliding, tied]):
        factor = scene.exaggeration_for(results)
        digits = factor / 10.0 ** math.floor(math.log10(factor))
        assert round(digits, 9) in (1.0, 2.0, 5.0)
        ground = np.abs(results[0].dataset.ground_displacement.values[:, :, 2]).max()
        assert 0.06 < factor * ground < 0.2
    assert scene.exaggeration_for([changed(sliding, 1)]) == 1.0


@pytest.mark.parametrize("value", [0.0, -3.0, math.nan, math.inf])
def test_a_useless_exaggeration_is_refused(sliding: Result, tmp_path: Path, value: float) -> None:
    with pytest.raises(ValueError, match="exaggeration"):
        write_replay(tmp_path / "replay.rrd", {"run": sliding}, value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("rows", [0, 1, 40])
def test_incomplete_results_are_shown_as_far_as_they_go(sliding: Result, tmp_path: Path, rows: int) -> None:
    path = tmp_path / "replay.rrd"
    write_replay(path, {"run": changed(sliding, rows, complete=False, failure="it broke"), "whole": sliding})
    verify(path)
    assert "it broke" in text(path, "/about")
    assert "**incomplete**" in text(path, "/about")
    if rows:
        assert len(read(path, "/plots/stroke/run", "Scalars:scalars")[0]) == rows


def test_poses_end_where_numbers_do(sliding: Result, tmp_path: Path) -> None:
    broken = dataclasses.replace(sliding, dataset=sliding.dataset.copy(deep=True))
    broken.dataset["machine_displacement"][100:] = np.nan
    write_replay(tmp_path / "replay.rrd", {"run": broken})
    stamps, translation = read(tmp_path / "replay.rrd", "/run/world/machine", "Transform3D:translation")
    assert stamps.max() < 100_000_000
    assert np.isfinite(translation).all()


def test_attenuation_is_drawn_where_a_summary_has_it(sliding: Result, tmp_path: Path) -> None:
    path = tmp_path / "replay.rrd"
    with_numbers = changed(sliding, attenuation_db={"z": {"1": 20.0, "10": None, "100": -3.0}, "x": {"1": None}})
    write_replay(path, {"a": with_numbers, "b": changed(sliding, attenuation_db={})})
    curves = {name for name in entities(path) if "/curve/" in name}
    assert curves == {"/attenuation/z/curve/a", "/attenuation/z/curve/a/bands"}


def test_attenuation_chart_places_points() -> None:
    curve = attenuation.Curve(np.array([1.0, 10.0, 100.0]), np.array([20.0, np.nan, -3.0]))
    chart = attenuation._Chart.around({"a": curve})
    assert chart == (1.0, 100.0, -10.0, 20.0)
    places = chart.place(curve.frequency, [20.0, 5.0, -10.0])
    np.testing.assert_allclose(places[:, 0], np.array([0.0, 0.5, 1.0]) * attenuation.WIDTH)
    np.testing.assert_allclose(places[:, 1], np.array([0.0, 0.5, 1.0]) * attenuation.HEIGHT)


def test_thinning_keeps_every_peak(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plots, "MOST_ROWS", 100)
    values = np.random.default_rng(3).normal(size=(1001, 2))
    values[537, 1] = 50.0
    stamps, kept = plots.thinned(np.arange(1001) * 1_000_000, values)
    assert len(stamps) == len(kept) <= 102
    assert np.all(np.diff(stamps) > 0)
    np.testing.assert_array_equal(kept.max(axis=0), values.max(axis=0))
    np.testing.assert_array_equal(kept.min(axis=0), values.min(axis=0))
    assert abs(stamps[np.argmax(kept[:, 1])] - 537_000_000) < 25_000_000


def test_a_minute_at_1_khz_is_small(sliding: Result, tmp_path: Path) -> None:
    """Real noise on every channel, so that nothing compresses better than in a real run."""
    rows = 60_001
    noise = np.random.default_rng(1).normal(1.0, 0.1, size=(rows, 1, 1))
    tiled = sliding.dataset.isel(time=np.arange(rows) % sliding.dataset.time.size)
    long = tiled.assign_coords(time=np.arange(rows) * 1e-3)
    long = long.map(lambda channel: channel * noise.reshape((rows,) + (1,) * (channel.ndim - 1)))
    result = dataclasses.replace(sliding, dataset=long)
    path = tmp_path / "replay.rrd"
    write_replay(path, {"run": result})
    assert path.stat().st_size < 60e6
    stamps, _ = read(path, "/plots/vertical/01-run", "Scalars:scalars")
    np.testing.assert_array_equal(stamps, np.arange(rows) * 1_000_000)


def test_nothing_stays_behind(sliding: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    strict = rr.strict_mode()
    path = tmp_path / "replay.rrd"
    write_replay(path, {"run": sliding})
    before = path.read_bytes()
    assert rr.get_global_data_recording() is None
    assert rr.strict_mode() == strict

    def broken(*_: Any, **__: Any) -> None:
        rr.Boxes3D(half_sizes="no sizes")

    monkeypatch.setattr(replay, "log_bar", broken)
    with pytest.raises((ValueError, TypeError)):
        write_replay(path, {"run": sliding})
    assert rr.strict_mode() == strict
    assert [file.name for file in tmp_path.iterdir()] == ["replay.rrd"]
    assert path.read_bytes() == before


def test_what_cannot_be_written_is_an_error(sliding: Result, tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        write_replay(tmp_path / "nowhere" / "replay.rrd", {"run": sliding})
    with pytest.raises(ValueError, match="at least one"):
        write_replay(tmp_path / "replay.rrd", {})


def test_a_truncated_recording_is_an_error(sliding: Result, tmp_path: Path) -> None:
    path = tmp_path / "replay.rrd"
    write_replay(path, {"run": sliding})
    path.write_bytes(path.read_bytes()[:-2000])
    with pytest.warns(match="footer"), pytest.raises(OSError, match="disk full"):
        check_whole(path)


def test_page_speaks_of_what_is_missing_without_nonsense(sliding: Result) -> None:
    written = page({"run": changed(sliding, 1)}, factor=1.0, arrows=0.0, speed=1.0)
    assert "nan" not in written
    assert "Arrows" not in written
    assert "lowest and highest" not in written


def test_page_tells_the_verdicts(sliding: Result) -> None:
    words = {"vertical": "quiet", "horizontal": "loud, undecided at 4, 5 Hz"}
    loudest = {**sliding.summary.criterion.max_1s, "verdict": {"vertical": "less quiet", "horizontal": "louder"}}
    criterion = {**sliding.summary.criterion, "verdict": words, "max_1s": loudest}
    written = page({"run": changed(sliding, criterion=criterion)}, factor=1.0, arrows=0.0, speed=1.0)
    assert "- run, vertical: quiet. Machine worst at " in written
    assert "- run, horizontal: loud, undecided at 4, 5 Hz\n" in written  # nothing moves along x and y: no more is said
    rule = "VC curves, constant acceleration from 4 to 8 Hz"
    assert f"- run, judged by: {rule}, RMS over the whole run\n" in written
    assert "- run, by the largest 1 s RMS: vertical less quiet; horizontal louder\n" in written


def test_page_keeps_to_the_classes_of_what_stands_beside(sliding: Result) -> None:
    written = page({"run": sliding, "other": sliding}, factor=1.0, arrows=0.0, speed=1.0)
    (own,) = re.findall(r"^- run, vertical: (.*)\. Machine worst at .*$", written, re.MULTILINE)
    assert f"\n- other, vertical: {own}\n" in written
    assert "- other, judged by" not in written


def test_page_tells_of_thinned_plots(sliding: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ehamj.replay.about.MOST_ROWS", 100)
    assert "lowest and highest" in page({"run": sliding}, factor=1.0, arrows=0.0, speed=1.0)


def test_viewer_starts_only_where_there_is_a_screen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[list[str]] = []
    monkeypatch.setattr(replay.subprocess, "Popen", lambda command, **_: started.append(command))
    monkeypatch.setattr(replay.sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert open_viewer(tmp_path / "replay.rrd") == "no screen here"
    assert not started
    monkeypatch.setenv("WAYLAND_DISPLAY", "wayland-0")
    assert open_viewer(tmp_path / "replay.rrd") == ""
    (command,) = started
    assert command[command.index("--bind") + 1] == "127.0.0.1"
    assert command[-1] == str(tmp_path / "replay.rrd")
