"""Fewer samples of a series: what is in it stays, and white noise stays white."""

import numpy as np
import pytest

from ehamj.identification.shifted import lost, thinned
from ehamj.identification.whiteness import whiteness


@pytest.mark.parametrize("factor", [2, 3, 4, 10])
def test_what_lies_below_the_filters_edge_stays_itself(factor: int) -> None:
    time = np.arange(400 * factor) / factor
    for cycles in (0.0, 0.05, 0.2, 0.36):  # per sample that stays
        whole = np.cos(2.0 * np.pi * cycles * time + 0.3)
        inner = slice(30, -30)
        assert thinned(whole, factor)[inner] == pytest.approx(whole[::factor][inner], abs=2e-3)
    assert lost(factor) <= 30 * factor


@pytest.mark.parametrize("factor", [2, 3, 10])
def test_white_noise_stays_white(factor: int) -> None:
    random = np.random.default_rng(factor)
    found = [whiteness(thinned(random.standard_normal(1500 * factor), factor)[30:-30]).probability for _ in range(60)]
    assert 0.3 < float(np.median(found)) < 0.7
    assert min(found) > 1e-3


def test_noise_that_is_not_white_is_told() -> None:
    random = np.random.default_rng(0).standard_normal(1500)
    assert not whiteness(random[1:] + 0.3 * random[:-1]).white
