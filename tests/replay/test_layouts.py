"""What a replay shows of mounts in any direction, of many of them, and of slides."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rerun.chunk import RrdReader
from scipy.spatial.transform import Rotation

import ehamj
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.plant.mounts import DEFAULT_MOUNTS, Mount
from ehamj.replay import write_replay
from ehamj.replay.about import page
from ehamj.replay.marks import MOST_ARROWS, outside, shown_at
from ehamj.replay.modes import replay_modes
from ehamj.replay.plots import mount_groups
from ehamj.replay.recording import MOUNT_COLORS
from ehamj.replay.scene import drawn_model, poses
from ehamj.result import Result
from ehamj.scenario.load import parse_scenario

SKEW = {"name": "skew", "position": [1.0, 0.0, 0.3], "direction": [-1.0, 0.5, 1.0]}
LEVEL = {"name": "level", "position": [0.0, 0.6, 0.7], "direction": [0.0, -1.0, 0.0]}
MACHINE: dict[str, Any] = {
    "duration": 0.3,
    "plates": "sliding",
    "mount": [*(mount.model_dump() for mount in DEFAULT_MOUNTS), SKEW, LEVEL],
    "ground": {
        "kind": "sum", "parts": [{"kind": "sine", "dof": d, "amplitude": 2e-6, "frequency": 9.0} for d in "xyz"],
    },
    "slide": [
        {"name": "table", "mass": 50.0, "position": [0.0, 0.1, 0.8], "rail": [2.0, 0.0, 0.0], "travel": [-0.3, 0.3],
         "profile": {"kind": "moves", "moves": [{"time": 0.05, "to": 0.02}]}},
    ],
}  # fmt: skip
FACTOR = 4000.0


@pytest.fixture(scope="module")
def run() -> Result:
    return ehamj.simulate(parse_scenario(MACHINE))


def upright(count: int) -> list[dict[str, Any]]:
    """Rows of four."""
    return [
        {"name": f"m{k}", "position": [-1.0 + 2.0 * (k // 4) / (count // 4 - 1), -0.6 + 0.4 * (k % 4)]}
        for k in range(count)
    ]


def test_pads_stand_along_their_mounts_and_move_with_the_ground(run: Result) -> None:
    rows = np.arange(0, run.dataset.time.size, 10)
    found = poses(run, drawn_model(run), FACTOR, rows)
    ground = run.dataset.ground_displacement.values
    for name, direction in (("skew", SKEW["direction"]), ("level", LEVEL["direction"])):
        pose, mount = found[f"pad {name}"], run.scenario.plant.mounts.index(name)
        assert pose.quaternion is not None  # written with six digits
        wanted = np.array(direction, float) / np.linalg.norm(np.array(direction, float))
        np.testing.assert_allclose(Rotation.from_quat(pose.quaternion[0]).apply([0.0, 0.0, 1.0]), wanted, atol=1e-5)
        moved = FACTOR * (ground - ground[0])[rows, mount]
        assert np.abs(moved).max(axis=0).min() > 1e-3
        np.testing.assert_allclose(pose.translation - pose.translation[0], moved, atol=1e-12)
    assert found["pad rear-left"].quaternion is None


def test_plates_go_along_with_the_oil_and_across_with_their_feet(run: Result) -> None:
    rows = np.arange(0, run.dataset.time.size, 10)
    found, data = poses(run, drawn_model(run), FACTOR, rows), run.dataset
    for name in ("front-left", "skew", "level"):
        mount = run.scenario.plant.mounts.index(name)
        along = np.array(run.scenario.plant.directions[mount])
        moved = found[f"plate {name}"].translation - found[f"plate {name}"].translation[0]
        stroke, ground, foot = (
            FACTOR * (values - values[0])[rows]
            for values in (
                data.stroke.values[:, mount],
                data.ground_displacement.values[:, mount],
                data.foot_displacement.values[:, mount],
            )
        )
        np.testing.assert_allclose(moved @ along, stroke + ground @ along, atol=1e-12)
        across = np.eye(3) - np.outer(along, along)
        np.testing.assert_allclose(moved @ across, foot @ across, atol=1e-12)


def test_slides_go_as_far_as_they_do_on_the_machine_as_it_is_drawn(run: Result) -> None:
    rows = np.arange(0, run.dataset.time.size, 10)
    found, way = poses(run, drawn_model(run), FACTOR, rows), run.dataset["slide"].values[rows, 0]
    machine, slide = found["machine"], found["slide table"]
    assert machine.quaternion is not None
    own = Rotation.from_quat(machine.quaternion).inv().apply(slide.translation - machine.translation)
    np.testing.assert_allclose(own, np.array([0.0, 0.1, 0.8]) + way[:, None] * [1.0, 0.0, 0.0], atol=1e-12)
    assert way[-1] == pytest.approx(0.02, abs=1e-6)


def test_a_whole_replay_says_what_its_arrows_are(run: Result, tmp_path: Path) -> None:
    write_replay(tmp_path / "replay.rrd", {"run": run})
    logged = {chunk.entity_path for chunk in RrdReader(tmp_path / "replay.rrd").store().stream().to_chunks()}
    assert "/run/world/slide\\ table" in logged
    assert "/run/world/pad\\ level/geoms/post\\ level" in logged
    written = page({"run": run}, factor=1.0, arrows=1.0, speed=1.0)
    assert "velocities along the mounts" in written
    assert "Slides go along their rails" in written
    assert "have arrows" not in written


@pytest.mark.parametrize("count", [3, 8, 9, 32])
def test_plots_show_groups_that_their_colours_tell_apart(count: int) -> None:
    mounts = [f"m{k}" for k in range(count)]
    groups = mount_groups("run", mounts)
    assert [name for group in groups.values() for name in mounts[group]] == mounts
    assert all(1 < len(mounts[group]) <= len(MOUNT_COLORS) for group in groups.values())
    assert len(set(MOUNT_COLORS)) == len(MOUNT_COLORS)
    first, group = next(iter(groups.items()))
    assert first == ("run" if count <= 8 else f"m0 to {mounts[group][-1]} of run")


def test_of_many_mounts_those_farthest_out_have_arrows() -> None:
    plant = parse_scenario({"mount": upright(32)}).plant
    chosen = shown_at(plant)
    assert 4 <= len(chosen) <= MOST_ARROWS
    assert {0, 3, 28, 31} <= set(chosen)  # the corners
    assert shown_at(parse_scenario({}).plant) == (0, 1, 2, 3)


def test_marks_stand_beside_the_outline() -> None:
    size = np.array([2.2, 1.6])
    corners = np.array([mount.place[:2] for mount in DEFAULT_MOUNTS])
    np.testing.assert_allclose(outside(corners, size), np.sign(corners) * (1.2, 0.9))
    np.testing.assert_allclose(outside(np.array([[1.0, 0.1], [0.2, -0.6]]), size), [[1.2, 0.1], [0.2, -0.9]])


def test_modes_of_level_mounts_turn_their_pads(tmp_path: Path) -> None:
    scenario = parse_scenario(MACHINE)
    replay_modes(tmp_path / "modes.rrd", scenario, {"valves held": modes(linear_model(scenario.plant))})
    stream = RrdReader(tmp_path / "modes.rrd").store().stream()
    turns = [
        np.array(batch.column("Transform3D:quaternion").to_pylist(), float).reshape(4)
        for chunk in stream.to_chunks()
        if chunk.entity_path.endswith("/pad\\ level")
        for batch in [chunk.to_record_batch()]
        if "Transform3D:quaternion" in batch.schema.names
    ]
    assert turns
    along = Mount(**LEVEL).along
    for turn in turns:
        np.testing.assert_allclose(Rotation.from_quat(turn).apply([0.0, 0.0, 1.0]), along, atol=1e-6)
