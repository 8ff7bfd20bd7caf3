"""A search finds what is known to be best, keeps constraints, and bears designs that fail."""

from collections.abc import Callable

import numpy as np
import pytest
from oracles.sensitivity_cases import cube, hypervolume, zdt1

from ehamj.campaign.parameters import Space
from ehamj.campaign.plans.optimise import Optimise, as_numbers, directions
from ehamj.campaign.plans.plan import Goals, Told
from ehamj.campaign.spreads import Between, Listed
from ehamj.errors import InputError

Function = Callable[[np.ndarray], np.ndarray]


def none(points: np.ndarray) -> np.ndarray:
    """No constraints."""
    return np.zeros((len(points), 0))


def searched(
    space: Space, goals: Goals, objectives: Function, violations: Function = none, **settings: int
) -> tuple[np.ndarray, np.ndarray]:
    """All points of a search, and their objectives."""
    asked = Optimise(kind="optimise", **settings).batches(space, goals)
    points, found = [next(asked)], []
    while True:
        found.append(objectives(points[-1]))
        try:
            points.append(asked.send(Told(found[-1], violations(points[-1]))))
        except StopIteration:
            return np.vstack(points), np.vstack(found)


ONE, TWO = Goals([("f", 1.0)]), Goals([("f", 1.0), ("g", 1.0)])


def bowl(points: np.ndarray) -> np.ndarray:
    """Least at 0.3 of every parameter."""
    return ((points - 0.3) ** 2).sum(axis=1, keepdims=True)


def test_two_objectives_reach_the_front_of_zdt1() -> None:
    """The front leaves 0.21 + 2/3 before (1.1, 1.1); of 10 parameters at random, 6,400 designs leave none of it."""
    _, found = searched(cube(10), TWO, zdt1, population=64, generations=100)
    assert hypervolume(found, (1.1, 1.1)) > 0.995 * (0.21 + 2.0 / 3.0)


def test_one_objective_is_found_to_its_digits() -> None:
    points, found = searched(cube(5), ONE, bowl, population=40, generations=80)
    np.testing.assert_allclose(points[found[:, 0].argmin()], 0.3, atol=1e-3)


def test_what_is_to_be_highest_is_told_with_its_sign() -> None:
    points, found = searched(
        cube(2), Goals([("f", -1.0)]), lambda p: -p[:, :1] * p[:, 1:], population=20, generations=30
    )
    np.testing.assert_allclose(points[found[:, 0].argmin()], 1.0, atol=1e-2)


def test_a_constraint_is_kept_where_it_binds() -> None:
    """x₁ + x₂ is least at (½, ½) where x₁ x₂ must be at least ¼."""
    goals = Goals([("sum", 1.0)], [("product", 0.25, None)])

    def short(points: np.ndarray) -> np.ndarray:
        return 0.25 - points[:, :1] * points[:, 1:]

    points, found = searched(
        cube(2), goals, lambda p: p.sum(axis=1, keepdims=True), short, population=40, generations=60
    )
    kept = short(points)[:, 0] <= 0.0
    assert found[kept].min() == pytest.approx(1.0, abs=1e-3)


def test_violations_count_in_shares_of_their_bounds() -> None:
    """They are added up: one of small numbers must not vanish beside one of large ones."""
    goals = Goals([("f", 1.0)], [("small", None, 1e-6), ("large", 1e6, None), ("about nothing", 0.0, None)])
    told = Told(np.zeros((2, 1)), np.array([[0.5e-6, 0.5e6, 0.5], [-1.0, -1.0, -1.0]]))
    np.testing.assert_allclose(as_numbers(told, goals)[1], [[0.5, 0.5, 0.5, 0.0], [0.0, 0.0, 0.0, 0.0]])


def test_designs_that_fail_are_left_behind() -> None:
    """Beyond x₁ = 0.4 every design fails, and it would be better there."""

    def failing(points: np.ndarray) -> np.ndarray:
        found = ((points - 0.6) ** 2).sum(axis=1, keepdims=True)
        found[points[:, 0] > 0.4] = np.nan
        return found

    points, found = searched(cube(2), ONE, failing, population=20, generations=50)
    np.testing.assert_allclose(points[np.nanargmin(found)], [0.4, 0.6], atol=0.01)


def test_a_search_of_which_all_designs_fail_goes_to_its_end() -> None:
    points, _ = searched(cube(2), TWO, lambda p: np.full((len(p), 2), np.nan), population=8, generations=5)
    assert len(points) == 40


LETTERS = (Listed(values=("a", "b", "c", "d", "e")), "a")
WHOLE = (Between(low=0.0, high=20.0), 3)


@pytest.mark.parametrize("goals", [ONE, TWO], ids=["one", "two"])
def test_lists_and_integers_are_searched_beside_numbers(goals: Goals) -> None:
    space = cube(2, LETTERS, WHOLE)

    def cost(points: np.ndarray) -> np.ndarray:
        rows = space.values(points)
        own = [(row["x2"] != "d") + 0.01 * (row["x3"] - 13) ** 2 + (row["x0"] - 0.3) ** 2 for row in rows]
        return np.column_stack([own, own])[:, : len(goals.objectives)]

    points, found = searched(space, goals, cost, population=30, generations=40)
    best = space.values(points)[found[:, 0].argmin()]
    assert (best["x2"], best["x3"]) == ("d", 13)


def test_no_design_of_a_small_space_comes_twice_and_the_best_one_comes() -> None:
    space = cube(0, LETTERS, WHOLE)
    points, found = searched(space, ONE, lambda p: p.sum(axis=1, keepdims=True), population=8, generations=40)
    assert len(np.unique(points, axis=0)) == len(points) <= 5 * 21
    assert space.values(points)[found[:, 0].argmin()] == {"x0": "a", "x1": 0}


def test_four_objectives_spread_over_their_front() -> None:
    """On the front of DTLZ2 (Deb, Thiele, Laumanns and Zitzler) the objectives lie on the unit sphere."""

    def dtlz2(points: np.ndarray) -> np.ndarray:
        turn, radius = 0.5 * np.pi * points[:, :3], 1.0 + ((points[:, 3:] - 0.5) ** 2).sum(axis=1)
        cos, sin = np.cos(turn), np.sin(turn)
        parts = [cos.prod(axis=1), cos[:, 0] * cos[:, 1] * sin[:, 2], cos[:, 0] * sin[:, 1], sin[:, 0]]
        return np.column_stack(parts) * radius[:, None]

    goals = Goals([(name, 1.0) for name in "abcd"])
    _, found = searched(cube(6), goals, dtlz2, population=60, generations=40)
    last = found[-60:]
    assert np.median(np.linalg.norm(last, axis=1)) < 1.05
    assert np.all(np.ptp(last, axis=0) > 0.8)


@pytest.mark.parametrize(("most", "number"), [(8, 4), (60, 56), (100, 84)])
def test_there_are_as_many_directions_as_a_population_has_room_for(most: int, number: int) -> None:
    found = directions(4, most)
    assert found.shape == (number, 4)
    np.testing.assert_allclose(found.sum(axis=1), 1.0)


def test_a_search_for_nothing_is_refused() -> None:
    with pytest.raises(InputError, match=r"needs \[objectives\]"):
        next(Optimise(kind="optimise").batches(cube(2), Goals()))
