"""Plane waves: each mount's own delay against the closed form, direction, and what a wave cannot carry."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ehamj.errors import InputError
from ehamj.ground import Motion
from ehamj.layout import MOUNTS
from ehamj.scenario import parse_scenario

settings.register_profile("untimed", deadline=None)  # machines stall
settings.load_profile("untimed")

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


@pytest.mark.parametrize(
    ("direction", "first", "last"),
    [(0.0, "rear", "front"), (180.0, "front", "rear"), (90.0, "right", "left"), (-90.0, "left", "right")],
)
def test_a_wave_reaches_the_side_that_it_comes_from_first(direction: float, first: str, last: str) -> None:
    shock = {"kind": "shock", "begin": 1.0, "wave": {"speed": 100.0, "direction": direction}}
    motion = motion_of(shock)
    # The mount plane's centre sees it at 1 s; by then only the side that it comes from has moved.
    moved = np.abs(motion.sample(np.array([1.0])).displacement[0, :, 2]) > 0
    assert {name for name, moves in zip(MOUNTS, moved, strict=True) if moves} == {n for n in MOUNTS if first in n}
    arrived = np.abs(motion.sample(np.array([1.0 + 0.9 / 100 + 1e-6])).displacement[0, :, 2]) > 0
    assert arrived.all(), last


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


@given(st.sampled_from(("sine", "multisine", "sweep", "broadband")), speeds, directions, st.floats(0.0, 3.9))
def test_motion_of_a_wave_belongs_together_while_it_fades_in_and_after(
    kind: str, speed: float, direction: float, begin: float
) -> None:
    ground: dict[str, Any] = {"kind": kind, "fade_in": 2.0, "wave": {"speed": speed, "direction": direction}}
    ground |= {"multisine": {"frequencies": [3.0, 47.0], "velocities": [1e-5]}, "broadband": {"highest": 100.0}}.get(
        kind, {}
    )
    motion = motion_of(ground)
    length = 1e-4  # of the broadband's spline, knots 1.25 ms apart, so that most intervals lie within one piece
    edges = motion.sample(np.array([begin, begin + length]))
    inside = motion.sample(begin + 0.5 * length * (1 + NODES))
    for value, slope in zip(edges[:2], inside[1:], strict=True):
        integral = 0.5 * length * np.tensordot(WEIGHTS, slope, axes=1)
        # Both are continuous: Gauss over a knot of a quintic spline, whose fourth derivative bends, is good to 1e-6.
        difference = np.abs(integral - (value[1] - value[0])).max()
        assert difference <= 1e-6 * np.abs(slope).max() * length + 1e-12 * np.abs(value).max()


def test_a_wave_fades_in_at_all_mounts_together() -> None:
    motion = motion_of(sine(fade_in=1.0, wave={"speed": 5.0}))  # delays of ±0.18 s
    np.testing.assert_array_equal(motion.sample(np.zeros(1)), np.zeros((3, 1, 4, 3)))


@pytest.mark.parametrize("speed", [50.0, 0.25])
def test_a_broadband_wave_is_the_same_motion_at_every_mount_but_later(speed: float) -> None:
    # At 0.25 m/s the front sees at 3 s what the rear will see 7.2 s earlier, 0.6 s before the beginning.
    motion = motion_of({"kind": "broadband", "fade_in": 0.0, "wave": {"speed": speed, "direction": 0.0}})
    times = np.linspace(0.5, 3.0, 301)
    front = motion.sample(times + 0.9 / speed).velocity[:, 0, 2]
    rear = motion.sample(times - 0.9 / speed).velocity[:, 2, 2]
    assert np.abs(rear).max() > 1e-6
    # Times of 4 s are rounded to 1e-15 s; the floor accelerates with 1e-2 m/s² at most.
    np.testing.assert_allclose(front, rear, rtol=0, atol=1e-16)


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
        ({"sped": 200.0}, r"ground\.wave\.sped = 200\.0: unknown key; did you mean 'speed'\? allowed: speed, direction"),
        (200.0, r"ground\.wave = 200\.0: must be a table"),
    ],
)
def test_bad_waves_are_named_with_their_value_and_what_is_allowed(wave: Any, message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        parse_scenario({"ground": {"kind": "sine", "wave": wave}})
