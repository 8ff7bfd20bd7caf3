"""How long something takes."""

import time
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray


def seconds(work: Callable[[], object]) -> float:
    """Wall time of some work [s]."""
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def interleaved(works: Mapping[str, Callable[[], object]], repetitions: int) -> dict[str, NDArray[np.float64]]:
    """Wall times of each work [s], (repetition,), taken in turn; a first round, which warms up, is left out."""
    times = [[seconds(work) for work in works.values()] for _ in range(repetitions + 1)]
    return dict(zip(works, np.array(times[1:]).T, strict=True))
