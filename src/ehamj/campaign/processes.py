"""Blocks of designs in processes of this computer, of which any may be lost."""

import multiprocessing
import os
import pickle
import signal
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any, Final

from ehamj.campaign.rows import Row
from ehamj.campaign.schedulers import TRIES, Computed, Losses, Rows, Say, Scheduler
from ehamj.campaign.work import Block, Work, evaluate
from ehamj.errors import InputError, SimulationFailed

STARTS: Final = 3
"""Times in a row that a process may be gone before its first block."""
GONE: Final = (
    f"{TRIES} times, the process that computed it ended abruptly, as one does that crashes, or that the system ends "
    "where memory runs out"
)


@dataclass(frozen=True)
class Processes(Scheduler):
    """Processes that share nothing with this one, each with one block at a time: where one is lost, it is known by
    which block."""

    count: int

    @contextmanager
    def running(self, say: Say) -> Iterator[Computed]:
        """As many of them, begun with their first block."""
        lanes = [_Lane() for _ in range(self.count)]
        try:
            yield lambda work, blocks: _computed(lanes, work, blocks)
        except BaseException:
            for lane in lanes:
                lane.kill()
            raise
        finally:
            for lane in lanes:
                lane.end()


def _computed(lanes: "list[_Lane]", work: Work, blocks: Iterator[Block]) -> Rows:
    _check_sent(work)
    losses, again = Losses(), list[Block]()
    running: dict[Future[list[Row]], tuple[_Lane, Block]] = {}
    idle = list(lanes)
    while True:
        while idle and (block := again.pop() if again else next(blocks, None)) is not None:
            lane = idle.pop()
            running[lane.submit(work, block)] = lane, block
        if not running:
            return
        done, _ = wait(running, return_when=FIRST_COMPLETED)
        for one in done:
            lane, block = running.pop(one)
            idle.append(lane)
            try:
                rows = losses.found(block, one.result())
            except BrokenProcessPool:
                more, rows = losses.lost(block, GONE) if lane.gone() else ([block], [])
                again += more
            if rows:
                yield rows


def _check_sent(work: Work) -> None:
    """Refuse work that no other process can be sent."""
    for name, own in work.functions.items():
        try:
            pickle.dumps(own)
        except Exception as error:
            raise InputError(
                f"merit {name!r}: its function cannot be sent to another process ({error}); define it in a module, "
                "not within a function or a notebook, or use threads"
            ) from error


class _Lane:
    """One process at a time, and how often in a row it could not begin."""

    def __init__(self) -> None:
        self._pool: ProcessPoolExecutor | None = None
        self._number: Future[int]
        self._starts = 0

    def submit(self, work: Work, block: Block) -> "Future[list[Row]]":
        """Begin a block, in a new process where there is none."""
        if self._pool is None:
            self._pool = ProcessPoolExecutor(1, _context(work.modules), _begin)
            self._number = self._pool.submit(os.getpid)
        return self._pool.submit(evaluate, work, block)

    def gone(self) -> bool:
        """Let go of a process that is lost; whether it had begun its block.

        Raises:
            SimulationFailed: if none begins.
        """
        assert self._pool is not None
        self._pool.shutdown()
        self._pool = None
        began = self._number.exception() is None
        self._starts = 0 if began else self._starts + 1
        if self._starts >= STARTS:
            raise SimulationFailed(
                "worker processes end before they begin; a script that uses them must do its work below "
                '`if __name__ == "__main__":`. What is done is stored; or use threads'
            )
        return began

    def kill(self) -> None:
        """End the process now, whatever it does."""
        if self._pool is not None and self._number.done() and self._number.exception() is None:
            with suppress(OSError):
                os.kill(self._number.result(), getattr(signal, "SIGKILL", signal.SIGTERM))

    def end(self) -> None:
        """End it when it has done what it does."""
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)
            self._pool = None


def _context(modules: Sequence[str]) -> Any:
    """How processes begin: where the system knows how, as copies of one that has imported everything and has no
    threads, which takes milliseconds; else from nothing, which takes seconds."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["ehamj.campaign.conduct", "ehamj.run.simulate", "xarray", *modules])
    return context


def _begin() -> None:
    """What a process does first: it leaves interruptions to the one that began it, and ends when that one does."""
    import warnings

    from ehamj.errors import DerivedAnew

    warnings.simplefilter("ignore", DerivedAnew)  # of each of thousands; the study says so once
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
