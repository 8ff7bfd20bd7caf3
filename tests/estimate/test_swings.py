"""Swings between zero crossings, whatever rest lies about them."""

import numpy as np
import pytest

from ehamj.estimate.swings import Swings

RATE = 1000.0
TIMES = np.arange(3000) / RATE


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("returns", [0.0, 1e-4])
def test_a_strike_from_rest_is_as_fast_as_its_half_period(sign: float, returns: float) -> None:
    """25 ms: 20 Hz, upward or downward, whether the floor rests afterwards or comes back."""
    pulse = np.where((TIMES > 1.0) & (TIMES < 1.025), 1e-2 * np.sin(np.pi * (TIMES - 1.0) / 0.025), 0.0)
    back = np.where((TIMES > 1.1) & (TIMES < 1.6), -returns, 0.0)
    found = Swings.of(sign * (pulse + back), RATE)
    assert found.frequency[0] == pytest.approx(20.0, rel=1e-9)
    assert found.peak[0] == pytest.approx(1e-2, rel=3e-3)  # the sample nearest to the top
    assert found.peak.size == (2 if returns else 1)  # rest is no swing


def test_every_swing_of_a_sine_is_of_its_frequency() -> None:
    found = Swings.of(np.sin(2 * np.pi * 10.0 * TIMES + 0.3), RATE)
    np.testing.assert_allclose(found.frequency[1:-1], 10.0, rtol=1e-3)  # crossings by straight lines
    np.testing.assert_allclose(found.peak[1:-1], 1.0, rtol=1e-3)


def test_what_never_crosses_zero_has_no_frequency() -> None:
    for motion in (np.zeros(50), np.ones(50)):
        assert np.isnan(Swings.of(motion, RATE).frequency).all()
