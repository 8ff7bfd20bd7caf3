"""What comes out depends on neither threads nor processes, nor on those that are lost."""

import multiprocessing
import os
import signal
import threading
import time
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from oracles.fake_studies import DEADLY, Drawn, Plain, done, machine, results, search

from ehamj.campaign.cluster import Dask
from ehamj.campaign.named_schedulers import scheduler_of
from ehamj.campaign.processes import Processes
from ehamj.campaign.schedulers import Losses, Threads
from ehamj.campaign.work import Block
from ehamj.errors import InputError, SimulationFailed
from ehamj.merits.merit import Design, Failed
from ehamj.run.workers import processors


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> pd.DataFrame:
    """On one thread, undisturbed."""
    folder = tmp_path_factory.mktemp("alone")
    done(folder)
    return results(folder)


@pytest.mark.parametrize("scheduler", ["threads:2", "processes:2"])
def test_results_are_equal_to_the_bit(tmp_path: Path, alone: pd.DataFrame, scheduler: str) -> None:
    done(tmp_path, scheduler=scheduler)
    pd.testing.assert_frame_equal(results(tmp_path), alone, check_exact=True)


def test_a_process_that_is_lost_loses_no_design(tmp_path: Path, alone: pd.DataFrame) -> None:
    done(tmp_path, search(space=Plain(deadly=str(tmp_path / "died"))), scheduler="processes:2")
    assert (tmp_path / "died").exists()
    pd.testing.assert_frame_equal(results(tmp_path), alone, check_exact=True)


def test_a_process_that_somebody_ends_loses_no_design(tmp_path: Path, alone: pd.DataFrame) -> None:
    others = set(multiprocessing.active_children())

    def end_one() -> None:
        while not (own := set(multiprocessing.active_children()) - others):
            time.sleep(0.002)
        pid = next(iter(own)).pid
        assert pid is not None
        os.kill(pid, signal.SIGKILL)

    killer = threading.Thread(target=end_one)
    killer.start()
    done(tmp_path, search(space=Plain(pause=0.01)), scheduler="processes:2")
    killer.join()
    pd.testing.assert_frame_equal(results(tmp_path), alone, check_exact=True)


def test_a_design_that_ends_its_process_is_the_only_one_that_fails(tmp_path: Path, alone: pd.DataFrame) -> None:
    done(tmp_path, search(space=Plain(deadly="always")), scheduler="processes:2")
    found = results(tmp_path)
    assert found["reason"][DEADLY].startswith("2 times, the process that computed it ended abruptly")
    pd.testing.assert_frame_equal(found.drop(DEADLY), alone.drop(DEADLY), check_exact=True)


def test_a_process_that_never_begins_is_no_designs_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ehamj.campaign.processes._begin", os.abort)
    with pytest.raises(SimulationFailed, match="end before they begin"):
        done(tmp_path, scheduler="processes:1")


def test_a_function_that_cannot_be_sent_is_refused(tmp_path: Path) -> None:
    stage = search(names=("own.mass",))
    with pytest.raises(InputError, match=r"'own\.mass': its function cannot be sent"):
        done(tmp_path, stage, scheduler="processes:1", functions={"mass": lambda scenario: 1.0})


def blocks(*sizes: int) -> list[Block]:
    numbers = iter(range(100))
    return [Block("search", tuple(Design(next(numbers), {}) for _ in range(size)), (None,) * size) for size in sizes]


def test_lost_blocks_are_tried_again_then_cut_then_given_up() -> None:
    losses, (one, other) = Losses(), blocks(2, 2)
    assert losses.lost(one, "gone") == ([one], [])
    assert losses.lost(other, "gone") == ([other], [])
    singles, rows = losses.lost(one, "gone")
    assert [single.first for single in singles] == [0, 1]
    assert not rows
    assert losses.lost(singles[0], "gone") == ([singles[0]], [])
    assert losses.lost(singles[0], "gone") == ([], [])
    found = losses.found(singles[1], singles[1].failed("of itself"))
    assert [row.failed for row in found] == [Failed("gone"), Failed("of itself")]
    assert losses.found(other, other.failed("as it is")) == other.failed("as it is")


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (None, Threads(processors())),
        ("threads:3", Threads(3)),
        ("processes", Processes(processors())),
        ("processes:4", Processes(4)),
        ("tcp://10.0.0.1:8786", Dask("tcp://10.0.0.1:8786")),
        (Threads(2), Threads(2)),
    ],
)
def test_schedulers_have_names(given: Any, expected: Any) -> None:
    assert scheduler_of(given) == expected


@pytest.mark.parametrize("given", ["thread", "threads:0", "10.0.0.1:8786", "", 3, object()])
def test_what_names_none_is_refused(given: Any) -> None:
    with pytest.raises(InputError, match="scheduler"):
        scheduler_of(given)


def test_nothing_is_computed_that_was_not_asked_for(tmp_path: Path) -> None:
    assert done(tmp_path, search(Drawn(number=3)), scheduler="processes:4").done == 3
    assert machine().law == "held"
