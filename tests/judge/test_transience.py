"""What floor is called transient: strikes are, stationary noise of any shape, lines and multisines are not."""

from typing import Any

import numpy as np
import pytest

from ehamj.estimate.bands import bands
from ehamj.ground.synthetic import HalfSine
from ehamj.judge.levels import levels_of
from ehamj.judge.transience import Transience, transience
from ehamj.plant.mounts import MOUNTS
from ehamj.result import make_dataset
from ehamj.scenario.load import parse_scenario

RATE = 250.0
SECONDS = (10.0, 15.0, 25.0, 60.0)
SHAPES = ("flat per band", "white", "microseism", "resonant", "lines")


def called(floor: np.ndarray) -> Transience | None:
    """What is said of a rigid floor that moves as (time, axis) [m/s]."""
    n, plant = len(floor), parse_scenario({}).plant
    rest = {"foot_velocity": np.zeros((n, 4, 3)), "cg_velocity": np.zeros((n, 3)), "machine_velocity": np.zeros((n, 6))}
    ground = np.repeat(floor[:, None, :], len(MOUNTS), axis=1)
    dataset = make_dataset(np.arange(n) / RATE, {"ground_velocity": ground, **rest}, {}, {"mount": list(MOUNTS)})
    return transience(dataset, levels_of(dataset, plant, RATE, bands(1.0, 100.0)), RATE)


def density(shape: str, f: np.ndarray) -> np.ndarray:
    """Relative power density of stationary floors."""
    f = np.maximum(f, 0.05)
    if shape == "flat per band":
        return np.minimum(1.0, f) ** 8 / f / (1.0 + (f / 80.0) ** 8)
    if shape == "microseism":  # and what traffic adds, 50 dB below
        return np.exp(-(np.log(f / 0.2) ** 2) / 0.2) + 1e-5 / (1.0 + (f / 10.0) ** 4)
    if shape == "resonant":  # floors with a damping of 1 and 3 % at 7 and 12 Hz
        return sum(1.0 / ((1 - (f / at) ** 2) ** 2 + (2 * d * f / at) ** 2) for at, d in ((7.0, 0.01), (12.0, 0.03)))
    return np.ones_like(f)


def noise(shape: str, seconds: float, random: np.random.Generator) -> np.ndarray:
    """Stationary Gaussian floor (time, axis) of 10 µm/s along z: a part of a longer one, which has no period."""
    n = int(seconds * RATE) + 1
    long = 2 * n
    lines = np.fft.rfft(random.standard_normal(long)) * np.sqrt(density(shape, np.fft.rfftfreq(long, 1.0 / RATE)))
    found = np.fft.irfft(lines, long)[n // 2 : n // 2 + n]
    found *= 1e-5 / found.std()
    if shape == "lines":
        time = np.arange(n) / RATE
        for f in random.uniform(5.0, 100.0, 4):
            found += 1e-4 * np.sin(2 * np.pi * f * time + random.uniform(0.0, 6.3))
    return found[:, None] * [0.0, 0.0, 1.0]


def test_of_a_hundred_stationary_gaussian_floors_at_most_one_is_called_transient() -> None:
    random = np.random.default_rng(3)
    cases = ((SHAPES[k % 5], SECONDS[k // 5 % 4]) for k in range(100))
    found = [called(noise(shape, seconds, random)) for shape, seconds in cases]
    assert sum(one is not None for one in found) <= 1  # one in a thousand is expected


@pytest.mark.parametrize("at", [1.0, 6.3, 19.0])
def test_a_strike_on_a_quiet_floor_is_called_transient_whenever_it_comes(at: float) -> None:
    floor = noise("flat per band", 20.0, np.random.default_rng(8))
    time = np.arange(len(floor)) / RATE
    floor[:, 2] += HalfSine(0.5e-3, 0.04, 0.5, at).sample(time).slope
    found = called(floor)
    assert found is not None
    assert (found.axis, found.max_1s > 2.0 * found.rms) == ("z", True)
    assert found.max_1s > found.by_chance > found.rms
    assert f"in the {found.band} Hz band its largest second is" in found.in_words()


@pytest.mark.parametrize(
    "frequencies", [(10.0,), (10.0, 10.7), tuple(np.arange(1, 800) / 10.0)], ids=["line", "beat", "multisine"]
)
def test_what_is_periodic_is_stationary(frequencies: tuple[float, ...]) -> None:
    random, time = np.random.default_rng(2), np.arange(5001) / RATE
    wave: Any = sum(np.sin(2 * np.pi * f * time + random.uniform(0.0, 6.3)) for f in frequencies)
    assert called(1e-5 * wave[:, None] * [0.0, 0.3, 1.0]) is None


def test_a_floor_at_rest_or_hardly_recorded_is_not_called_anything() -> None:
    assert called(np.zeros((5001, 3))) is None
    assert called(np.zeros((10, 3))) is None
