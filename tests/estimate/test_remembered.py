"""What was computed of the same samples before is found by their contents."""

import numpy as np
import pytest

from ehamj.estimate.remembered import remembered


def test_the_same_samples_are_computed_once() -> None:
    asked = []

    @remembered(2)
    def twice(samples: np.ndarray, factor: float) -> np.ndarray:
        asked.append(factor)
        return 2.0 * factor * samples

    samples = np.arange(4.0)
    first = twice(samples, 1.0)
    np.testing.assert_array_equal(twice(samples.copy(), 1.0), first)
    np.testing.assert_array_equal(twice(samples.reshape(2, 2), 1.0), first.reshape(2, 2))
    assert asked == [1.0, 1.0]
    with pytest.raises(ValueError, match="read-only"):
        first[0] = 1.0
    twice(samples, 3.0)
    twice(samples, 1.0)  # two are kept
    assert asked == [1.0, 1.0, 3.0, 1.0]


def test_what_failed_is_tried_again() -> None:
    outcomes = iter([ValueError("no"), 1])

    @remembered(2)
    def fails_once(samples: np.ndarray) -> int:
        found = next(outcomes)
        if isinstance(found, Exception):
            raise found
        return found

    with pytest.raises(ValueError, match="no"):
        fails_once(np.zeros(1))
    assert fails_once(np.zeros(1)) == 1
