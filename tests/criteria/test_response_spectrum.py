"""Response spectra: closed forms of oscillators, Smallwood's published filter, and an integrator."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from ehamj.criteria.response_spectrum import frequencies, oscillator, response_spectrum
from ehamj.estimate.bands import bands

RATE = 1000.0
DAMPING = 0.05


def test_natural_frequencies_are_third_octave_centres() -> None:
    np.testing.assert_allclose(frequencies(1.0, 100.0, 3), [band.centre for band in bands(1.0, 100.0)], rtol=1e-12)


@pytest.mark.parametrize("per_octave", [6, 12, 24])
def test_finer_frequencies_hold_the_coarser_ones(per_octave: int) -> None:
    fine = frequencies(1.0, 100.0, per_octave)
    np.testing.assert_allclose(fine[:: per_octave // 3], frequencies(1.0, 100.0, 3), rtol=1e-12)
    np.testing.assert_allclose(np.diff(np.log10(fine)), 0.3 / per_octave, rtol=1e-9)


@settings(max_examples=25)
@given(st.floats(0.5, 100.0), st.floats(0.001, 0.5))
def test_the_filter_of_absolute_acceleration_is_smallwoods(frequency: float, damping: float) -> None:
    # Smallwood 1981, An improved recursive formula for calculating shock response spectra.
    decay = damping * 2 * np.pi * frequency / RATE
    turn = 2 * np.pi * frequency / RATE * np.sqrt(1 - damping**2)
    e, share = np.exp(-decay), np.sin(turn) / turn
    numerator = [1 - e * share, 2 * e * (share - np.cos(turn)), e**2 - e * share]
    found = oscillator(frequency, damping, RATE)[1]
    # 1e-12: sums of numbers near one.
    np.testing.assert_allclose(found, [*numerator, 1.0, -2 * e * np.cos(turn), e**2], rtol=0, atol=1e-12)


@pytest.mark.parametrize("ratio", [0.25, 0.8, 1.0, 1.6])
def test_steady_vibration_gives_the_textbooks_transmissibility(ratio: float) -> None:
    driven, natural = 10.0, 10.0 / ratio
    time = np.arange(30000) / RATE
    wave = np.sin(2 * np.pi * driven * time)[:, None]
    found = response_spectrum(wave, RATE, np.array([natural]), DAMPING, begin=20000)  # the start has died out by 1e-11
    dynamic = np.hypot(1 - ratio**2, 2 * DAMPING * ratio)
    # 1e-3: ten samples per period flatten by sinc², 3e-4 at 10 Hz of 1 kHz; a peak between samples loses 5e-4.
    assert found.acceleration[0, 0] == pytest.approx(np.hypot(1, 2 * DAMPING * ratio) / dynamic, rel=1e-3)
    displacement = 1 / (2 * np.pi * natural) ** 2 / dynamic
    assert found.velocity[0, 0] == pytest.approx(2 * np.pi * natural * displacement, rel=1e-3)


@pytest.mark.parametrize("natural", [5.0, 20.0, 66.0])
def test_a_half_sine_pulse_gives_what_an_integrator_finds(natural: float) -> None:
    # The press of the floors: 15 ms; sampled at 10 kHz, so that straight lines follow it to 3e-6.
    rate, width, omega = 10000.0, 0.015, 2 * np.pi * natural

    def base(t: float) -> float:
        return float(np.sin(np.pi * t / width)) if 0 <= t < width else 0.0

    def rates(t: float, state: np.ndarray) -> list[float]:
        return [state[1], -base(t) - 2 * DAMPING * omega * state[1] - omega**2 * state[0]]

    times = np.arange(5000) / rate
    solved = solve_ivp(rates, (0.0, times[-1]), [0.0, 0.0], t_eval=times, max_step=2e-4, rtol=1e-9, atol=1e-15)
    absolute = -(omega**2) * solved.y[0] - 2 * DAMPING * omega * solved.y[1]
    pulse = np.array([base(t) for t in times])[:, None]
    found = response_spectrum(pulse, rate, np.array([natural]), DAMPING)
    assert found.velocity[0, 0] == pytest.approx(omega * np.abs(solved.y[0]).max(), rel=1e-4)
    assert found.acceleration[0, 0] == pytest.approx(np.abs(absolute).max(), rel=1e-4)


def test_a_stiff_oscillator_moves_with_its_base_and_a_soft_one_stays() -> None:
    # sin⁴ of a half period: one second, whose acceleration starts and ends smoothly; of 2 Hz at most.
    time = np.arange(20000) / RATE
    window, phase = (time > 1) & (time < 2), np.pi * (time - 1)
    moved = np.where(window, 1e-3 * np.sin(phase) ** 4, 0.0)
    curved = 1e-3 * np.pi**2 * (2 * np.cos(2 * phase) - 2 * np.cos(4 * phase))
    acceleration = np.where(window, curved, 0.0)[:, None]
    found = response_spectrum(acceleration, RATE, np.array([0.01, 100.0]), 0.02)
    # To the square of the ratio of frequencies: (2/100)² of the stiff one; the soft one yields by 2ζω·1 s.
    assert found.velocity[0, 0] / (2 * np.pi * 0.01) == pytest.approx(moved.max(), rel=0.01)
    assert found.acceleration[1, 0] == pytest.approx(np.abs(acceleration).max(), rel=1e-3)


def test_what_comes_before_does_not_count_but_moves_the_oscillators() -> None:
    knock = np.zeros((4000, 1))
    knock[100] = 1.0
    whole, late = (response_spectrum(knock, RATE, np.array([5.0]), DAMPING, begin=begin) for begin in (0, 2100))
    # 2 s are ten periods: ζω·2 s of decay, up to where in its period the peak is met.
    assert late.velocity[0, 0] / whole.velocity[0, 0] == pytest.approx(np.exp(-DAMPING * 2 * np.pi * 5 * 2), rel=0.1)


def test_channels_are_read_side_by_side() -> None:
    signals = np.random.default_rng(3).standard_normal((1000, 3))
    natural = np.array([2.0, 60.0])
    together = response_spectrum(signals, RATE, natural, DAMPING)
    for k in range(3):
        alone = response_spectrum(signals[:, [k]], RATE, natural, DAMPING)
        np.testing.assert_array_equal(together.velocity[:, [k]], alone.velocity)
        np.testing.assert_array_equal(together.acceleration[:, [k]], alone.acceleration)


def test_a_natural_frequency_too_high_for_the_samples_is_refused() -> None:
    with pytest.raises(ValueError, match=r"natural = 125 Hz must be at most 100 Hz"):
        response_spectrum(np.zeros((100, 1)), RATE, np.array([125.0]), DAMPING)
