"""A study that is killed at any moment, again and again, comes out as one that nobody disturbed."""

import contextlib
import multiprocessing
import random
import signal
import time
from pathlib import Path

import pandas as pd
import pytest
from oracles.fake_studies import Drawn, Plain, begun, done, results, search

from ehamj.campaign.store import STORE_FILE, reading
from ehamj.errors import InputError

pytestmark = pytest.mark.skipif(
    "fork" not in multiprocessing.get_all_start_methods(), reason="processes begin too slowly here"
)
KILLS = 30
PLAN, SPACE = Drawn(number=96, batch=40), Plain(pause=0.005)
"""Three batches, of five blocks each but the last."""


def whole_blocks(folder: Path) -> None:
    """Blocks that are there are whole, no design is there twice."""
    try:
        with reading(folder) as store:
            numbers = {row.number for row in store.rows()}
            assert store.count() == len(numbers)
    except InputError:  # killed before anything was stored
        return
    blocks = [range(batch + at, min(batch + at + 8, batch + 40, 96)) for batch in (0, 40, 80) for at in range(0, 40, 8)]
    assert all(numbers.isdisjoint(block) or numbers.issuperset(block) for block in blocks)


def test_kills_at_random_moments_lose_nothing(tmp_path: Path) -> None:
    began = time.monotonic()
    done(tmp_path / "undisturbed", search(PLAN, SPACE), scheduler="threads:2")
    whole = time.monotonic() - began
    expected = results(tmp_path / "undisturbed")
    moments, kills, studies = random.Random(19), 0, 0
    while kills < KILLS:
        folder, studies = tmp_path / str(studies), studies + 1
        while True:
            resume = (folder / STORE_FILE).exists()
            process = begun(folder, search(PLAN, SPACE), scheduler="threads:2", resume=resume)
            process.join(moments.uniform(0.0, 0.4 * whole) if kills < KILLS else None)
            process.kill()
            process.join()
            if process.exitcode == 0:
                break
            assert process.exitcode == -signal.SIGKILL
            kills += 1
            whole_blocks(folder)
        pd.testing.assert_frame_equal(results(folder), expected, check_exact=True)


def test_a_store_is_free_once_its_study_is_killed(tmp_path: Path) -> None:
    folder = tmp_path / "study"
    process = begun(folder, search(space=Plain(pause=0.5)))
    while True:
        with contextlib.suppress(InputError), reading(folder) as store:
            if store.said("holder"):
                break
        time.sleep(0.01)
    with pytest.raises(InputError, match=f"process {process.pid} on .* is at work on it; wait until it ends"):
        done(folder, search(space=Plain(pause=0.5)), resume=True)
    process.kill()
    process.join()
    assert done(folder, search(space=Plain(pause=0.5)), resume=True, hours=0.0).done < 64
