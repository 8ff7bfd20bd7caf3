"""Records sampled faster than any motion of interest: decimated without a trace of what lies above, and said."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile

from ehamj.ground import Motion, Start
from ehamj.ground.records import RecordGround
from ehamj.ground.resampling import decimated
from ehamj.ground.treatment import Treatment, displacement
from ehamj.plant.mounts import MOUNTS
from ehamj.records.channel import Channel

TAU = 2 * np.pi
RATE = 51_200.0
POSITIONS = np.array([[0.9, 0.6], [0.9, -0.6], [-0.9, 0.6], [-0.9, -0.6]])


def line(frequency: float, duration: float = 8.0) -> np.ndarray:
    return np.sin(TAU * frequency * np.arange(int(duration * RATE)) / RATE)


def velocity(samples: np.ndarray, **settings: float) -> np.ndarray:
    """What 2 s in the middle of a velocity record become [m/s], at times that are no samples."""
    channel = Channel("z", "z", RATE, "velocity", samples)
    moved = displacement(channel, Treatment(highpass=1.0, **settings), 0.0, samples.size / RATE)
    return moved.sample(np.arange(3.0, 5.0, 1 / 20_011)).slope


@pytest.mark.parametrize("frequency", [10.0, 900.0, 2000.0])
def test_a_line_below_the_usable_end_survives(frequency: float) -> None:
    expected = np.sin(TAU * frequency * np.arange(3.0, 5.0, 1 / 20_011))
    # The spline's share is the 1e-3 that the module promises at the usable end (2048 Hz), and far less below.
    assert np.abs(velocity(line(frequency)) - expected).max() < 1e-3


@pytest.mark.parametrize("frequency", [2_600.0, 5_110.0, 20_000.0])
def test_a_line_above_leaves_nothing_not_even_at_its_mirror(frequency: float) -> None:
    # 5110 Hz would come back as 10 Hz, and 20 kHz as 480 Hz.
    assert np.abs(velocity(line(frequency))).max() < 1e-6


def test_the_response_of_a_fast_instrument_is_removed_too() -> None:
    # Counts of a geophone-like pole at 2 Hz: what it felt was the line itself.
    def response(frequency: np.ndarray) -> np.ndarray:
        return np.asarray(1e6 * 1j * frequency / (1j * frequency + 2.0))

    felt = response(np.array([50.0]))[0]
    counts = np.abs(felt) * np.sin(TAU * 50.0 * np.arange(int(8 * RATE)) / RATE + np.angle(felt))
    channel = Channel("z", "z", RATE, "velocity", counts, response=response)
    moved = displacement(channel, Treatment(highpass=1.0), 0.0, 8.0)
    query = np.arange(3.0, 5.0, 1 / 20_011)
    # 50 Hz stands fifty times above the corner; the water level and the band leave it alone.
    assert np.abs(moved.sample(query).slope - np.sin(TAU * 50.0 * query)).max() < 1e-5


def test_every_nth_sample_of_a_slow_signal_comes_back_in_its_place() -> None:
    time = np.arange(50_003) / 1000.0
    slow = np.exp(-((time - 25.0) ** 2)) * np.cos(TAU * 7.0 * time)
    for factor in (1, 2, 7, 20):
        np.testing.assert_allclose(decimated(slow, factor), slow[::factor], atol=1e-12)  # rounding


def test_a_record_within_the_limits_is_not_touched() -> None:
    treatment = Treatment(highpass=1.0)
    assert [treatment.decimated_rate(rate) for rate in (100.0, 5000.0, 9999.0, 10_000.0, 51_200.0, 48_000.0)] == [
        *(100.0, 5000.0, 9999.0, 5000.0, 5120.0),
        48_000.0 / 9,
    ]


def ground(folder: Path, seconds: float, channels: int) -> Motion:
    data = np.random.default_rng(1).standard_normal((int(seconds * RATE), channels)).astype(np.float32) * 0.1
    wavfile.write(folder / "a.wav", int(RATE), data)
    axes = {str(n + 1): place for n, place in zip(range(channels), ("z", "x", "y", "front-left z"), strict=False)}
    table = {"kind": "record", "file": str(folder / "a.wav"), "axes": axes, "unit": "mm/s", "full_scale": 1.0}
    return RecordGround(**table).motion(Start(MOUNTS, POSITIONS, seconds, 1))


def test_it_is_said_and_the_motion_ends_where_the_decimated_record_does(tmp_path: Path) -> None:
    moving = ground(tmp_path, 3.0, 1)
    assert moving.usable_to == 2048.0
    text = "\n".join(moving.notes)
    assert "decimated from 51200 Hz to 5120 Hz in the frequency domain, without phase (unchanged up to 2048 Hz" in text
    assert "ends at 2048 Hz (sampled at 51200 Hz)" in text


def test_memory_grows_with_what_is_recorded_and_not_with_its_square(tmp_path: Path) -> None:
    tracemalloc.start()
    ground(tmp_path, 20.0, 4)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    # 4 channels × 20 s × 51.2 kHz are 33 MB as numbers; the file, its transform and the motion's splines beside them.
    assert peak < 300e6
