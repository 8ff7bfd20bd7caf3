"""Signals: values against closed forms, derivatives against the integral that must give the value back.

Gauss–Legendre with 12 points over a fifth of a period is exact to rounding, so a wrong derivative cannot hide behind a
difference quotient's own error.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehamj.series import Lines, Sampled
from ehamj.signals import Chirp, Faded, Multisine, Product, Signal, Step, Total, Zero

NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)

amplitudes = st.floats(1e-9, 10.0)
frequencies = st.floats(0.1, 300.0)
phases = st.floats(-10.0, 10.0)
moments = st.floats(0.0, 5.0)


def assert_consistent(signal: Signal, begin: float, end: float, size: float, tolerance: float = 1e-9) -> None:
    """The slope integrates to the value and the curvature to the slope; ``size`` is that of the signal's value.

    1e-9: rounding of the angle 2πft, at most 1e4 rad, is 2e-12 of the signal, of which an interval sees a fifth or so.
    """
    middle, half = 0.5 * (begin + end), 0.5 * (end - begin)
    edges, inner = signal.sample(np.array([begin, end])), signal.sample(middle + half * NODES)
    assert half * WEIGHTS @ inner.slope == pytest.approx(np.diff(edges.value)[0], abs=tolerance * size)
    assert half * WEIGHTS @ inner.curvature == pytest.approx(np.diff(edges.slope)[0], abs=tolerance * size / half)


@given(st.lists(st.tuples(amplitudes, frequencies, phases), min_size=1, max_size=4), moments)
def test_derivatives_of_a_multisine_belong_to_it(parts: list[tuple[float, float, float]], begin: float) -> None:
    a, f, p = np.array(parts).T
    assert_consistent(Multisine.of(a, f, p), begin, begin + 0.2 / f.max(), a.sum())


@given(amplitudes, frequencies, phases, moments)
def test_a_sine_is_the_turning_pointer_and_its_derivatives(
    amplitude: float, frequency: float, phase: float, moment: float
) -> None:
    omega = 2 * np.pi * frequency
    pointer = amplitude * np.exp(1j * (omega * moment + phase))
    found = Multisine.of(amplitude, frequency, phase).sample(np.array([moment]))
    expected = [(pointer * (1j * omega) ** n).imag for n in range(3)]
    scales = amplitude * omega ** np.arange(3)
    # 1e-11: the angle, up to 1e4 rad, is rounded to 2e-12 rad on either side.
    np.testing.assert_allclose([part[0] for part in found] / scales, expected / scales, rtol=0, atol=1e-11)


def test_a_multisine_broadcasts_one_amplitude_over_frequencies() -> None:
    times = np.linspace(0.0, 1.0, 50)
    both = Multisine.of(0.3, [3.0, 7.0], [0.1, 0.2]).sample(times)
    alone = Total((Multisine.of(0.3, 3.0, 0.1), Multisine.of(0.3, 7.0, 0.2))).sample(times)
    # The sum is taken in another order: a rounding of the second derivative, (2π·7)²·0.3 = 600.
    np.testing.assert_allclose(both, alone, rtol=0, atol=1e-12)


@given(st.integers(1, 10**6), st.sampled_from([1e-4, 1 / 3000, 1 / 4096, 3.3e-5, 0.01]))
def test_a_step_jumps_between_its_limits_at_the_rounded_time_of_a_step(count: int, timestep: float) -> None:
    step = Step(2.5, float(f"{count * timestep:.10f}"))  # as a user writes it, to 0.1 ns
    at = np.array([count - 1, count, count + 1]) * timestep
    np.testing.assert_array_equal(step.sample(at).value, [0.0, 2.5, 2.5])
    np.testing.assert_array_equal(step.sample(at, left=True).value, [0.0, 0.0, 2.5])


def test_a_step_has_no_slope_on_either_side() -> None:
    times = np.array([0.0, 1.0, 2.0])
    np.testing.assert_array_equal(Step(3.0, 1.0).sample(times)[1:], np.zeros((2, 3)))


chirps = st.builds(Chirp, amplitudes, frequencies, frequencies, st.floats(0.5, 5.0), st.floats(0.0, 2.0))


@given(chirps, st.floats(0.0, 0.99))
def test_derivatives_of_a_chirp_belong_to_it(chirp: Chirp, share: float) -> None:
    length = 0.2 / max(chirp.first, chirp.last)
    begin = chirp.start + share * (chirp.duration - length)
    if length < chirp.duration:
        assert_consistent(chirp, begin, begin + length, chirp.amplitude)


@given(chirps, st.floats(0.0, 0.99))
def test_a_chirp_sweeps_exponentially_between_its_frequencies(chirp: Chirp, share: float) -> None:
    at = chirp.sample(np.array([chirp.start + share * chirp.duration]))
    omega = 2 * np.pi * chirp.first * (chirp.last / chirp.first) ** share
    # The time lies up to 7 s from zero: its rounding moves the frequency by 1e-15 of itself.
    assert np.hypot(at.value[0], at.slope[0] / omega) == pytest.approx(chirp.amplitude, rel=1e-12)


@given(chirps, st.floats(0.0, 0.99))
def test_a_chirp_turns_as_often_as_its_mean_frequency_says(chirp: Chirp, share: float) -> None:
    ratio = chirp.last / chirp.first
    at = chirp.sample(np.array([chirp.start + share * chirp.duration]))
    mean = chirp.first * (np.expm1(share * np.log(ratio)) / np.log(ratio) if ratio != 1 else share)
    expected = chirp.amplitude * np.sin(2 * np.pi * mean * chirp.duration)
    # 1e-9: the angle is at most 1e4 rad, and the logarithm of nearly equal frequencies is good to 1e-14.
    assert at.value[0] == pytest.approx(expected, abs=1e-9 * chirp.amplitude)


@pytest.mark.parametrize("last", [10.0, np.nextafter(10.0, 11.0), 10.0 * (1 + 1e-12), 10.0 * (1 - 1e-9)])
def test_a_chirp_between_nearly_equal_frequencies_is_a_sine(last: float) -> None:
    times = np.linspace(0.0, 1.0, 100)
    found, sine = Chirp(1.0, 10.0, last, 2.0).sample(times), Multisine.of(1.0, 10.0).sample(times)
    # The frequencies differ by 1e-8 Hz at most: 1e-8 · 2π rad after a second.
    np.testing.assert_allclose(found.value, sine.value, rtol=0, atol=1e-7)


@given(st.integers(1, 10**5), st.integers(1, 10**5), st.sampled_from([1e-4, 1 / 3000, 3.3e-5]))
def test_a_chirp_has_its_limits_on_either_side_of_its_ends(count: int, length: int, timestep: float) -> None:
    begin, duration = (float(f"{k * timestep:.10f}") for k in (count, length))
    chirp = Chirp(1.0, 20.0, 33.0, duration, begin)
    at = np.array([count, count + length]) * timestep
    from_right, from_left = chirp.sample(at), chirp.sample(at, left=True)
    last = 2 * np.pi * np.array([20.0, 33.0])
    # A nanosecond of slack for the times of steps moves the sine by 2e-7 rad.
    assert from_right.slope[0] == pytest.approx(last[0], rel=1e-6)
    assert [from_left.slope[0], from_left.curvature[0]] == [0.0, 0.0]
    assert np.hypot(from_left.value[1], from_left.slope[1] / last[1]) == pytest.approx(1.0, rel=1e-6)
    assert [part[1] for part in from_right] == [0.0, 0.0, 0.0]


def test_a_chirp_is_silent_outside_its_time() -> None:
    chirp = Chirp(1.0, 5.0, 50.0, 2.0, start=1.0)
    np.testing.assert_array_equal(chirp.sample(np.array([0.0, 0.999999, 3.000001, 9.0])), np.zeros((3, 4)))


@given(st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6), st.floats(0.0, 1.0))
def test_samples_of_a_quintic_give_the_quintic_and_its_derivatives(coefficients: list[float], share: float) -> None:
    quintic = np.polynomial.Polynomial(coefficients)
    times = np.arange(11) / 10.0
    found = Sampled(10.0, quintic(times)).sample(np.array([share]))
    expected = [quintic.deriv(n)(share) if n else quintic(share) for n in range(3)]
    # A spline of degree five holds every quintic; each derivative multiplies the rounding by some ten per sample.
    for part, value, tolerance in zip(found, expected, (1e-13, 1e-11, 1e-9), strict=True):
        assert part[0] == pytest.approx(value, abs=tolerance)


def test_samples_reproduce_a_sine_at_the_order_of_a_quintic_spline() -> None:
    sine, times = Multisine.of(1.0, 3.0, 0.4), np.linspace(0.5, 1.5, 997)
    rates = np.array([30.0, 60.0, 120.0])
    errors = []
    for rate in rates:
        spline = Sampled(rate, sine.sample(np.arange(2 * rate + 1) / rate).value)
        errors.append([np.abs(a - b).max() for a, b in zip(spline.sample(times), sine.sample(times), strict=True)])
    orders = -np.polyfit(np.log(rates), np.log(errors), 1)[0]
    # Textbook: a spline of degree five is of sixth order, and each derivative loses one.
    assert np.all(orders > np.array([6.0, 5.0, 4.0]) - 0.3)


def test_four_samples_per_period_more_than_the_highest_frequency_needs_suffice() -> None:
    # Eight samples per period: four times what the sampling theorem asks, as the class advises.
    sine, times = Multisine.of(1.0, 10.0), np.linspace(0.3, 0.7, 401)
    spline = Sampled(80.0, sine.sample(np.arange(81) / 80.0).value)
    assert np.abs(spline.sample(times).value - sine.sample(times).value).max() < 2e-3


def test_samples_hold_their_ends_outside() -> None:
    spline = Sampled(10.0, np.linspace(2.0, 3.0, 11), start=1.0)
    found = spline.sample(np.array([0.0, 2.5]))
    np.testing.assert_allclose(found.value, [2.0, 3.0], rtol=1e-14)  # the spline's own rounding at its ends
    np.testing.assert_array_equal(found[1:], np.zeros((2, 2)))


lines = st.lists(st.tuples(st.integers(1, 40), amplitudes, phases), min_size=1, max_size=5)


def sum_of(parts: list[tuple[int, float, float]], period: float) -> tuple[Lines, Multisine]:
    """The same sum of sines twice: as lines on the grid of a period, and in closed form."""
    spectrum = np.zeros(41, complex)
    for k, amplitude, phase in parts:
        spectrum[k] += amplitude * np.exp(1j * (phase - 0.5 * np.pi))
    k, amplitude, phase = np.array(parts).T
    return Lines(period, spectrum), Multisine.of(amplitude, k / period, phase)


@given(lines, st.floats(0.5, 20.0), st.floats(-50.0, 50.0))
def test_lines_are_the_sines_that_they_stand_for(
    parts: list[tuple[int, float, float]], period: float, time: float
) -> None:
    found, sines = sum_of(parts, period)
    times = time + np.linspace(0.0, period, 30)
    top = 2 * np.pi * 40 / period  # eight samples per period of the 40th line, whether or not it is there
    for order, (one, other) in enumerate(zip(found.sample(times), sines.sample(times), strict=True)):
        # A quintic over h = 2π/8 of a period: h⁶/46080 of the value, and by derivative that times 4 to 30 per h.
        tolerance = (1e-5, 1e-4, 2e-3)[order] * top**order * sum(part[1] for part in parts)
        np.testing.assert_allclose(one, other, rtol=0, atol=tolerance)


@given(lines, st.floats(0.5, 20.0), st.integers(0, 500), st.floats(0.0, 0.8))
def test_derivatives_of_lines_belong_to_them(
    parts: list[tuple[int, float, float]], period: float, sample: int, share: float
) -> None:
    found, _ = sum_of(parts, period)
    step = period / 320  # 40 lines of eight samples; within one of them the signal is a polynomial
    begin = (sample + share) * step
    assert_consistent(found, begin, begin + 0.19 * step, sum(part[1] for part in parts))


def test_lines_repeat_after_their_period_and_before() -> None:
    found, _ = sum_of([(3, 1.0, 0.3), (40, 0.2, 1.0)], 7.0)
    times = np.linspace(0.0, 6.9, 100)
    for shift in (-14.0, 7.0, 70.0):
        for order, (one, other) in enumerate(zip(found.sample(times), found.sample(times + shift), strict=True)):
            # Times of 77 s are rounded to 1e-14 s.
            np.testing.assert_allclose(one, other, rtol=0, atol=1e-12 * 36.0 ** (order + 1))


@given(amplitudes, frequencies, phases, moments)
def test_derivatives_of_a_product_belong_to_it(amplitude: float, frequency: float, phase: float, begin: float) -> None:
    product = Product(Multisine.of(amplitude, frequency, phase), Multisine.of(1.0, 0.5 * frequency))
    assert_consistent(product, begin, begin + 0.1 / frequency, amplitude)


def test_a_fade_may_begin_later() -> None:
    sine, times = Multisine.of(1.3, 4.0, 0.7), np.linspace(0.0, 5.0, 101)
    late = Faded(sine, 1.0, 2.0).sample(times)
    np.testing.assert_array_equal(late.value[times <= 2.0], 0.0)
    np.testing.assert_array_equal(np.array(late)[:, times >= 3.0], np.array(sine.sample(times))[:, times >= 3.0])
    # Half way the quintic is a half.
    assert Faded(sine, 1.0, 2.0).sample(np.array([2.5])).value[0] == pytest.approx(0.5 * 1.3 * np.sin(20 * np.pi + 0.7))


@given(amplitudes, frequencies, phases, st.floats(0.05, 3.0))
def test_a_faded_signal_starts_at_rest(amplitude: float, frequency: float, phase: float, fade: float) -> None:
    found = Faded(Multisine.of(amplitude, frequency, phase), fade).sample(np.zeros(1))
    np.testing.assert_array_equal(found, np.zeros((3, 1)))


@given(amplitudes, frequencies, phases, st.floats(0.05, 3.0), st.floats(0.0, 1.0))
def test_derivatives_of_a_faded_signal_belong_to_it(
    amplitude: float, frequency: float, phase: float, fade: float, share: float
) -> None:
    length = min(0.2 / frequency, 0.5 * fade)
    begin = share * (fade - length)
    assert_consistent(Faded(Multisine.of(amplitude, frequency, phase), fade), begin, begin + length, amplitude)


def test_a_faded_signal_is_the_signal_afterwards() -> None:
    sine, times = Multisine.of(1.3, 4.0, 0.7), np.linspace(2.0, 5.0, 100)
    np.testing.assert_array_equal(Faded(sine, 2.0).sample(times), sine.sample(times))


def test_a_total_is_the_sum_of_its_parts_on_either_side_of_a_jump() -> None:
    sine, times = Multisine.of(1.0, 2.0), np.array([0.5, 1.0, 1.5])
    total = Total((sine, Step(2.0, 1.0), Step(-0.5, 1.5)))
    for left, jumps in ((False, [0.0, 2.0, 1.5]), (True, [0.0, 0.0, 2.0])):
        np.testing.assert_array_equal(total.sample(times, left).value, sine.sample(times).value + jumps)


def test_zero_is_zero() -> None:
    np.testing.assert_array_equal(Zero().sample(np.linspace(0, 1, 5)), np.zeros((3, 5)))
