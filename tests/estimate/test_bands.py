"""Third-octave bands against the values of IEC 61260-1, and levels of sines and noise that are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehamj.estimate.bands import BAND_LOG_WIDTH, Band, bands
from ehamj.estimate.counted import LEAST_BINS
from ehamj.estimate.reading import band_rms

NOMINAL = (
    *("1", "1.25", "1.6", "2", "2.5", "3.15", "4", "5", "6.3", "8"),
    *("10", "12.5", "16", "20", "25", "31.5", "40", "50", "63", "80"),
    *("100", "125", "160", "200", "250", "315"),
)
EXACT = (
    *(1.0, 1.2589, 1.5849, 1.9953, 2.5119, 3.1623, 3.9811, 5.0119, 6.3096, 7.9433),
    *(10.0, 12.589, 15.849, 19.953, 25.119, 31.623, 39.811, 50.119, 63.096, 79.433),
    *(100.0, 125.89, 158.49, 199.53, 251.19, 316.23),
)
"""Mid-band frequencies of IEC 61260-1:2014, base ten, to five digits [Hz]."""
LOWER = (0.89125, 1.1220, 1.4125, 1.7783, 2.2387, 2.8184, 3.5481, 4.4668, 5.6234, 7.0795)
"""Lower edges of the bands from 1 to 8 Hz [Hz]; each is the upper edge of the band below."""
ALL = bands(1.0, 315.0)
RATE = 800.0


# --- bands --------------------------------------------------------------------------------------------------------


def test_bands_have_their_nominal_names() -> None:
    assert tuple(band.name for band in ALL) == NOMINAL


@pytest.mark.parametrize(
    ("first", "last", "names"),
    [
        (0.1, 0.5, ["0.1", "0.125", "0.16", "0.2", "0.25", "0.315", "0.4", "0.5"]),
        (800.0, 1250.0, ["800", "1000", "1250"]),
    ],
)
def test_other_decades_are_named_alike(first: float, last: float, names: list[str]) -> None:
    assert [band.name for band in bands(first, last)] == names


def test_centres_are_the_norms() -> None:
    np.testing.assert_allclose([band.centre for band in ALL], EXACT, rtol=5e-5)  # half of the fifth digit


def test_edges_are_the_norms() -> None:
    decades = np.concatenate([np.array(LOWER) * 10.0**k for k in range(3)])[: len(ALL) + 1]
    np.testing.assert_allclose([band.edges for band in ALL], np.column_stack([decades[:-1], decades[1:]]), rtol=5e-5)


@given(st.integers(-40, 20))
def test_bands_join_without_gap_and_ten_make_a_decade(index: int) -> None:
    assert Band(index).edges[1] == pytest.approx(Band(index + 1).edges[0], rel=1e-14)
    assert Band(index + 10).centre == pytest.approx(10 * Band(index).centre, rel=1e-14)


@given(st.integers(-40, 20))
def test_a_band_is_found_by_its_nominal_and_by_its_exact_centre(index: int) -> None:
    band = Band(index)
    nominal = float(NOMINAL[index % 10]) * 10.0 ** (index // 10 + 3)
    assert bands(nominal, nominal) == bands(band.centre, band.centre) == (band,)


def test_the_logarithmic_width_is_that_of_a_band() -> None:
    assert pytest.approx(np.log(1.1220 / 0.89125), rel=1e-4) == BAND_LOG_WIDTH


# --- levels -------------------------------------------------------------------------------------------------------


def sine(frequency: float, seconds: float, phase: float = 0.3) -> np.ndarray:
    """Of RMS one."""
    return np.sqrt(2) * np.sin(2 * np.pi * frequency * np.arange(round(seconds * RATE)) / RATE + phase)


def decibel(ratio: float) -> float:
    return float(20 * np.log10(ratio))


@pytest.mark.parametrize("band", ALL, ids=lambda band: band.name)
def test_a_sine_at_the_centre_is_all_in_its_band(band: Band) -> None:
    levels = band_rms(sine(band.centre, 60.0), RATE, ALL)
    assert decibel(levels[ALL.index(band)]) == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("band", ALL, ids=lambda band: band.name)
def test_a_sine_at_the_centre_is_hardly_in_any_other(band: Band) -> None:
    levels = band_rms(sine(band.centre, 60.0), RATE, ALL)
    others = np.delete(levels, ALL.index(band))
    # The edge of 1 Hz lies 6.5 lines away from its centre, where Hann's sidelobes of a whole band add up to −60 dB.
    assert np.nanmax(others) < 1e-3


@pytest.mark.parametrize("band", ALL[1:], ids=lambda band: band.name)
def test_a_sine_at_an_edge_is_in_both_bands_together(band: Band) -> None:
    levels = band_rms(sine(band.edges[0], 60.0), RATE, ALL)
    below, own = levels[ALL.index(band) - 1], levels[ALL.index(band)]
    assert decibel(np.hypot(below, own)) == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("band", ALL[1:], ids=lambda band: band.name)
def test_a_sine_exactly_at_an_edge_is_shared_equally(band: Band) -> None:
    # A whole number of periods: Hann spreads it over its own line, cut in half by the edge, and one on either side.
    edge = band.edges[0]
    wave = np.sin(2 * np.pi * edge * np.arange(3200) / (32 * edge))
    below, own = band_rms(wave, 32 * edge, (ALL[ALL.index(band) - 1], band))
    assert (below, own) == pytest.approx((0.5, 0.5), rel=1e-6)


@given(st.floats(1.2, 250.0), st.floats(0.0, 6.3), st.floats(20.0, 60.0))
def test_no_power_is_lost_between_bands(frequency: float, phase: float, seconds: float) -> None:
    levels = band_rms(sine(frequency, seconds, phase), RATE, bands(1.0, 315.0))
    assert decibel(np.sqrt(np.nansum(levels**2))) == pytest.approx(0.0, abs=0.1)


def test_white_noise_has_the_level_of_its_density_in_every_band() -> None:
    random, total = np.random.default_rng(11), np.zeros(len(ALL))
    for _ in range(20):
        noise = random.standard_normal((round(60 * RATE), 20))
        total += (band_rms(noise, RATE, ALL) ** 2).mean(axis=1) / 20
    density = 1.0 / (RATE / 2)
    expected = [density * (high - low) for low, high in (band.edges for band in ALL)]
    deviation = 10 * np.log10(total / expected)
    # 400 records of 60 s: 1 Hz holds 9 independent lines in each, whose mean square is read to 1/√3700, 0.07 dB.
    assert np.abs(deviation).max() < 0.1


def test_the_screening_spectrum_of_navmat_p_9492_has_its_published_level() -> None:
    """Published (Navy Manufacturing Screening Program, 1979): 0.04 g²/Hz from 80 to 350 Hz, 3 dB/octave down to 20 Hz
    and up to 2000 Hz; 6.06 g RMS in all. Where it is flat a band holds 0.04 g²/Hz times its width, 0.2316 of its
    centre.
    """
    rate, n, channels = 5000.0, 50_000, 40
    f = np.arange(n // 2 + 1) * rate / n
    density = 0.04 * np.minimum(1.0, np.minimum(f / 80.0, 350.0 / np.maximum(f, 1.0)))
    density[(f < 20.0) | (f > 2000.0)] = 0.0
    phases = np.random.default_rng(4).uniform(0.0, 2.0 * np.pi, (f.size, channels))
    lines = np.sqrt(2.0 * density * rate / n)[:, None] * np.exp(1j * phases)
    signal = np.fft.irfft(lines * n / 2, n, axis=0)
    chosen = bands(16.0, 2000.0)
    power = (band_rms(signal, rate, chosen) ** 2).mean(axis=1)
    assert decibel(np.sqrt(power.sum()) / 6.06) == pytest.approx(0.0, abs=0.1)
    for band, mean_square in zip(chosen, power, strict=True):
        if 100.0 <= band.centre < 310.0:
            # 40 records, in each of which 100 Hz holds 230 lines: 1/√9200 of scatter, 0.05 dB.
            assert 0.5 * decibel(mean_square / (0.04 * 0.2316 * band.centre)) == pytest.approx(0.0, abs=0.1)


def test_channels_are_read_side_by_side() -> None:
    signals = np.random.default_rng(2).standard_normal((4000, 3))
    together = band_rms(signals, RATE, ALL)
    for k in range(3):
        np.testing.assert_allclose(together[:, k], band_rms(signals[:, k], RATE, ALL), rtol=1e-12)


def test_an_offset_and_a_drift_are_no_vibration() -> None:
    wanted = sine(10.0, 30.0)
    drift = 500.0 + np.linspace(-300.0, 900.0, wanted.size)
    found, alone = (band_rms(part, RATE, ALL) for part in (wanted + drift, wanted))
    # Differences leave the drift's slope, half of the sine's velocity, of which the weights leak −110 dB to 10 Hz; in
    # the other bands it is rounding.
    np.testing.assert_allclose(found, alone, rtol=0, atol=1e-5)


@given(st.floats(1e-9, 1e6))
def test_levels_scale_with_the_signal(factor: float) -> None:
    signal = np.random.default_rng(4).standard_normal(2000)
    np.testing.assert_allclose(band_rms(factor * signal, RATE, ALL), factor * band_rms(signal, RATE, ALL), rtol=1e-9)


# --- displacement and acceleration --------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [-1, 1])
@pytest.mark.parametrize("place", ["centre", "just inside the upper edge"])
@pytest.mark.parametrize("band", ALL[3::5], ids=lambda band: band.name)
def test_a_line_has_the_displacement_and_acceleration_of_its_own_frequency(band: Band, place: str, order: int) -> None:
    frequency = band.centre if place == "centre" else 0.98 * band.edges[1]
    found = band_rms(sine(frequency, 60.0), RATE, ALL, order)[ALL.index(band)]
    # 0.1 dB, as for velocity: what Hann spreads over an edge.
    assert decibel(found / (2 * np.pi * frequency) ** order) == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize("order", [-1, 1])
def test_noise_of_known_density_has_the_integrals_of_its_weighted_density(order: int) -> None:
    noise = np.random.default_rng(12).standard_normal((round(60 * RATE), 60))
    found, own = ((band_rms(noise, RATE, ALL, k) ** 2).mean(axis=1) for k in (order, 0))
    low, high = np.array([band.edges for band in ALL]).T
    weighted = (1 / low - 1 / high) / (2 * np.pi) ** 2 if order < 0 else (2 * np.pi) ** 2 * (high**3 - low**3) / 3
    # Over the level of the noise itself, so that only where in the band its power happens to lie is left to chance.
    deviation = 10 * np.log10(found / own / (weighted / (high - low)))
    assert np.abs(deviation).max() < 0.1


# --- what cannot be said ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seconds", [1.0, 2.0, 5.0, 17.0])
def test_a_record_too_short_for_a_band_leaves_it_undecided(seconds: float) -> None:
    levels = band_rms(np.ones(round(seconds * RATE)), RATE, ALL)
    lines = [(high - low) * seconds for low, high in (band.edges for band in ALL)]
    np.testing.assert_array_equal(np.isnan(levels), np.array(lines) < LEAST_BINS)


@pytest.mark.parametrize(("rate", "highest"), [(200.0, "80"), (225.0, "100"), (224.0, "80"), (1000.0, "315")])
def test_a_band_above_half_the_sampling_rate_is_undecided(rate: float, highest: str) -> None:
    levels = band_rms(np.random.default_rng(0).standard_normal(round(30 * rate)), rate, ALL)
    assert [band.name for band, level in zip(ALL, levels, strict=True) if np.isfinite(level)][-1] == highest
