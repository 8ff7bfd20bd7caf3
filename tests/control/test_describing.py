"""Describing functions of valves behind the stage, against the textbook's closed forms, and what laws are left with."""

from typing import Any

import numpy as np
import pytest

from ehamj.control.describing import across, believed, describing
from ehamj.control.linearisation import NOTHING, Linearisation, made_good
from ehamj.plant.plant import Plant
from ehamj.scenario.load import parse_scenario

LAP = 0.4
REAL = {"overlap": [LAP] * 4, "hysteresis": 0.1, "threshold": 0.04, "null_offset": 0.1}
GRID = 2e-3
"""Of sums over 400 points of a cycle that has corners."""


def plant_of(**valve: Any) -> Plant:
    return parse_scenario({"actuators": {"isolator": valve}}).plant


def found(plant: Plant, amplitude: float, settings: Linearisation = NOTHING) -> complex:
    return complex(describing(settings.known(plant)[0], plant.actuators[0], amplitude)[0])


@pytest.mark.parametrize("amplitude", [0.5, 1.0, 3.0])
def test_a_dead_zone_is_the_textbooks(amplitude: float) -> None:
    r = LAP / amplitude
    expected = 1 - 2 / np.pi * (np.arcsin(r) + r * np.sqrt(1 - r**2))
    assert found(plant_of(overlap=[LAP] * 4), amplitude) == pytest.approx(expected, abs=GRID)


@pytest.mark.parametrize("amplitude", [0.2, 1.0])
def test_play_is_the_textbooks(amplitude: float) -> None:
    """Half a width b of hysteresis and threshold together (Gelb and Vander Velde, table B.1)."""
    b = 0.05 + 0.04
    beta = np.pi / 2 + np.arcsin(1 - 2 * b / amplitude)
    real = (beta - np.sin(beta) * np.cos(beta)) / np.pi
    expected = real - 4j * b / (np.pi * amplitude) * (1 - b / amplitude)
    assert found(plant_of(hysteresis=0.1, threshold=0.04), amplitude) == pytest.approx(expected, abs=2 * GRID)


def test_outside_the_overlap_a_known_valve_gives_what_is_wanted() -> None:
    whole = Linearisation()
    assert abs(found(plant_of(**REAL), 4.0, whole) - 1.0) < 0.01
    assert abs(found(plant_of(**REAL), 0.4, whole) - 1.0) < 0.1  # the band and the turning of the play
    assert abs(found(plant_of(**REAL), 0.4, NOTHING)) < 0.2


def test_of_an_ideal_valve_it_is_one() -> None:
    ideal = plant_of()
    assert found(ideal, 0.05, Linearisation()) == pytest.approx(1.0, abs=1e-12)
    assert list(across(Linearisation().known(ideal)[0], ideal.actuators[0], np.array([1.0]))) == ["as it is"]


def test_who_believes_too_much_of_the_overlap_has_too_much_gain() -> None:
    plant = plant_of(**REAL)
    known = Linearisation().known(plant)[0]
    gains = [abs(describing(believed(known, share), plant.actuators[0], 0.5)[0]) for share in (0.8, 1.0, 1.3)]
    assert gains[0] < 0.9 < gains[1] < 1.1 < gains[2]


def test_while_little_is_wanted_it_is_the_valve_about_one_of_its_edges() -> None:
    """Known exactly an edge passes one half of a cycle; too much of it is an offset until the cycle reaches its end."""
    plant = plant_of(overlap=[LAP] * 4)
    known, little = Linearisation().known(plant)[0], [0.01, 0.05, 0.1]
    np.testing.assert_allclose(describing(known, plant.actuators[0], little), 0.5, atol=GRID)
    overdone = believed(known, 1.3)
    np.testing.assert_allclose(describing(overdone, plant.actuators[0], little), 1.0, atol=GRID)
    never = overdone._replace(numbers=overdone.numbers._replace(quiet=0.0))
    assert abs(describing(never, plant.actuators[0], 0.1)[0]) > 1.9
    much = [0.3, 1.0]
    np.testing.assert_array_equal(*(describing(one, plant.actuators[0], much) for one in (overdone, never)))


def test_laws_are_left_with_the_valve_without_what_is_made_good() -> None:
    plant = plant_of(**REAL, flow_curve=[[0.0, 0.0], [0.5, 0.3], [1.0, 1.0]])
    assert made_good(plant, ()) == plant
    assert made_good(plant, NOTHING.known(plant)) == plant
    left = made_good(plant, Linearisation(null_offset=0.5).known(plant)).actuators[0]
    assert (left.overlap, left.hysteresis, left.threshold, left.flow_curve) == ((0.0,) * 4, 0.0, 0.0, ())
    assert left.null_offset == pytest.approx(0.05)
    kept = made_good(plant, Linearisation(overlap=0.0, flow_curve=False).known(plant)).actuators[0]
    assert (kept.overlap, len(kept.flow_curve)) == ((LAP,) * 4, 3)
