"""Lines of a record: their waves are computed once, or block by block where they are too many to keep."""

import numpy as np
import pytest

from ehamj import columns
from ehamj.estimate import steady
from ehamj.estimate.counted import Counted
from ehamj.estimate.steady import Waves, fitted


def test_waves_of_a_record_of_several_blocks_are_kept_and_fit_as_block_by_block(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(columns, "ROWS", 300)
    counted, lines = Counted(2001, 1000.0), np.array([17.3, 50.0])
    samples = np.cos(2 * np.pi * 17.3 * np.arange(2001) / 1000.0) + np.random.default_rng(1).standard_normal(2001)
    waves = Waves(lines, counted)
    ((rows, own),) = waves
    ((_, again),) = waves
    assert again is own
    assert own.shape == (4, rows.stop - rows.start)
    kept = fitted(samples, waves, counted)
    monkeypatch.setattr(steady, "WHOLE", 0)
    assert len(list(waves)) > 3
    for one, other in zip(fitted(samples, waves, counted), kept, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12)
