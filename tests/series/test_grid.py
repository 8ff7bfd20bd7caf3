"""Sums of many lines a block at a time: the same as the transform over all of it, wherever and in whatever order."""

import errno
import tempfile
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline

from ehamj.errors import InputError
from ehamj.forces.vibrations import random_force
from ehamj.ground import Motion
from ehamj.scenario.load import parse_scenario
from ehamj.series import Lines, Sampled, parts, room, stored
from ehamj.series.grid import Grid


def whole(lines: np.ndarray, size: int) -> np.ndarray:
    """Value, slope and curvature on the grid by NumPy's FFT over all of it, in units of a grid step."""
    turn = 2j * np.pi * np.arange(lines.size) / size
    found = []
    for order in range(3):
        spectrum = np.zeros(size, complex)
        spectrum[: lines.size] = turn**order * lines
        found.append(size * np.fft.ifft(spectrum).real)
    return np.array(found)


@pytest.mark.usefixtures("short_blocks")
@settings(max_examples=12)
@given(st.integers(760, 4000), st.floats(0.0, 3.0), st.integers(0, 1000))
def test_blocks_are_the_transform_over_the_whole_grid(count: int, fall: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    lines = (random.normal(size=count) + 1j * random.normal(size=count)) / (1.0 + np.arange(count)) ** fall
    own = Grid(lines)
    assert own._span < own.size
    wanted = whole(lines, own.size)
    at = random.permutation(own.size)
    first, second = own.ends(at)
    for found, beside in ((first, at), (second, (at + 1) % own.size)):
        # The kernel leaves 1e-13 of the RMS.
        error = np.abs(found - wanted[:, beside]).max(axis=1) / np.sqrt((wanted**2).mean(axis=1))
        assert error.max() < 5e-13


@pytest.mark.usefixtures("short_blocks")
def test_what_is_asked_for_twice_is_the_same_in_whatever_order() -> None:
    random = np.random.default_rng(1)
    lines = random.normal(size=4000) + 1j * random.normal(size=4000)
    signal, windows = Lines(10.0, lines), np.linspace(-1.0, 11.0, 60)[:, None] + np.arange(5) * 1e-3
    there = [signal.sample(times) for times in windows]
    back = [signal.sample(times) for times in windows[::-1]][::-1]
    np.testing.assert_array_equal(np.array(there), np.array(back))
    np.testing.assert_array_equal(np.array(signal.sample(windows.ravel())).reshape(3, 60, 5).swapaxes(0, 1), there)


def floor(duration: float = 12.0, **ground: Any) -> Motion:
    table = {"kind": "broadband", "level": 20e-6, "axes": ["x", "z"], "wave": {"speed": 150.0}, **ground}
    return parse_scenario({"duration": duration, "seed": 2, "ground": table}).motion()


@pytest.mark.parametrize("ground", [{}, {"coherence": {}}, {"kind": "burst"}])
def test_a_seed_gives_the_same_floor_in_blocks_and_from_a_file(
    ground: dict[str, Any], blocks_of: Callable[[int], None]
) -> None:
    times = np.linspace(0.0, 12.0, 777)
    held = floor(**ground).sample(times)
    blocks_of(5000)
    blocks = floor(**ground).sample(times)
    for one, other in zip(held, blocks, strict=True):
        # Accelerations come of differences of displacements, whose rounding of 1e-16 is 1e-10 of them.
        error = np.abs(one - other).max(axis=(0, 1))
        assert (error <= 1e-9 * np.sqrt((one**2).mean(axis=(0, 1)))).all()


def test_a_random_force_is_the_same_in_blocks_and_from_a_file(blocks_of: Callable[[int], None]) -> None:
    times = np.linspace(0.0, 8.0, 400)
    held = random_force(20.0, 5.0, 200.0, 8.0, np.random.default_rng(3)).sample(times)
    blocks_of(1500)
    blocks = random_force(20.0, 5.0, 200.0, 8.0, np.random.default_rng(3)).sample(times)
    for one, other in zip(held, blocks, strict=True):
        np.testing.assert_allclose(other, one, rtol=0, atol=1e-9 * np.sqrt((one**2).mean()))


def peak(duration: float) -> int:
    """Most memory that a floor takes while it is built and sampled at some places [byte]."""
    tracemalloc.start()
    try:
        motion = floor(duration, axes=["z"])
        for begin in np.linspace(0.0, duration, 5):
            motion.sample(begin + np.arange(100) * 1e-3)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_a_floor_ten_times_as_long_takes_no_more_memory() -> None:
    short, long = peak(96.0), peak(960.0)  # whose blocks are of one length
    # The order of steps in the widest third octave, 18 % of the lines, and nothing else: 0.7 byte of each line.
    assert long - short < 1.0 * 500.0 * (960.0 - 96.0)


@pytest.mark.usefixtures("short_blocks")
def test_a_spline_in_blocks_is_the_spline_through_all_samples() -> None:
    values, times = np.random.default_rng(4).normal(size=7000).cumsum(), np.linspace(-1.0, 71.0, 5001)
    own = Sampled(100.0, stored(values))
    assert not isinstance(own.values, np.ndarray)
    spline = make_interp_spline(np.arange(7000) / 100.0, values, k=5)
    for order, part in enumerate(own.sample(times)):
        inside = (times >= 0.0) & (times <= 69.99)
        wanted = spline.derivative(order)(times[inside]) if order else spline(times[inside])
        # What both splines round, 1e-16 of the value, times some ten per derivative and sample.
        np.testing.assert_allclose(part[inside], wanted, rtol=0, atol=1e-13 * 3e3**order * np.abs(values).max())
        np.testing.assert_array_equal(
            part[~inside], np.where(times[~inside] < 0.0, values[0], values[-1]) if order == 0 else 0.0
        )


# --- files --------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("short_blocks")
def test_what_a_file_holds_is_what_was_written_and_zero_else() -> None:
    held, array = room(5000), np.zeros(5000, complex)
    assert not isinstance(held, np.ndarray)
    for number, part in enumerate(parts(700, 4800, 300)):
        if number % 2:
            held[part] = array[part] = np.arange(part.start, part.stop) * (1.0 - 2.0j)
    np.testing.assert_array_equal(held[:], array)
    np.testing.assert_array_equal(held[1234:1300], array[1234:1300])
    assert held[5000:5100].size == 0


@pytest.mark.usefixtures("short_blocks")
def test_a_full_disk_is_named_with_the_way_out(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: Any) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("os.pwrite", full)
    with pytest.raises(InputError, match=r"needs 0\.096 MB in the folder .*: No space left on device; make the dur"):
        floor()


@pytest.mark.usefixtures("short_blocks")
def test_a_missing_folder_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "none"))
    with pytest.raises(InputError, match=r"none: No such file or directory; .* let TMPDIR name a folder with room"):
        room(5000)
