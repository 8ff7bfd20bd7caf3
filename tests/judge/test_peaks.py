"""Peaks beyond those of velocity, from the recorded motions."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from ehamj.judge.peaks import peaks_of
from ehamj.plant.mounts import MOUNTS
from ehamj.result import make_dataset


def test_a_foot_that_is_not_finite_leaves_no_peak_of_the_others() -> None:
    motion = np.zeros((32, 4, 3))
    motion[:, :, 1], motion[5, 3, 1], motion[7, 0, 2] = 0.5, -2.0, np.nan
    values = {"ground_acceleration": motion, "foot_acceleration": motion, "cg_acceleration": motion[:, 1]}
    dataset = make_dataset(np.arange(32) / 1e3, values, {}, {"mount": list(MOUNTS)})
    norm: Any = SimpleNamespace(kinds={("acceleration", "peak")}, swinging=frozenset())
    for rows, expected in ((32, [0.0, 2.0, np.nan]), (15, [np.nan] * 3)):
        found = peaks_of(dataset.isel(time=slice(rows)), 1e3, [norm]).levels["feet"]["acceleration", "peak"]
        np.testing.assert_array_equal(found, [expected])
