"""Random floors: the line spectrum over its own period, levels as read from a run, seeds, classes by name."""

from typing import Any

import numpy as np
import pytest
from scipy import signal

from ehamj.errors import InputError
from ehamj.ground import Motion
from ehamj.ground.lines import even_phases
from ehamj.scenario.load import parse_scenario

LEVEL = 20e-6
DURATION = 10.0
PERIOD = DURATION
"""The floor repeats after the run."""
RATE = 4000.0
"""Eight times the highest frequency: the floor's own samples, so that its displacement is read off exactly."""


def motion_of(duration: float = DURATION, seed: int = 0, **ground: Any) -> Motion:
    floor = {"kind": "broadband", "level": LEVEL, "fade_in": 0.0, **ground}
    return parse_scenario({"duration": duration, "seed": seed, "ground": floor}).motion()


def velocity_lines(motion: Motion, axis: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """Frequency [Hz] and peak velocity [m/s] of each line of the floor over its own period."""
    n = round(RATE * PERIOD)
    displacement = motion.sample(np.arange(n) / RATE).displacement[:, 0, axis]
    frequency = np.arange(n // 2 + 1) / PERIOD
    return frequency, 2 * np.pi * frequency * 2 / n * np.abs(np.fft.rfft(displacement))


def band_level(frequency: np.ndarray, power: np.ndarray, number: int) -> float:
    """RMS in the third octave around 1000·10^(number/10) Hz of lines of mean square ``power``.

    A line spreads over the distance to its neighbours, so that one at an edge counts by its share.
    """
    centre, width = 1000.0 * 10 ** (number / 10), frequency[1]
    low, high = centre * 10**-0.05, centre * 10**0.05
    share = np.clip(np.minimum(high, frequency + width / 2) - np.maximum(low, frequency - width / 2), 0.0, width)
    return float(np.sqrt(power @ share / width))


@pytest.mark.parametrize("seed", [0, 1])
def test_every_line_has_exactly_the_power_that_the_level_asks_for(seed: int) -> None:
    frequency, peak = velocity_lines(motion_of(seed=seed))
    flat = (frequency > 0.892) & (frequency < 89.1)
    # L in every third octave: a PSD of L²/(f·ln 10^0.1), of which a line holds a resolution's width.
    density = LEVEL**2 / (frequency[flat] * np.log(10) / 10)
    # 1e-8: displacement falls by 1e-6 from 1 to 500 Hz, and with it its rounding of 1e-16 counts.
    np.testing.assert_allclose(0.5 * peak[flat] ** 2 * PERIOD, density, rtol=1e-8)


@pytest.mark.parametrize("number", range(-20, -10))
def test_third_octaves_in_the_flat_part_are_at_the_level(number: int) -> None:
    frequency, peak = velocity_lines(motion_of())
    # 10 Hz holds 32 lines: a line's share at an edge, within which the PSD falls as 1/f, costs 1e-4.
    assert band_level(frequency, 0.5 * peak**2, number) == pytest.approx(LEVEL, rel=1e-3)


@pytest.mark.parametrize("fall", [0.0, 6.0, 12.0])
def test_third_octaves_above_fall_as_stated(fall: float) -> None:
    frequency, peak = velocity_lines(motion_of(last=80.0, fall=fall))
    levels = [band_level(frequency, 0.5 * peak**2, number) for number in (-9, -6)]  # 125 and 250 Hz
    # Three bands are 10^0.3, a hair less than an octave.
    assert 20 * np.log10(levels[0] / levels[1]) == pytest.approx(fall * 0.3 / np.log10(2), abs=0.01)


@pytest.mark.parametrize("rise", [0.0, 12.0, 24.0])
def test_third_octaves_below_rise_as_stated(rise: float) -> None:
    frequency, peak = velocity_lines(motion_of(first=40.0, last=80.0, rise=rise))
    levels = [band_level(frequency, 0.5 * peak**2, number) for number in (-17, -20)]  # 20 and 10 Hz
    assert 20 * np.log10(levels[0] / levels[1]) == pytest.approx(rise * 0.3 / np.log10(2), abs=0.02)


def test_nothing_moves_above_the_highest_frequency() -> None:
    frequency, peak = velocity_lines(motion_of(highest=500.0, last=400.0, fall=0.0))
    assert peak[frequency <= 500.0][-1] > 1e-7
    assert peak[frequency > 500.0].max() < 1e-12


@pytest.mark.parametrize("seed", range(3))
def test_levels_read_from_a_minute_are_those_stated(seed: int) -> None:
    velocity = motion_of(duration=60.0, seed=seed, highest=120.0).sample(np.arange(60000) / 1000).velocity[:, 0, 2]
    frequency, density = signal.periodogram(velocity, 1000.0, window="hann", detrend="constant")
    power = density * frequency[1]
    deviation = [20 * np.log10(band_level(frequency, power, number) / LEVEL) for number in range(-24, -10)]
    # With free phases the 37 lines of the 4 Hz band would be read to 1/√37 of their power, 0.7 dB, one in three times.
    assert np.abs(deviation).max() <= 1.0


@pytest.mark.parametrize(("duration", "wanted"), [(10.0, 10.0), (60.0, 60.0), (3.0, 12.0), (0.7, 10.5)])
def test_a_floor_repeats_after_the_run_or_some_runs_that_last_ten_seconds(duration: float, wanted: float) -> None:
    motion = motion_of(duration)
    times = np.linspace(0.0, 1.0, 100)
    one, other, earlier = (motion.sample(times + shift).velocity for shift in (0.0, wanted, 0.9 * wanted))
    # Times of 60 s are rounded to 1e-14 s, where the floor accelerates with 1e-1 m/s² at most.
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-14)
    assert np.abs(one - earlier).max() > 1e-5


def test_the_phases_of_a_floor_are_spread_evenly_and_differ_from_seed_to_seed() -> None:
    drawn = [np.concatenate(list(even_phases([1, 12, 80], np.random.default_rng(seed)))) for seed in range(2)]
    for phases in drawn:
        steps = np.exp(1j * np.diff(phases))
        # Unit pointers that are evenly spaced add up to nothing, band by band.
        assert abs(steps[:12].sum()) < 1e-12
        assert abs(steps[12:].sum()) < 1e-12
    assert np.abs(np.exp(1j * drawn[0]) - np.exp(1j * drawn[1])).max() > 0.1


def test_between_its_samples_the_floor_is_the_same_sum_of_lines() -> None:
    motion = motion_of()
    n = round(RATE * PERIOD)
    spectrum = 2 / n * np.fft.rfft(motion.sample(np.arange(n) / RATE).displacement[:, 0, 2])
    omega = 2 * np.pi * np.arange(spectrum.size) / PERIOD
    times = np.random.default_rng(5).uniform(0.0, DURATION, 50)
    found = motion.sample(times)
    # A quintic spline of eight samples per period of 500 Hz, where the floor is 1e-6 of itself.
    for order, tolerance in enumerate((1e-8, 1e-5, 1e-3)):
        lines = (1j * omega) ** order * spectrum
        expected = np.array([(lines * np.exp(1j * omega * t)).real.sum() for t in times])
        rms = np.sqrt(0.5 * (np.abs(lines) ** 2).sum())
        np.testing.assert_allclose(found[order][:, 0, 2], expected, rtol=0, atol=tolerance * rms)


# --- chance -------------------------------------------------------------------------------------------------------


def velocities(motion: Motion) -> np.ndarray:
    return motion.sample(np.arange(5000) / 500.0).velocity


def alikeness(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.abs(one @ other) / np.sqrt((one @ one) * (other @ other)))


def test_the_same_seed_gives_the_same_floor() -> None:
    np.testing.assert_array_equal(velocities(motion_of(seed=3)), velocities(motion_of(seed=3)))


# Of ten seconds of a floor in which a few lines at 1 Hz weigh most, chance makes 0.1 alike.


def test_another_seed_gives_another_floor() -> None:
    one, other = (velocities(motion_of(seed=seed))[:, 0, 2] for seed in (0, 1))
    assert alikeness(one, other) < 0.3


def test_axes_are_independent_of_each_other() -> None:
    x, y, z = velocities(motion_of(axes=["x", "y", "z"]))[:, 0].T
    assert max(alikeness(x, y), alikeness(y, z), alikeness(z, x)) < 0.3


def test_an_axis_does_not_depend_on_which_others_move() -> None:
    alone, together = (velocities(motion_of(axes=axes))[:, :, 2] for axes in (["z"], ["x", "z"]))
    np.testing.assert_array_equal(alone, together)


def test_parts_of_a_sum_are_independent_of_each_other() -> None:
    part = {"kind": "broadband", "level": LEVEL, "fade_in": 0.0}
    parts = parse_scenario({"duration": DURATION, "ground": {"kind": "sum", "parts": [part, part]}}).motion().parts
    one, other = (velocities(motion)[:, 0, 2] for motion in parts)
    assert alikeness(one, other) < 0.3


def test_axes_that_are_not_named_rest() -> None:
    np.testing.assert_array_equal(velocities(motion_of(axes=["x"]))[:, :, 1:], 0.0)


# --- what a user writes -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "level"),
    [("workshop", 800e-6), ("VC-A", 50e-6), ("VC-B", 25e-6), ("VC-C", 12.5e-6), ("VC-E", 3.12e-6), ("VC-G", 0.78e-6)],
)
def test_a_class_by_name_is_its_level(name: str, level: float) -> None:
    np.testing.assert_array_equal(velocities(motion_of(level=name)), velocities(motion_of(level=level)))


def test_a_floor_fades_in_from_rest() -> None:
    np.testing.assert_array_equal(motion_of(fade_in=0.5).sample(np.zeros(1)), np.zeros((3, 1, 4, 3)))


@pytest.mark.parametrize(
    ("ground", "message"),
    [
        ({"level": "VC-Z"}, r"ground: level = 'VC-Z' must be a velocity in m/s or one of workshop, office, .*VC-G"),
        ({"level": -1e-6}, r"ground: level = -1e-06 m/s must not be negative"),
        ({"level": float("nan")}, r"ground\.level = nan: must be a finite number"),
        ({"level": True}, r"ground\.level = True: must be a valid number"),
        ({"first": 90.0}, r"ground: first = 90, last = 80 and highest = 500 Hz must increase"),
        ({"highest": 80.0}, r"ground: first = 1, last = 80 and highest = 80 Hz must increase"),
        ({"first": 0.0}, r"ground\.first = 0\.0: must be greater than 0"),
        ({"fall": -3.0}, r"ground\.fall = -3\.0: must be greater than or equal to 0"),
        ({"axes": []}, r"ground\.axes = \[\]: must have at least 1 item"),
        ({"axes": ["rz"]}, r"ground\.axes\.0 = 'rz': .*must be 'x', 'y' or 'z'"),
    ],
)
def test_bad_input_is_named_with_its_value_and_what_is_allowed(ground: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        parse_scenario({"ground": {"kind": "broadband", **ground}})
