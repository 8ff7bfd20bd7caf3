"""The picture of levels over time in the replay."""

from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

import ehamj
from ehamj.plots.spectrograms import scale_of
from ehamj.replay import write_replay
from ehamj.replay.spectrogram import GAP, PAPER, QUIETEST, ROW, UNKNOWN, WIDTH, Heat, heats_of, picture
from ehamj.result import Result


@pytest.fixture(scope="module")
def result() -> Result:
    ground = {"kind": "sine", "dof": "z", "amplitude": 2e-6, "frequency": 10.0}
    table = {"name": "a floor", "duration": 6.0, "plates": "tied", "record_rate": 500.0, "ground": ground}
    return ehamj.simulate(ehamj.parse_scenario(table))


def test_only_axes_that_move_have_a_picture(result: Result) -> None:
    heats = heats_of({"run": result})
    assert list(heats) == ["z"]
    assert list(heats["z"].panels) == ["floor", "run"]
    short = ehamj.simulate(ehamj.parse_scenario({"duration": 0.05, "plates": "tied"}))
    assert heats_of({"run": short}) == {}


def test_colours_stand_where_levels_are() -> None:
    levels = np.full((3, 10), 1e-6)
    levels[2, 7] = 1e-4
    levels[0, 0] = np.nan
    heat = Heat(np.arange(1.0, 11.0), 1.0, ("16", "20", "25"), {"floor": levels, "machine": 0.1 * levels})
    drawn = picture(heat, *scale_of(list(heat.panels.values()), QUIETEST))
    assert drawn.shape == (heat.tall, WIDTH, 3)
    wide = WIDTH // 10
    brightest = tuple(drawn[GAP, 7 * wide + 5])  # the highest band is on top
    assert brightest[1] > 200
    assert tuple(drawn[GAP + ROW, 7 * wide + 5]) != brightest
    assert tuple(drawn[GAP + 2 * ROW + 1, 1]) == UNKNOWN
    assert tuple(drawn[GAP + 3 * ROW + 2, 1]) == PAPER
    assert heat.across(np.array([0.0, 7.5, 10.0])).tolist() == [0.0, 0.75 * WIDTH, WIDTH]


def test_picture_and_cursor_are_recorded_and_cost_little(result: Result, tmp_path: Path, monkeypatch) -> None:
    path = tmp_path / "replay.rrd"
    write_replay(path, {"run": result})
    chunks = list(RrdReader(path).store().stream().to_chunks())
    paths = {chunk.entity_path for chunk in chunks}
    assert {f"/spectrogram/z/{part}" for part in ("picture", "text", "cursor")} <= paths
    stream = RrdReader(path).store().stream().filter(content="/spectrogram/z/cursor", has_timeline="sim_time")
    stamps = np.concatenate(
        [chunk.to_record_batch().column("sim_time").to_numpy(zero_copy_only=False) for chunk in stream.to_chunks()]
    )
    assert stamps.astype(np.int64).max() == pytest.approx(6e9, rel=0.05)
    without = tmp_path / "without.rrd"
    monkeypatch.setattr("ehamj.replay.heats_of", lambda results: {})
    write_replay(without, {"run": result})
    assert path.stat().st_size - without.stat().st_size < 200_000


def test_a_result_without_rows_has_a_replay(result: Result, tmp_path: Path) -> None:
    from dataclasses import replace

    write_replay(tmp_path / "none.rrd", {"run": replace(result, dataset=result.dataset.isel(time=slice(0, 0)))})
