"""Figures that threads draw at the same time are those that one draws alone."""

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ehamj import plots


def _drawn(number: int) -> str:
    values = np.array([0.1, 1.0, 10.0]) * (1 + number % 2)
    curve = plots.Levels("machine", np.array([1.0, 10.0, 100.0]), values, plots.BLUE)
    return plots.svg(plots.levels("Levels", [curve], "velocity [µm/s]"), "levels")


def test_threads_do_not_take_the_style_from_each_other() -> None:
    alone = [_drawn(0), _drawn(1)]
    often = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        with ThreadPoolExecutor(4) as pool:
            together = list(pool.map(_drawn, range(16)))
    finally:
        sys.setswitchinterval(often)
    assert together == alone * 8
