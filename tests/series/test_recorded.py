"""Straight lines and stairs through samples: values, slopes and limits by the definition."""

import numpy as np

from ehamj.series import Replayed, Stairs, Straight
from ehamj.signals import Array, Signal

VALUES = np.array([1.0, 3.0, 2.0, -1.0])
AT = 5.0 + np.array([-1.0, 0.0, 0.05, 0.1, 0.15, 0.25, 0.3, 0.4])


def sampled(signal: Signal, left: bool = False) -> tuple[Array, Array]:
    found = signal.sample(AT, left)
    assert not found.curvature.any()
    return found.value, found.slope


def test_straight_lines_go_through_the_samples_and_end_at_rest() -> None:
    line = Straight(10.0, VALUES, 5.0)
    value, slope = sampled(line)
    np.testing.assert_allclose(value, [1, 1, 2, 3, 2.5, 0.5, -1, -1], atol=1e-12)
    np.testing.assert_allclose(slope, [0, 20, 20, -10, -10, -30, 0, 0], atol=1e-12)
    value, slope = sampled(line, left=True)
    np.testing.assert_allclose(value, [1, 1, 2, 3, 2.5, 0.5, -1, -1], atol=1e-12)
    np.testing.assert_allclose(slope, [0, 0, 20, 20, -10, -30, -30, 0], atol=1e-12)


def test_stairs_jump_at_the_samples() -> None:
    stairs = Stairs(10.0, VALUES, 5.0)
    np.testing.assert_array_equal(sampled(stairs)[0], [1, 1, 1, 3, 3, 2, -1, -1])
    np.testing.assert_array_equal(sampled(stairs, left=True)[0], [1, 1, 1, 1, 3, 2, 2, -1])
    assert not sampled(stairs)[1].any()


def test_replayed_comes_later_and_larger() -> None:
    found = Replayed(Straight(10.0, VALUES, 0.0), -2.0, 5.0).sample(AT)
    np.testing.assert_allclose(found.value, [-2, -2, -4, -6, -5, -1, 2, 2], atol=1e-12)
    np.testing.assert_allclose(found.slope, [0, -40, -40, 20, 20, 60, 0, 0], atol=1e-12)
