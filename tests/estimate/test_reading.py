"""The whole run's RMS: strikes count alike whenever they come, and neither lines nor strong bands hide weak ones."""

import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles.levels import whole_run_rms

from ehamj.estimate.bands import Band, bands
from ehamj.estimate.counted import Counted
from ehamj.estimate.reading import Reading, band_rms
from ehamj.estimate.sliding import statistics
from ehamj.ground.synthetic import HalfSine

RATE = 1000.0
ALL = bands(1.0, 315.0)
TIMES = np.arange(20001) / RATE


def decibel(ratio: float) -> float:
    return float(20 * np.log10(ratio))


def strikes(*begins: float) -> np.ndarray:
    """Half-sines of 0.5 mm/s and 40 ms, after which the floor stays where it is."""
    return sum(HalfSine(0.5e-3, 0.04, 1e6, begin).sample(TIMES).slope for begin in begins)  # type: ignore[return-value]


def spectrum_of_strikes(frequency: np.ndarray, *begins: float) -> np.ndarray:
    """Closed form: ∫ v sin(πt/T) e^(−jωt) dt = v (π/T) (1 + e^(−jωT))/((π/T)² − ω²), late by its beginning."""
    omega, own = 2 * np.pi * frequency, np.pi / 0.04
    one = 0.5e-3 * own * (1 + np.exp(-1j * omega * 0.04)) / (own**2 - omega**2)
    return one * sum(np.exp(-1j * omega * begin) for begin in begins)


# --- strikes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("begins", [(7.0,), (2.0, 5.0, 10.0, 15.0, 18.0)], ids=["one", "a train"])
def test_strikes_have_the_energy_of_their_spectrum_over_the_time_counted(begins: tuple[float, ...]) -> None:
    found = band_rms(strikes(*begins), RATE, ALL)
    for band, level in zip(ALL, found, strict=True):
        frequency = np.linspace(*band.edges, 4001)
        energy = 2 * np.trapezoid(np.abs(spectrum_of_strikes(frequency, *begins)) ** 2, frequency)
        # Of 20 s count 19, but for the taper at the end.
        expected = np.sqrt(energy / (18.5 + 0.392))  # 0.392: what the quintics' squares have
        if band.centre < 60.0:  # above, the samples' images count: the pulse has a kink at either end
            assert decibel(level / expected) == pytest.approx(0.0, abs=0.1)


def test_one_strike_and_five_read_as_measured_by_the_energy_between_the_edges() -> None:
    tenth = ALL.index(bands(10.0, 10.0)[0])
    one, train = (1e6 * band_rms(strikes(*at), RATE, ALL)[tenth] for at in ((7.0,), (2.0, 5.0, 10.0, 15.0, 18.0)))
    # µm/s over 20 s: 5.2 and 11.7, here over 18.9 s.
    assert (one, train) == pytest.approx((5.2 * np.sqrt(20 / 18.9), 11.7 * np.sqrt(20 / 18.9)), rel=0.01)


@given(st.integers(1000, 19300))
@settings(max_examples=30)
def test_a_strike_counts_the_same_whenever_it_comes(begin: int) -> None:
    found, middle = (band_rms(strikes(at), RATE, ALL) for at in (begin / RATE, 10.0))
    # 0.3 dB are asked for.
    np.testing.assert_allclose(20 * np.log10(found / middle), 0.0, atol=0.05)


def test_what_comes_before_the_taper_does_not_count() -> None:
    wave = np.sin(2 * np.pi * 10.0 * TIMES)
    loud = np.where(TIMES < 0.49, 1e3, 1.0) * wave
    np.testing.assert_array_equal(band_rms(loud, RATE, ALL)[10:], band_rms(wave, RATE, ALL)[10:])


# --- leakage --------------------------------------------------------------------------------------------------------


@given(
    st.sampled_from([(k, k + off) for k in range(len(ALL)) for off in (-2, 2) if 0 <= k + off < len(ALL)]),
    st.floats(10.0, 60.0),
    st.floats(0.0, 1.0),
    st.floats(0.15, 0.85),
    st.booleans(),
)
@settings(max_examples=60)
def test_a_line_80_db_below_another_two_bands_away_is_read(
    pair: tuple[int, int], seconds: float, place: float, other: float, struck: bool
) -> None:
    strong, weak = (ALL[k] for k in pair)
    time = np.arange(round(seconds * RATE)) / RATE
    if not Counted(time.size, RATE).decides(weak):
        return

    def line(band: Band, where: float) -> np.ndarray:
        low, high = band.edges
        return np.sqrt(2) * np.sin(2 * np.pi * (low + where * (high - low)) * time + 5 * where)

    quiet = 1e-4 * line(weak, other)
    if struck:
        quiet = quiet + HalfSine(1e-2, 0.04, 1.0, 0.5 * seconds).sample(time).slope
    (found,), (alone,) = (band_rms(motion, RATE, (weak,)) for motion in (line(strong, place) + quiet, quiet))
    assert decibel(found / alone) == pytest.approx(
        0.0, abs=0.5
    )  # 1 dB is asked for, and four resolved lines apart it is 0.3
    if not struck:
        assert decibel(alone / 1e-4) == pytest.approx(0.0, abs=0.1)


@pytest.mark.parametrize(("low", "high"), [(0.1, 0.5), (10.0, 20.0), (60.0, 80.0)])
def test_noise_60_db_above_does_not_hide_bands_an_octave_away(low: float, high: float) -> None:
    """Below and above it, from 0.9 Hz on; what no taper of half a second does by itself."""
    random = np.random.default_rng(6)
    time = np.arange(60_001) / RATE
    n = 120_002
    frequency = np.fft.rfftfreq(n, 1 / RATE)
    lines = np.fft.rfft(random.standard_normal(n)) * ((frequency > low) & (frequency < high))
    strong = np.fft.irfft(lines, n)[30_000 : 30_000 + time.size]
    quiet = 1e-3 * strong.std() * np.sqrt(1 / ALL[0].centre) * _flat(random, n)[30_000 : 30_000 + time.size]
    found, alone = (band_rms(motion, RATE, ALL) for motion in (strong + quiet, quiet))
    apart = [k for k, band in enumerate(ALL) if band.edges[1] < 0.5 * low or band.edges[0] > 2.0 * high]
    assert len(apart) > 10
    np.testing.assert_allclose(20 * np.log10(found / alone)[apart], 0.0, atol=1.0)


def _flat(random: np.random.Generator, n: int) -> np.ndarray:
    """Noise of RMS one in every third-octave from 1 to 315 Hz."""
    frequency = np.maximum(np.fft.rfftfreq(n, 1 / RATE), 0.5)
    return np.fft.irfft(np.fft.rfft(random.standard_normal(n)) * np.sqrt(500.0 / (0.2316 * frequency)), n)


def test_more_lines_than_are_taken_out_are_read_together() -> None:
    wave = sum(np.sin(2 * np.pi * f * TIMES + f * f) for f in np.arange(4.0, 60.0, 0.5))
    found = band_rms(wave, RATE, bands(5.0, 50.0))
    for band, level in zip(bands(5.0, 50.0), found, strict=True):
        assert decibel(level / whole_run_rms(wave, RATE, 1.0, band.centre)) == pytest.approx(0.0, abs=0.1)


# --- stationary motion ------------------------------------------------------------------------------------------------


def test_a_period_of_a_multisine_is_read_as_it_is() -> None:
    """Lines every 0.05 Hz, whose mean over any 20 s is known; of the 18.9 s counted each band holds its share."""
    random = np.random.default_rng(1)
    total, expected = np.zeros(len(ALL)), np.array([60 * 0.5 * 20.0 * band.width for band in ALL])
    for _ in range(60):
        lines = np.zeros(10001, complex)
        lines[15:8000] = 1e4 * np.exp(2j * np.pi * random.uniform(size=7985))
        whole = np.fft.irfft(lines, 20_000)
        total += band_rms(np.concatenate([whole, whole[:1]]), RATE, ALL) ** 2
    known = [k for k, band in enumerate(ALL) if band.centre > 2.4]
    # The twentieth of the time that does not count scatters: 0.1 dB are asked for.
    np.testing.assert_allclose(10 * np.log10(total / expected)[known], 0.0, atol=0.1)


def test_a_long_record_is_read_as_a_short_one_in_the_memory_of_a_few(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What of a long record is computed a part at a time, or not kept, changes no level."""
    counted, chosen = Counted(300_000, 2000.0), bands(1.0, 315.0)
    time = np.arange(counted.n) / counted.rate
    samples = np.random.default_rng(3).standard_normal(counted.n) + 3.0 * np.sin(2 * np.pi * 25.03 * time)

    def levels() -> list[np.ndarray]:
        reading = Reading.of(samples, counted, chosen)
        return [reading.rms(chosen), *statistics(reading, chosen, ("max_1s", "slow", "l10"))]

    short = levels()
    counted = Counted(300_000, 2000.0)  # which has kept nothing
    monkeypatch.setattr("ehamj.estimate.counted.LONG", 0)
    monkeypatch.setattr("ehamj.estimate.spectrum.LONG", 0)
    monkeypatch.setattr("ehamj.estimate.steady.WHOLE", 0)
    tracemalloc.start()
    long = levels()
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    for one, other in zip(long, short, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12)  # sums over waves are in parts
    assert most < 70 * samples.size
