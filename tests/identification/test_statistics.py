"""Deviations are those of the closed form also where a channel's level says a million times as much as its motion."""

import numpy as np
import pytest

from ehamj.identification.fit import Fitted
from ehamj.identification.noise import Noise
from ehamj.identification.problem import Linearised
from ehamj.identification.residual import Compared
from ehamj.identification.statistics import statistics
from ehamj.identification.unknowns import Unknown

SIZE, LEVEL, MOTION, NOISE = 2000, 1e3, 1e-4, 2e-3


def test_what_moves_a_level_is_told_by_the_motion_alone_where_the_offset_is_free() -> None:
    """y = (LEVEL + MOTION·sin) θ + o: θ is known to σ/√(Σ MOTION² sin²), and o LEVEL times so."""
    time = np.arange(SIZE) / SIZE
    level, motion = np.full(SIZE, LEVEL), MOTION * np.sin(40.0 * np.pi * time)
    error = NOISE * np.random.default_rng(1).normal(size=SIZE)
    seen = Compared("stroke", "m", "time", time, error, np.zeros(SIZE), np.full(SIZE, NOISE), {"t.o": np.ones(SIZE)})
    unknowns = (
        Unknown("mass", "kg", 1.0, -50.0, 50.0, size=1.0),
        Unknown("t.o", "m", 0.0, -np.inf, np.inf, test="t", size=1.0, closed=True),
    )
    slopes = np.column_stack([level + motion, np.ones(SIZE)])
    at = Linearised(np.zeros(2), (seen,), (slopes,), ("t",))
    found = statistics(Fitted(at, (Noise(np.full(SIZE, NOISE)),), 0.0, 1, "end"), unknowns, 1)
    expected = NOISE / np.sqrt(motion @ motion)
    spread = np.sqrt(np.diag(found.covariance))
    assert spread[0] == pytest.approx(expected, rel=1e-3)
    assert spread[1] == pytest.approx(LEVEL * expected, rel=1e-3)
    assert found.covariance[0, 1] / np.prod(spread) == pytest.approx(-1.0, abs=1e-6)
    assert not found.no_number[0]
