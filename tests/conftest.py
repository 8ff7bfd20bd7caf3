"""Shared fixtures; the rules that linear algebra takes one thread, and that no test leaves a callback in MuJoCo."""

import os
from collections.abc import Iterator

import pytest

# Tests run side by side, one process a core. BLAS, read at numpy's import, would start a thread a core in each, and
# threads that wait for each other by spinning slow large decompositions down tenfold.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from ehamj.mujoco.hold import installed


@pytest.fixture(autouse=True)
def _no_callback_left_behind() -> Iterator[None]:
    yield
    assert not any(installed().values()), "a MuJoCo callback was left installed"
