"""Pareto fronts by brute force, and which of their designs are best."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ehamj.campaign.best import best_of, front_of

FEW = st.integers(-2, 2).map(float) | st.just(float("nan"))


@given(arrays(float, st.tuples(st.integers(0, 12), st.integers(1, 3)), elements=FEW))
def test_the_front_is_what_nobody_beats(objectives: np.ndarray) -> None:
    def beaten(design: np.ndarray) -> bool:
        return any((other <= design).all() and (other < design).any() for other in objectives)

    expected = [bool(np.isfinite(one).all() and not beaten(one)) for one in objectives]
    assert front_of(objectives).tolist() == expected


def test_one_objective_is_sorted_and_bad_designs_are_left_out() -> None:
    objectives = np.array([[3.0], [1.0], [np.nan], [0.0], [2.0]])
    assert best_of(objectives, np.array([True, True, True, False, True]), 2) == [1, 4]
    assert best_of(objectives, np.zeros(5, bool), 2) == []
    assert best_of(np.zeros((5, 0)), np.ones(5, bool), 2) == []


def test_of_a_front_the_one_between_the_ends_is_best_whatever_the_units() -> None:
    front = np.array([[0.0, 1.0], [0.2, 0.3], [1.0, 0.0], [0.9, 0.9]]) * [1e6, 1e-6]
    assert best_of(front, np.ones(4, bool), 3) == [1, 0, 2]
    assert best_of(front, np.array([False, False, False, True]), 3) == [3]


def test_designs_that_lose_nothing_beside_a_named_one_come_first() -> None:
    front, good = np.array([[0.0, 1.0], [0.2, 0.3], [1.0, 0.0], [0.7, 0.1]]), np.ones(4, bool)
    assert best_of(front, good, 4) == [1, 3, 0, 2]
    assert best_of(front, good, 4, np.array([[0.8, 0.2]])) == [3, 1, 0, 2]
    assert best_of(front, good, 2, np.array([[0.8, 0.2], [np.nan, 0.0]])) == [3, 1]
    assert best_of(front, good, 1, np.array([[0.1, 0.1]])) == [1]
