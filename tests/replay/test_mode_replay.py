"""The replay of modes, written to a file and read back."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from harness import Cli
from rerun.chunk import RrdReader
from scipy.spatial.transform import Rotation

from ehamj.errors import InputError
from ehamj.linear.loop import Loop
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.replay import modes as drawn
from ehamj.replay.modes import replay_modes, swing
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario
from ehamj.studies.position_loop import inertial_position

MACHINE = parse_scenario({"name": "a machine", "plates": "tied"})
TALL = parse_scenario(
    {
        "name": "tall",
        "machine": {"cg": [0.0, 0.0, 1.4]},
        "actuators": {"isolator": {"preset": "elastic-mount"}},
    }
)


def swings(scenario: Scenario) -> dict[str, drawn.Swing]:
    found = [mode for mode in modes(linear_model(scenario.plant)) if mode.machine_moves]
    return {mode.name: swing(scenario.machine, mode) for mode in found}


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("modes") / "modes.rrd"
    model, loop = linear_model(MACHINE.plant), Loop.of(MACHINE, inertial_position(MACHINE.plant, 80.0))
    replay_modes(path, MACHINE, {"valves held": modes(model), "closed loop": modes(model, loop)})
    return path


def read(path: Path, entity: str, component: str) -> tuple[np.ndarray, np.ndarray]:
    """Viewing times [s] and values of a component, (n, …)."""
    stream = RrdReader(path).store().stream().filter(content=entity, has_timeline=drawn.TIMELINE)
    batches = [chunk.to_record_batch() for chunk in stream.to_chunks()]
    stamps = np.concatenate([b.column(drawn.TIMELINE).to_numpy(zero_copy_only=False).astype(np.int64) for b in batches])
    values = np.concatenate([np.array(batch.column(component).to_pylist(), float) for batch in batches])
    order = np.argsort(stamps)
    return 1e-9 * stamps[order], values[order][:, 0]


def test_the_file_is_whole_and_shows_every_mode_of_every_variant(recording: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "rerun", "rrd", "verify", str(recording)], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    paths = {chunk.entity_path for chunk in RrdReader(recording).store().stream().to_chunks()}
    for name in swings(MACHINE):
        for page in ("all", "valves held", "closed loop"):
            scene = f"{page} - {name}".replace(" ", "\\ ")
            assert f"/{scene}/world/machine" in paths
            assert f"/{scene}/world/ghost/bed" in paths


def test_the_machine_swings_as_the_shape_says(recording: Path) -> None:
    """Rotation and translation of the steady picture are the real shape times one cosine, four swings long."""
    one = swings(MACHINE)["rocking about y"]
    times, moved = read(recording, r"/all\ -\ rocking\ about\ y/world/machine", "Transform3D:translation")
    _, turned = read(recording, r"/all\ -\ rocking\ about\ y/world/machine", "Transform3D:quaternion")
    pitch = Rotation.from_quat(turned).as_rotvec()[:, 1]
    assert times[-1] == pytest.approx(drawn.LENGTH)
    assert pitch == pytest.approx(pitch[0] * np.cos(2 * np.pi * drawn.SWINGS * times / drawn.LENGTH), abs=2e-3)
    ratio = (one.shape[0] / one.shape[4]).real
    assert moved[:, 0] == pytest.approx(ratio * pitch, abs=2e-3)
    assert np.abs(moved[:, 1]).max() < 1e-6


def test_the_axis_is_where_nothing_moves(recording: Path) -> None:
    """Points of the drawn axis stay where they are in the small motion; and so does the drawn one, to second order."""
    one = swings(MACHINE)["rocking about y"]
    assert one.axis is not None
    point, direction = one.axis
    for place in (point, point + 0.7 * direction):
        moved = one.shape[:3] + np.cross(one.shape[3:], place)
        assert np.abs(moved).max() < 0.05 * np.abs(one.shape[:3]).max()  # the rest is out of phase
    assert np.abs(direction) == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)


def test_nothing_is_drawn_too_large() -> None:
    points = np.array([(x, y, z) for x in (-1.1, 1.1) for y in (-0.8, 0.8) for z in (0.5, 1.9)])
    for scenario in (MACHINE, TALL):
        for name, one in swings(scenario).items():
            factor = drawn.drawn_scale(scenario.plant, one, points)
            moved = factor * np.abs(one.shape[:3] + np.cross(one.shape[3:], points))
            lifted = [
                factor * abs(one.shape[2] + y * one.shape[3] - x * one.shape[4]) for x, y, _ in scenario.plant.positions
            ]
            largest = max(float(moved.max()) / drawn.LARGEST, max(lifted) / drawn.FOOT_LARGEST)
            assert largest == pytest.approx(1.0), name


def test_variants_ring_down_on_one_clock(recording: Path) -> None:
    """Each curve decays with its own damping, at the pace of the first variant's frequency."""
    held = swings(MACHINE)["heave"]
    times, curve = read(recording, "/ringing/heave/0-valves\\ held", "Scalars:scalars")
    decay = np.exp(-2 * np.pi * held.damping_ratio * times)
    swung = np.cos(2 * np.pi * np.sqrt(1 - held.damping_ratio**2) * times)
    assert curve == pytest.approx(decay * swung, abs=1e-6)
    _, closed = read(recording, "/ringing/heave/1-closed\\ loop", "Scalars:scalars")
    assert np.abs(closed[200:]).max() < np.abs(curve[200:]).max()


def test_views_are_named_by_frequency_and_damping() -> None:
    assert swings(MACHINE)["heave"].title == "heave: 528 Hz, damping 9.8 %"


def test_a_machine_that_does_not_swing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not swing"):
        replay_modes(tmp_path / "no.rrd", MACHINE, {"valves held": []})
    assert list(tmp_path.iterdir()) == []


def test_the_command_writes_it_and_refuses_bad_names(cli: Cli, tmp_path: Path) -> None:
    path = tmp_path / "m.rrd"
    arguments = ["modes", "benchmark", "--replay", str(path), "--json"]
    assert cli(*arguments).json["replay"] == str(path)
    RrdReader(path).store()
    before = path.stat().st_mtime_ns
    assert "exists already" in cli(*arguments).message
    assert path.stat().st_mtime_ns == before
    for bad, words in ((tmp_path / "m.txt", "must end in .rrd"), (tmp_path / "none" / "m.rrd", "is no folder")):
        assert words in cli("modes", "--replay", str(bad)).message
