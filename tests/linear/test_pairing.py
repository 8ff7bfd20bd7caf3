"""Pairs against all there are, one by one."""

from itertools import combinations, permutations

import numpy as np

from ehamj.linear.pairing import best_pairs, likely_pairs, likeness


def test_the_best_pairs_of_any_number_are_those_of_all_there_are() -> None:
    random = np.random.default_rng(5)
    for k, m, count in ((3, 4, 3), (4, 3, 2), (4, 4, 4), (3, 5, 1)):
        like = random.uniform(0.0, 1.0, (k, m))
        sizes = {
            (rows, columns): float(np.prod([like[r, c] for r, c in zip(rows, columns, strict=True)]))
            for rows in combinations(range(k), count)
            for columns in permutations(range(m), count)
        }
        rows, columns = max(sizes, key=lambda pair: sizes[pair])
        assert best_pairs(like, count) == dict(zip(rows, columns, strict=True))


def test_a_mode_that_is_like_none_has_no_pair_and_frequency_tells_alike_shapes_apart() -> None:
    alike = np.array([[1.0, 1.0], [1.0, 1.0], [0.0, 0.0]])
    like = likeness(alike, np.array([11.0, 20.0, 21.0]), np.array([20.0, 10.0]), 0.3)
    np.testing.assert_allclose(like[0, 1], np.exp(-((np.log(1.1) / 0.3) ** 2)))
    assert likely_pairs(like) == {0: 1, 1: 0}
