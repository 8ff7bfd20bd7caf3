"""Readings of a rigid body with one mistake in them: it is named, and nothing where there is none."""

import numpy as np
import pytest

from ehamj.measured.rigid import misplaced

RANDOM = np.random.default_rng(4)
PLACES = np.array([(0.9, 0.6, 0.0), (0.9, -0.6, 0.0), (-0.9, 0.6, 0.1), (-1.0, -0.7, 1.8)])
POINTS, DIRECTIONS = np.repeat(PLACES, 3, axis=0), np.tile(np.eye(3), (4, 1))
NAMES = [f"{letter}{axis}" for letter in "ABCD" for axis in "xyz"]
MOTION = RANDOM.normal(size=(6, 40)) + 1j * RANDOM.normal(size=(6, 40))
# v + ω × p along each direction, by hand
EXACT = np.array([MOTION[k % 3] + np.cross(MOTION[3:].T, POINTS[k])[:, k % 3] for k in range(12)])
READ = EXACT + 0.03 * (RANDOM.normal(size=EXACT.shape) + 1j * RANDOM.normal(size=EXACT.shape))


@pytest.mark.parametrize(
    ("order", "signs", "said"),
    [
        (range(12), {}, ""),
        (range(12), {4: -1.0}, "if By is the wrong way round"),
        ([0, 1, 5, 3, 4, 2, *range(6, 12)], {}, "if Az and Bz are exchanged"),
        ([9, 10, 11, *range(3, 9), 0, 1, 2], {}, "the places of "),
        ([1, 0, *range(2, 12)], {}, "if Ax and Ay are exchanged"),
    ],
)
def test_one_mistake_is_named(order: list[int], signs: dict[int, float], said: str) -> None:
    readings = READ[list(order)].copy()
    for k, sign in signs.items():
        readings[k] *= sign
    found = misplaced(NAMES, POINTS, DIRECTIONS, readings)
    assert said in found
    assert bool(found) == bool(said)
    if "places" in said:
        assert "Ax, Ay, Az" in found
        assert "Dx, Dy, Dz" in found


def test_six_sensors_tell_nothing_and_a_part_that_bends_is_no_mistake_of_sensors() -> None:
    assert misplaced(NAMES[:6], POINTS[:6], DIRECTIONS[:6], -READ[:6]) == ""
    assert misplaced(NAMES, POINTS, DIRECTIONS, RANDOM.normal(size=(12, 40)).astype(complex)) == ""


def test_readings_of_nothing_tell_nothing() -> None:
    assert misplaced(NAMES, POINTS, DIRECTIONS, np.zeros((12, 3), complex)) == ""
    assert misplaced(NAMES, POINTS, DIRECTIONS, np.zeros((12, 0), complex)) == ""
