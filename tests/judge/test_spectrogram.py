"""Levels over time: what is loud when, and nothing lost in a long run."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from ehamj.judge import spectrogram as module
from ehamj.judge.isolation import Analysis
from ehamj.judge.spectrogram import Run, spectrogram
from ehamj.plant.mounts import MOUNTS
from ehamj.result import make_dataset

RATE = 500.0
X, Y, Z = range(3)


def dataset_of(seconds: float, floor: dict[int, np.ndarray], machine: np.ndarray) -> xr.Dataset:
    """Vertical velocities: of the floor at some mounts, and of the machine."""
    time = np.arange(int(seconds * RATE)) / RATE
    ground, cg = np.zeros((time.size, 4, 3)), np.zeros((time.size, 3))
    for mount, velocity in floor.items():
        ground[:, mount, Z] = velocity
    cg[:, Z] = machine
    return make_dataset(time, {"ground_velocity": ground, "cg_velocity": cg}, {}, {"mount": list(MOUNTS)})


def analysed(usable_to: float | None = None, usable_from: float = 0.0) -> Analysis:
    return Analysis(from_s=1.0, to_s=20.0, usable_to_hz=usable_to, usable_from_hz=usable_from)


def tone(seconds: float, frequency: float, rms: float, begin: float = 0.0, end: float = np.inf) -> np.ndarray:
    time = np.arange(int(seconds * RATE)) / RATE
    return np.sqrt(2.0) * rms * np.sin(2 * np.pi * frequency * time) * ((time >= begin) & (time < end))


def run_of(seconds: float, *arguments: Any, **analysis: Any) -> Run:
    return Run(dataset_of(seconds, *arguments), RATE, analysed(**analysis))


def found(seconds: float, *arguments: Any, **analysis: Any) -> Any:
    result = spectrogram({"machine": run_of(seconds, *arguments, **analysis)})
    assert result is not None
    return result


def test_a_burst_is_loud_in_its_band_while_it_lasts_and_a_second_longer() -> None:
    burst = tone(20.0, 20.0, 1e-5, 8.0, 12.0)
    seen = found(20.0, {0: burst}, 0.1 * burst)
    row = [band.name for band in seen.bands].index("20")
    level = seen.places["machine"][row, :, Z]
    at = {time: float(np.interp(time, seen.time, level)) for time in (7.5, 10.0, 11.5, 13.8)}
    # 2 %: the band's own 20 Hz passes whole; a class 1 filter may be 0.4 dB off, and takes 0.3 s to fill.
    assert (at[10.0], at[11.5]) == (pytest.approx(1e-6, rel=0.02), pytest.approx(1e-6, rel=0.02))
    assert max(at[7.5], at[13.8]) < 1e-8
    others = np.delete(seen.places["machine"][:, :, Z], [row - 1, row, row + 1], axis=0)
    assert np.nanmax(others) < 0.25e-6


def test_the_floor_counts_where_it_is_worst() -> None:
    seen = found(20.0, {0: tone(20.0, 20.0, 1e-5), 2: tone(20.0, 20.0, 3e-5)}, np.zeros(10_000))
    row = [band.name for band in seen.bands].index("20")
    assert seen.places["floor"][row, -1, Z] == pytest.approx(3e-5, rel=0.02)
    assert not seen.places["machine"].any() or np.nanmax(seen.places["machine"]) < 1e-12


def test_a_long_run_loses_no_strike_in_few_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "COLUMNS", 20)
    strike = tone(60.0, 31.5, 1e-3, 44.0, 44.05)
    seen = found(60.0, {0: strike}, strike)
    assert seen.time.size <= 20
    assert seen.time[-1] == pytest.approx(60.0, abs=0.3)
    np.testing.assert_allclose(np.diff(seen.time), seen.step)
    row = [band.name for band in seen.bands].index("31.5")
    (loud,) = np.nonzero(seen.places["machine"][row, :, Z] > 0.5 * np.nanmax(seen.places["machine"][row, :, Z]))
    assert seen.time[loud[0]] - seen.step < 45.1
    assert seen.time[loud[-1]] >= 44.0


def test_only_bands_in_which_the_ground_is_known() -> None:
    seen = found(20.0, {0: tone(20.0, 20.0, 1e-5)}, np.zeros(10_000), usable_to=40.0, usable_from=2.0)
    assert (seen.bands[0].name, seen.bands[-1].name) == ("2.5", "31.5")


@pytest.mark.parametrize("seconds", [0.02, 0.5])
def test_a_run_that_is_too_short_has_none(seconds: float) -> None:
    n = int(seconds * RATE)
    assert spectrogram({"run": run_of(seconds, {0: np.ones(n)}, np.ones(n))}) is None


def test_floors_that_are_alike_are_shown_once() -> None:
    loud, soft = tone(20.0, 20.0, 1e-5), tone(20.0, 20.0, 1e-6)
    one, same, other = (run_of(20.0, {0: floor}, soft) for floor in (loud, loud, soft))
    shorter = run_of(15.0, {0: loud[:7500]}, soft[:7500])

    def places(**runs: Run) -> list[str]:
        seen = spectrogram(runs)
        assert seen is not None
        return list(seen.places)

    assert places(a=one, b=same) == ["floor", "a", "b"]
    assert places(a=one, b=other) == ["floor", "floor of b", "a", "b"]
    assert places(a=one, b=shorter) == ["floor", "a"]


def test_an_axis_that_hardly_moves_has_no_picture() -> None:
    seen = found(20.0, {0: tone(20.0, 20.0, 1e-5)}, tone(20.0, 20.0, 1e-6))
    assert list(seen.along("z")) == ["floor", "machine"]
    assert seen.along("x") == {}
