"""The clock of samples: rates out of rounded times, gaps, wandering clocks, and what is not believed."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehamj.records.clock import FEW, clock, on_grid, plainest

TAU = 2 * np.pi


def rounded(time: np.ndarray, resolution: float) -> np.ndarray:
    return np.round(time / resolution) * resolution


@given(
    st.one_of(st.integers(2, 60_000).map(float), st.decimals(2, 1000, places=2).map(float)),
    st.sampled_from([1e-2, 1e-3, 1e-4, 1e-6, 1e-7]),
    st.integers(200, 3000),
    st.floats(-1e4, 1e4),
    st.sampled_from([rounded, lambda t, q: np.floor(t / q) * q]),
)
def test_the_rate_explains_all_rounded_times(
    rate: float, resolution: float, size: int, begin: float, put: Callable[[np.ndarray, float], np.ndarray]
) -> None:
    duration = (size - 1) / rate
    if resolution > 0.005 * duration:
        return
    time = put(begin + np.arange(size) / rate, resolution)
    if 0 < round((time[-1] - time[0]) / resolution) - (size - 1) <= FEW:
        return  # as well the times of a clock of just the resolution, with a gap or two: they are taken so
    found, index, notes = clock(time, "a", "error", resolution)
    # A rate that moves the last time by one and a bit of the resolution, to either side, explains the times no more.
    assert found == pytest.approx(rate, rel=2.1 * resolution / duration + 1e-9)
    np.testing.assert_array_equal(index, np.arange(size))
    assert all("rounded" in note for note in notes)


@pytest.mark.parametrize(("rate", "resolution"), [(3200.0, 1e-4), (51200.0, 1e-6), (1024.0, 1e-3), (400 / 3, 1e-3)])
def test_plain_rates_come_out_exactly(rate: float, resolution: float) -> None:
    found, _, notes = clock(rounded(np.arange(12800) / rate, resolution), "a", "error", resolution)
    # 400/3 Hz is no plain number, and its step of 7.5 ms is.
    assert found == rate
    assert notes == [f"record a: times are rounded to {resolution:g} s; {rate:.10g} Hz explains all of them"]


def test_a_stated_rate_that_explains_the_times_is_taken() -> None:
    time = rounded(np.arange(100) / 256.13, 1e-3)
    assert clock(time, "a", "error", 1e-3, stated=256.13)[0] == 256.13
    assert clock(time, "a", "error", 1e-3, stated=300.0)[0] != 300.0


@given(st.integers(10, 2000), st.data())
def test_gaps_are_where_samples_are_missing(size: int, data: st.DataObject) -> None:
    rate = data.draw(st.sampled_from([3200.0, 500.0, 100.0, 1 / 0.003]))
    resolution = data.draw(st.sampled_from([1e-4, 1e-5, 1e-7]))
    keep = np.ones(size + 40, bool)
    for _ in range(data.draw(st.integers(1, 3))):
        at = data.draw(st.integers(1, size))
        keep[at : at + data.draw(st.integers(1, 8))] = False
    true = np.flatnonzero(keep)
    if true.size < 3 * (true[-1] + 1 - true.size) or keep[:20].sum() < 10:
        return
    found, index, notes = clock(rounded(true / rate, resolution), "a", "interpolate", resolution)
    assert found == pytest.approx(rate, rel=0.02)
    np.testing.assert_array_equal(index, true - true[0])
    assert sum("filled with straight lines" in note for note in notes) == 1


def test_times_as_coarse_as_steps_may_have_gaps_and_many_are_refused() -> None:
    whole = 1e-3 * np.delete(np.arange(2000), range(500, 600))  # 1 kHz in whole milliseconds
    found, index, _ = clock(whole, "a", "interpolate", 1e-3)
    assert found == 1000.0
    np.testing.assert_array_equal(index, np.delete(np.arange(2000), range(500, 600)))
    # One missing sample, too: a clock of 99.95 Hz would explain the times without.
    found, index, _ = clock(np.delete(np.arange(2000), 500) / 100.0, "a", "interpolate", 1e-2)
    assert (found, index[-1]) == (100.0, 1999.0)
    assert clock(rounded(np.arange(2000) / 990.0, 1e-3), "a", "error", 1e-3)[0] == pytest.approx(990.0, rel=1e-3)
    coarse = rounded(np.delete(np.arange(2000), range(500, 600)) / 800.0, 1e-3)
    with pytest.raises(
        ValueError, match=r"rounded to 0\.001 s, of steps of 0\.001\d* s.* gaps cannot be placed; resample"
    ):
        clock(coarse, "a", "interpolate", 1e-3)


def wandering(size: int, depth: float = 0.02) -> np.ndarray:
    time = np.cumsum(1 / 400.0 * (1 + depth * np.sin(np.arange(size) / 300.0)))
    return np.round(time - time[0], 7)


@pytest.mark.parametrize(
    # Measured: 2e-9, 2.3e-6, 2.5e-4 and 6e-3 of the amplitude; with room for the place of the beats.
    ("frequency", "loss"),
    [(10.0, 1e-8), (40.0, 1e-5), (80.0, 5e-4), (120.0, 1e-2)],
)
def test_a_wandering_clock_is_resampled(frequency: float, loss: float) -> None:
    time = wandering(4000)
    rate, index, notes = clock(time, "a", "error", 1e-7)
    assert rate == pytest.approx(3999 / time[-1], rel=1e-3)
    found = on_grid(index, np.sin(TAU * frequency * time))
    even = TAU * frequency * np.arange(found.size) / rate
    basis = np.stack([np.sin(even), np.cos(even)], axis=1)[20:-20]
    sine, cosine = np.linalg.lstsq(basis, found[20:-20], rcond=None)[0]
    assert np.hypot(sine, cosine) == pytest.approx(1.0, abs=loss)
    assert abs(cosine) < loss  # no phase: a clock wrong by one step would give 0.16 at 10 Hz
    (note,) = notes
    # 2 % swing over 300 steps: 300 · 0.02 (1 − cos), less what the mean rate takes.
    assert "the clock wanders: times lie up to 0.029 s (12 steps) from even spacing" in note
    assert "resampled to 400 Hz" in note


def test_a_gap_of_a_wandering_clock_is_filled_with_a_straight_line() -> None:
    time = wandering(4000)
    keep = np.delete(np.arange(4000), range(1000, 1010))
    with pytest.raises(ValueError, match=r"has 1 gap, 0\.025\d* s in total; .*the first before sample 1001"):
        clock(time[keep], "a", "error", 1e-7)
    rate, index, notes = clock(time[keep], "a", "interpolate", 1e-7)
    found = on_grid(index, time[keep])
    np.testing.assert_allclose(found, np.arange(found.size) / rate, atol=1e-7)  # a line stays a line
    assert len(notes) == 2


TIME = np.arange(1000) / 100.0


@pytest.mark.parametrize(
    ("time", "resolution", "message"),
    [
        (np.array([0.0]), 0.0, r"time must rise from row to row; it does not at line 1"),
        (np.array([0.0, np.inf, 1.0]), 0.0, r"time must rise .* line 2"),
        (np.insert(TIME, 500, TIME[500]), 1e-6, r"time must rise .* it does not at line 502"),
        (np.insert(TIME, 500, TIME[300]), 1e-6, r"time must rise .* it does not at line 501"),
        (
            TIME[:40] + 0.004 * np.cos(2.0 * np.arange(40)),
            1e-6,
            r"the step to line \d+ is 0\.\d+ steps longer or shorter",
        ),
        (
            rounded(TIME + 0.002 * np.cos(np.arange(1000)), 2e-3),
            2e-3,
            r"rounded to 0\.002\d* s.* too coarse to tell how",
        ),
        (rounded(np.arange(20) / 128.0, 1e-2), 1e-2, r"20 times that are rounded to 0\.01 s cannot tell the rate: it"),
    ],
)
def test_times_that_are_not_believed_are_refused_with_the_way_out(
    time: np.ndarray, resolution: float, message: str
) -> None:
    with pytest.raises(ValueError, match=rf"^ground\.file = 'a': .*{message}") as caught:
        clock(time, "a", "interpolate", resolution, where=lambda k: f"line {k + 1}", remedy="do this")
    assert "do this" in str(caught.value) or time.size < 4


@given(st.floats(1e-6, 1e6), st.floats(1e-9, 0.5))
def test_the_plainest_number_lies_between_and_has_the_fewest_digits(low: float, width: float) -> None:
    high = low * (1 + width)
    digits, value = plainest(low, high)
    assert low <= value <= high
    fewer = [float(f"{k}e{power}") for power in range(-8, 8) for k in range(1, 10)] if digits > 1 else []
    assert not any(low <= one <= high for one in fewer)
