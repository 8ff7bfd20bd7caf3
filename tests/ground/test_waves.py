"""Plane waves: each mount's own delay against the closed form, direction, and what a wave cannot carry."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ehamj.errors import InputError
from ehamj.ground import Motion
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.load import parse_scenario

AXES = ("x", "y", "z")
DEFAULT = np.array([(0.9, 0.6), (0.9, -0.6), (-0.9, 0.6), (-0.9, -0.6)])
NODES, WEIGHTS = np.polynomial.legendre.leggauss(12)


def motion_of(ground: dict[str, Any], positions: np.ndarray = DEFAULT) -> Motion:
    table = [{"name": name, "position": list(map(float, at))} for name, at in zip(MOUNTS, positions, strict=True)]
    return parse_scenario({"mount": table, "duration": 4.0, "ground": ground}).motion()


def sine(frequency: float = 20.0, **settings: Any) -> dict[str, Any]:
    return {"kind": "sine", "amplitude": 1e-6, "frequency": frequency, **settings}


speeds, directions = st.floats(20.0, 5000.0), st.floats(-720.0, 720.0)
quadrants = st.tuples(*(st.floats(0.1, 1.0) for _ in range(4)), *(st.floats(0.1, 0.75) for _ in range(4))).map(
    lambda a: np.column_stack([np.array(a[:4]) * [1, 1, -1, -1], np.array(a[4:]) * [1, -1, 1, -1]])
)


@given(speeds, directions, quadrants, st.sampled_from(AXES), st.floats(0.5, 100.0), st.floats(0.0, 5.0))
def test_each_mount_sees_the_motion_at_its_own_time(
    speed: float, direction: float, positions: np.ndarray, axis: str, frequency: float, time: float
) -> None:
    wave = {"speed": speed, "direction": direction}
    found = motion_of(sine(frequency, dof=axis, wave=wave), positions).sample(np.array([time]))
    angle = np.radians(direction)
    delay = (positions[:, 0] * np.cos(angle) + positions[:, 1] * np.sin(angle)) / speed
    omega = 2 * np.pi * frequency
    pointer = 1e-6 * np.exp(1j * omega * (time - delay))
    for order, part in enumerate(found):
        expected = np.zeros((4, 3))
        expected[:, AXES.index(axis)] = ((1j * omega) ** order * pointer).imag
        # 1e-11: the angle, up to 3e3 rad, is rounded to 1e-12 rad either way.
        np.testing.assert_allclose(part[0], expected, rtol=0, atol=1e-11 * 1e-6 * omega**order)


@pytest.mark.parametrize(("direction", "first"), [(0.0, "rear"), (180.0, "front"), (90.0, "right"), (-90.0, "left")])
def test_a_wave_reaches_the_side_that_it_comes_from_first(direction: float, first: str) -> None:
    shock = {"kind": "shock", "begin": 1.0, "wave": {"speed": 100.0, "direction": direction}}
    motion = motion_of(shock)
    # The mount plane's centre sees it at 1 s; by then only the side that it comes from has moved.
    moved = np.abs(motion.sample(np.array([1.0])).displacement[0, :, 2]) > 0
    assert {name for name, moves in zip(MOUNTS, moved, strict=True) if moves} == {n for n in MOUNTS if first in n}


def test_front_and_rear_move_in_anti_phase_where_half_a_wavelength_lies_between_them() -> None:
    heights = motion_of(sine(200.0 / (2 * 1.8), wave={"speed": 200.0})).sample(np.linspace(0, 1, 200)).displacement
    front, rear = heights[:, :2, 2], heights[:, 2:, 2]
    np.testing.assert_allclose(front, -rear, rtol=0, atol=1e-12 * 1e-6 * 350)  # rounding of an angle of 350 rad


def test_a_fast_wave_is_a_slab() -> None:
    times = np.linspace(0.0, 1.0, 100)
    wave = motion_of(sine(wave={"speed": 1e12})).sample(times)
    slab = motion_of(sine()).sample(times)
    for order, (one, other) in enumerate(zip(wave, slab, strict=True)):
        # Delays of 1e-12 s at 20 Hz: 1e-10 of the motion.
        np.testing.assert_allclose(one, other, rtol=0, atol=2e-10 * 1e-6 * (2 * np.pi * 20.0) ** order)


def assert_consistent(motion: Motion, begin: float, tolerance: float) -> None:
    """Velocity integrates to displacement and acceleration to velocity, over a tenth of a millisecond.

    Within ``tolerance`` of what the largest velocity (acceleration) of the whole motion would integrate to.
    """
    length = 1e-4
    edges, inside = (motion.sample(begin + length * part) for part in (np.array([0.0, 1.0]), 0.5 * (1 + NODES)))
    largest = [np.abs(part).max() for part in motion.sample(np.linspace(0.0, 4.0, 1000))]
    for value, slope, size in zip(edges[:2], inside[1:], largest[1:], strict=True):
        integral = 0.5 * length * np.tensordot(WEIGHTS, slope, axes=1)
        assert np.abs(integral - (value[1] - value[0])).max() <= tolerance * size * length


@given(speeds, directions, st.floats(0.0, 3.9))
def test_motion_of_a_wave_belongs_together_while_it_fades_in_and_after(
    speed: float, direction: float, begin: float
) -> None:
    lines = {"kind": "multisine", "frequencies": [3.0, 47.0], "velocities": [1e-5]}
    motion = motion_of({**lines, "fade_in": 2.0, "wave": {"speed": speed, "direction": direction}})
    # 1e-9: the angle, up to 1e3 rad, is rounded to 1e-13, and changes by 2e-3 or 3e-2 rad.
    assert_consistent(motion, begin, 1e-9)


@pytest.mark.parametrize("begin", [0.0, 0.1111, 0.4999, 2.7])
def test_motion_of_a_broadband_wave_belongs_together(begin: float) -> None:
    motion = motion_of({"kind": "broadband", "highest": 100.0, "wave": {"direction": 30.0}})
    # 1e-6: Gauss over a knot of a quintic spline, knots 1.25 ms apart, and over the end of the fade, a kink of the
    # third derivative.
    assert_consistent(motion, begin, 1e-6)


def test_a_wave_fades_in_at_all_mounts_together() -> None:
    motion = motion_of(sine(fade_in=1.0, wave={"speed": 5.0}))  # delays of ±0.18 s
    np.testing.assert_array_equal(motion.sample(np.zeros(1)), np.zeros((3, 1, 4, 3)))


def test_a_broadband_wave_is_the_same_motion_at_every_mount_but_later() -> None:
    motion = motion_of({"kind": "broadband", "fade_in": 0.0, "wave": {"speed": 50.0, "direction": 0.0}})
    times = np.linspace(0.5, 3.0, 301)
    front = motion.sample(times + 0.9 / 50.0).velocity[:, 0, 2]
    rear = motion.sample(times - 0.9 / 50.0).velocity[:, 2, 2]
    # Times of 3 s are rounded to 4e-16 s; the floor accelerates with 1e-1 m/s² at most.
    np.testing.assert_allclose(front, rear, rtol=0, atol=1e-16)


@pytest.mark.parametrize("speed", [50.0, 0.25])
def test_a_broadband_wave_moves_every_mount_all_the_time(speed: float) -> None:
    # At 0.25 m/s the front is 3.6 s late and the rear 3.6 s early.
    motion = motion_of({"kind": "broadband", "fade_in": 0.0, "wave": {"speed": speed, "direction": 0.0}})
    velocity = motion.sample(np.arange(4000) / 1000.0).velocity[:, :, 2]
    moved = np.abs(velocity.reshape(40, 100, 4)).max(axis=1)  # in each tenth of a second
    assert moved.min() > 1e-6


@pytest.mark.parametrize("dof", ["rx", "ry", "rz"])
def test_a_wave_carries_no_rotation(dof: str) -> None:
    with pytest.raises(InputError, match=rf"ground\.dof = '{dof}': a wave carries x, y or z"):
        motion_of(sine(dof=dof, wave={}))


@pytest.mark.parametrize(
    ("wave", "message"),
    [
        ({"speed": 0.0}, r"ground\.wave\.speed = 0\.0: must be greater than 0"),
        ({"speed": -200.0}, r"ground\.wave\.speed = -200\.0: must be greater than 0"),
        ({"speed": float("nan")}, r"ground\.wave\.speed = nan: must be a finite number"),
        ({"speed": "fast"}, r"ground\.wave\.speed = 'fast': must be a valid number"),
        (
            {"sped": 200.0},
            r"ground\.wave\.sped = 200\.0: unknown key; did you mean 'speed'\? allowed: speed, direction",
        ),
        (200.0, r"ground\.wave = 200\.0: must be a table"),
    ],
)
def test_bad_waves_are_named_with_their_value_and_what_is_allowed(wave: Any, message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        parse_scenario({"ground": {"kind": "sine", "wave": wave}})
