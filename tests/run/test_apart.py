"""Files written in processes beside each other: what is written, what fails, what is left behind."""

import os
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from ehamj import store
from ehamj.errors import InputError
from ehamj.result import load_result, written_whole
from ehamj.run import apart
from ehamj.run.apart import work_off
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

WAYS = [False, True]


@pytest.fixture(autouse=True)
def two_processors(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(apart, "processors", lambda: 2)


@pytest.mark.parametrize("own", WAYS)
def test_each_job_is_done_once_and_told(tmp_path: Path, own: bool) -> None:
    def job(number: int) -> None:
        with (tmp_path / str(number)).open("a") as file:
            file.write(f"{os.getpid()}\n")

    told: list[str] = []
    work_off([(f"file {k}", lambda k=k: job(k)) for k in range(9)], told.append, own)
    assert sorted(told) == [f"file {k}" for k in range(9)]
    lines = [(tmp_path / str(k)).read_text().splitlines() for k in range(9)]
    assert all(len(line) == 1 for line in lines)
    assert all((int(line[0]) != os.getpid()) == own for line in lines)


@pytest.mark.parametrize("own", WAYS)
def test_what_fails_is_raised_as_it_is_and_no_other_job_begins(tmp_path: Path, own: bool) -> None:
    def fails() -> None:
        raise InputError("floor.csv: is full of holes")

    def late() -> None:
        (tmp_path / "late").touch()

    waiting = threading.Event()
    jobs = [
        ("first", fails),
        ("second", lambda: waiting.wait(0.5) and None),
        ("third", lambda: waiting.wait(0.5) and None),
    ]
    with pytest.raises(InputError, match="full of holes"):
        work_off([*jobs, ("late", late)], lambda name: None, own)
    assert not (tmp_path / "late").exists()


def test_an_error_that_cannot_be_carried_over_says_what_it_was() -> None:
    class Own(Exception):
        pass

    def fails() -> None:
        raise Own("no room")

    with pytest.raises(RuntimeError, match="Own: no room"):
        work_off([("a", fails), ("b", lambda: None)], lambda name: None, apart=True)


def test_a_process_that_dies_is_no_success() -> None:
    with pytest.raises(RuntimeError, match="ended with 7"):
        work_off([("a", lambda: os._exit(7)), ("b", lambda: None)], lambda name: None, apart=True)


def test_what_processes_that_are_gone_had_begun_is_removed_and_the_result_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One process is killed while it writes, and the other, in the middle of its figures, stopped for that."""

    def shows(folder: Path, *_: Any) -> Iterator[tuple[str, Callable[[], None]]]:
        def dies() -> None:
            with written_whole(folder / "replay.rrd") as path:
                path.touch()
                while not list(folder.glob("figures/.*")):
                    threading.Event().wait(0.01)
                os._exit(7)

        def draws() -> None:
            (folder / "figures").mkdir()
            (folder / "figures" / "one.svg").touch()
            with written_whole(folder / "figures" / "two.svg") as path:
                path.touch()
                threading.Event().wait(60.0)

        yield "replay of it", dies
        yield "report of it", draws

    monkeypatch.setattr(store, "_shows", shows)
    off = {"report": False, "replay": False}
    result = simulate(parse_scenario({"duration": 0.01, "plates": "tied", "compare": [], "output": off}))
    written = store.write_run(tmp_path, {result.scenario.name: result}, apart=True)
    assert list(written.lost) == ["report and replay"]
    assert {path.name for path in tmp_path.iterdir()} == {"result.nc", "summary.json", "scenario.toml", "model.xml"}
    assert load_result(tmp_path).complete


def test_an_interruption_ends_the_processes(tmp_path: Path) -> None:
    def interrupted(name: str) -> None:
        raise KeyboardInterrupt

    def slow() -> None:
        (tmp_path / "began").write_text(str(os.getpid()))
        threading.Event().wait(60.0)

    def quick() -> None:
        while not (tmp_path / "began").is_file():
            threading.Event().wait(0.01)

    with pytest.raises(KeyboardInterrupt):
        work_off([("slow", slow), ("quick", quick)], interrupted, apart=True)
    with pytest.raises(ProcessLookupError):
        os.kill(int((tmp_path / "began").read_text()), 0)
