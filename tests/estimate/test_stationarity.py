"""How large the largest window of stationary noise is by chance: against noise that is drawn, and by its limits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import toeplitz

from ehamj.estimate.bands import bands
from ehamj.estimate.counted import Counted
from ehamj.estimate.reading import Reading
from ehamj.estimate.stationarity import chance, largest_by_chance, shares, white

RUNS = 1500


def largest(width: float, windows: int, random: np.random.Generator) -> np.ndarray:
    """Largest over mean square of windows of 1 s, of complex Gaussian noise behind a Butterworth of third order."""
    step = 1.0 / (8.0 * width)
    n, window = round(windows / step), round(1.0 / step)
    frequency = np.fft.fftfreq(n + window, step)
    passed = 1.0 / np.sqrt(1.0 + np.abs(2.0 * frequency / width) ** 6)
    found = []
    for _ in range(RUNS):
        drawn = random.standard_normal((2, frequency.size))
        square = np.abs(np.fft.ifft(passed * (drawn[0] + 1j * drawn[1]))[:n]) ** 2
        energy = np.concatenate([[0.0], np.cumsum(square)])
        found.append((energy[window:] - energy[:-window]).max() / window / square.mean())
    return np.sort(found)


@pytest.mark.parametrize(("width", "windows"), [(1.0, 5), (1.0, 19), (5.8, 19), (23.0, 10)])
def test_drawn_noise_exceeds_it_as_often_as_said(width: float, windows: int) -> None:
    drawn = largest(width, windows, np.random.default_rng(1))
    frequency = np.fft.fftfreq(1 << 14, 1.0 / 128)
    correlation = np.fft.ifft(1.0 / (1.0 + np.abs(2.0 * frequency / width) ** 6)).real[:128]
    own = np.linalg.eigvalsh(toeplitz(correlation / correlation[0]))[::-1] / 128
    for probability in (0.1, 0.02):
        ratio = float(np.quantile(drawn, 1.0 - probability))
        # On the safe side by up to threefold; 30 of 1500 runs scatter by a fifth.
        assert 0.8 < chance(ratio, own, windows) / probability < 3.0
        assert largest_by_chance(probability, own, windows) == pytest.approx(ratio, rel=0.12)


@given(st.integers(1, 60), st.floats(3.0, 60.0), st.floats(-7.0, -1.0))
@settings(max_examples=40)
def test_the_ratio_has_the_probability_that_it_was_asked_for(count: int, windows: float, power: float) -> None:
    own = np.full(count, 1.0 / count)
    ratio = largest_by_chance(10.0**power, own, windows)
    assert 1.0 < ratio < windows
    assert np.log10(chance(ratio, own, windows)) == pytest.approx(power, abs=0.02)


def test_what_is_impossible_and_what_is_certain() -> None:
    own = np.full(3, 1 / 3)
    assert [chance(ratio, own, 10.0) for ratio in (0.5, 1.0, 10.0, 12.0)] == [1.0, 1.0, 0.0, 0.0]


def test_noise_narrower_than_its_band_has_fewer_degrees_of_freedom() -> None:
    rate, n = 500.0, 30_001
    random, (band,) = np.random.default_rng(4), bands(25.0, 25.0)
    time = np.arange(n) / rate
    slow = np.convolve(random.standard_normal((2, n))[0], np.ones(500) / 500, "same")  # within 1 Hz about 25 Hz
    for motion, least, most in (
        (random.standard_normal(n), 4.5, 8.0),
        (slow * np.cos(2 * np.pi * 25.0 * time), 1.0, 2.0),
    ):
        spectrum = Reading.of(motion, Counted(n, rate), (band,)).spectra[band]
        own = shares(spectrum, band)
        assert own.sum() == pytest.approx(1.0)
        assert least <= 1.0 / (own**2).sum() <= most
    assert white(band).size == 6  # 5.8 Hz for 1 s, and 5 % for the filter's skirts
