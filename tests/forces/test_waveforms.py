"""Forces over time: derivatives, impulses, jerk-limited moves, unbalance and random forces against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehamj.errors import InputError
from ehamj.forces.transients import Blows, Pieces
from ehamj.forces.vibrations import Rotating, random_force
from ehamj.signals import Signal
from ehamj.slides.scurve import jerk_limited


@pytest.mark.parametrize(
    ("signal", "begin", "end"),
    [
        (Blows(1000.0, 0.01, 0.1, 2, 0.05), 0.151, 0.159),
        (Rotating(0.02, 30.0, 0.8), 0.0, 1.0),
        (Rotating(0.02, 30.0, 0.8, quadrature=True), 0.0, 1.0),
        (Rotating(0.02, 30.0, 0.0), 0.0, 0.2),
        (random_force(3.0, 10.0, 80.0, 2.0, np.random.default_rng(0)), 0.1, 0.6),
    ],
    ids=["blow", "run-up", "quadrature", "turning", "random"],
)
def test_derivatives_belong_to_the_value(signal: Signal, begin: float, end: float) -> None:
    h = 1e-5
    time = np.arange(begin, end, h)
    value, slope, curvature = signal.sample(time)
    # Central differences: h²/6 of the third derivative, at most (ωh)² of the slope.
    np.testing.assert_allclose((value[2:] - value[:-2]) / (2 * h), slope[1:-1], rtol=0, atol=2e-4 * np.abs(slope).max())
    bend = (slope[2:] - slope[:-2]) / (2 * h)
    np.testing.assert_allclose(bend, curvature[1:-1], rtol=0, atol=2e-4 * np.abs(curvature).max())


def test_blows_have_their_impulse_and_come_when_stated() -> None:
    time = np.linspace(0.0, 1.0, 200_001)
    force = Blows(500.0, 0.004, 0.2, 3, 0.25).sample(time).value
    # The trapezoidal rule over 800 points of a half-sine: (π/800)²/12.
    assert np.trapezoid(force, time) == pytest.approx(3 * 2 * 500.0 * 0.004 / np.pi, rel=2e-6)
    starts = time[1:][(force[1:] > 0) & (force[:-1] == 0)]
    np.testing.assert_allclose(starts, [0.2, 0.45, 0.7], atol=2e-5)


@given(st.floats(1e-3, 2.0), st.floats(0.01, 2.0), st.floats(0.1, 20.0), st.floats(1.0, 1e4))
def test_a_move_ends_at_rest_at_its_place_within_its_limits(
    travel: float, velocity: float, acceleration: float, jerk: float
) -> None:
    times, a = jerk_limited(travel, velocity, acceleration, jerk)
    steps = np.diff(times)
    assert np.all(steps > 0)
    # Exact integrals of straight pieces.
    speed = np.concatenate([[0.0], np.cumsum(0.5 * (a[1:] + a[:-1]) * steps)])
    place = np.cumsum(speed[:-1] * steps + steps**2 * (2 * a[:-1] + a[1:]) / 6.0)[-1]
    assert abs(speed[-1]) <= 1e-7 * velocity
    assert place == pytest.approx(travel, rel=1e-6)
    assert speed.max() <= velocity * (1 + 1e-6)
    assert np.abs(a).max() <= acceleration * (1 + 1e-9)
    assert np.abs(np.diff(a) / steps).max() <= jerk * (1 + 1e-6)


def test_pieces_have_the_slope_of_the_side_that_is_asked_for() -> None:
    corner = np.array([1.0])
    signal = Pieces(np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, 0.0]))
    assert (signal.sample(corner).slope[0], signal.sample(corner, left=True).slope[0]) == (-1.0, 2.0)


def test_an_unbalance_at_speed_is_a_rotating_force_of_u_omega_squared() -> None:
    time = np.linspace(2.0, 3.0, 1001)
    one, other = (Rotating(0.05, 25.0, 1.0, q).sample(time).value for q in (False, True))
    expected = 0.05 * (2 * np.pi * 25.0) ** 2
    np.testing.assert_allclose(np.hypot(one, other), expected, rtol=1e-12)
    # It turns from the first direction to the second, by a whole turn in 40 ms.
    turned = np.unwrap(np.arctan2(other, one))
    assert turned[-1] - turned[0] == pytest.approx(2 * np.pi * 25.0, rel=1e-9)


def test_the_force_of_an_unbalance_is_minus_the_acceleration_of_its_mass() -> None:
    # r = u (cos φ, sin φ): second differences of the angle's own closed form, also in the run-up.
    rotor, h = Rotating(1.0, 12.0, 0.5), 2e-5
    time = np.arange(0.0, 0.6, h)
    phi = rotor.angle(time)[0]
    bend = np.diff(np.cos(phi), 2) / h**2
    np.testing.assert_allclose(rotor.sample(time).value[1:-1], -bend, rtol=0, atol=1e-4 * np.abs(bend).max())


def test_a_random_force_has_its_rms_and_its_band() -> None:
    signal = random_force(20.0, 10.0, 50.0, 4.0, np.random.default_rng(3))
    time = np.arange(0.0, 4.0, 1e-3)
    value = signal.sample(time).value
    # The spline of samples four and more times as dense as the highest frequency.
    assert np.sqrt(np.mean(value**2)) == pytest.approx(20.0, rel=1e-4)
    power = np.abs(np.fft.rfft(value)) ** 2
    frequency = np.fft.rfftfreq(time.size, 1e-3)
    inside = (frequency > 9.9) & (frequency < 50.1)
    assert power[inside].sum() > (1.0 - 1e-6) * power.sum()


def test_a_random_force_without_a_line_is_refused() -> None:
    with pytest.raises(InputError, match=r"^force: no line of a force that repeats after 1 s lies from first = 10\.05"):
        random_force(1.0, 10.05, 10.06, 1.0, np.random.default_rng(0))
