"""Where blocks of designs are computed. What comes out depends on none of it."""

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, Final

from ehamj.campaign.rows import Row
from ehamj.campaign.work import Block, Work, evaluate
from ehamj.errors import InputError
from ehamj.interruption import pool_of
from ehamj.run.workers import processors

AHEAD: Final = 2
"""Blocks that are with a worker or wait for one, for each worker: none idles, and memory does not grow."""
TRIES: Final = 2
"""Times that a block is begun whose worker is lost; then its designs are tried one by one, as often."""

Rows = Iterator[list[Row]]
Computed = Callable[[Work, Iterator[Block]], Rows]
"""Takes blocks as workers get free for them, and gives the rows of each whole block, whichever is done first."""
Say = Callable[[str], None]
"""Called with what nothing goes on without, in words, and with nothing when it goes on."""


class Scheduler(ABC):
    """Computes blocks of designs."""

    @abstractmethod
    def running(self, say: Say) -> AbstractContextManager[Computed]:
        """Workers, while the block lasts; where it fails or is interrupted they stop as soon as they can.

        Raises:
            InputError: if there are none to be had.
        """


@dataclass(frozen=True)
class Threads(Scheduler):
    """Threads of this process."""

    count: int = field(default_factory=processors)

    @contextmanager
    def running(self, say: Say) -> Iterator[Computed]:
        """A pool of them."""
        with pool_of(self.count) as pool:

            def computed(work: Work, blocks: Iterator[Block]) -> Rows:
                running: set[Future[list[Row]]] = {
                    pool.submit(evaluate, work, block) for block in islice(blocks, AHEAD * self.count)
                }
                while running:
                    done, running = wait(running, return_when=FIRST_COMPLETED)
                    running |= {pool.submit(evaluate, work, block) for block in islice(blocks, len(done))}
                    for one in done:
                        yield one.result()

            yield computed


class Losses:
    """What becomes of blocks whose workers were lost: tried again, then design by design, then given up."""

    def __init__(self) -> None:
        self._lost: dict[tuple[int, int], int] = {}
        self._cut: dict[int, tuple[Block, dict[int, Row]]] = {}
        """The block that a design was of, and which of its rows are there."""

    def lost(self, block: Block, how: str) -> tuple[list[Block], list[Row]]:
        """What to do again now that a worker of this block is lost, and rows of a whole block if nothing is."""
        key = block.first, len(block.designs)
        self._lost[key] = self._lost.get(key, 0) + 1
        if self._lost[key] < TRIES:
            return [block], []
        if len(block.designs) > 1:
            whole: tuple[Block, dict[int, Row]] = block, {}
            self._cut |= dict.fromkeys((design.number for design in block.designs), whole)
            return block.single(), []
        return [], self.found(block, block.failed(f"{how}, {TRIES} times"))

    def found(self, block: Block, rows: list[Row]) -> list[Row]:
        """Rows of a whole block; none while designs are missing of one that was cut."""
        if block.first not in self._cut:
            return rows
        whole, known = self._cut[block.first]
        known[block.first] = rows[0]
        return [known[one.number] for one in whole.designs] if len(known) == len(whole.designs) else []


def scheduler_of(given: Any) -> Scheduler:
    """What a user names: nothing (threads), "threads", "threads:4", "processes", "processes:4", the address of a Dask
    scheduler, such as "tcp://10.0.0.1:8786", a Dask client or cluster, or a `Scheduler`.

    Raises:
        InputError: if it is none of these.
    """
    if isinstance(given, Scheduler):
        return given
    if given is None:
        return Threads()
    if isinstance(given, str):
        own = re.fullmatch(r"(threads|processes)(?::(\d{1,4}))?", given.strip())
        if own and (own[2] is None or int(own[2]) > 0):
            from ehamj.campaign.processes import Processes

            count = processors() if own[2] is None else int(own[2])
            return Threads(count) if own[1] == "threads" else Processes(count)
        if not re.fullmatch(r"[\w+-]+://\S+", given.strip()):
            raise InputError(
                f"scheduler {given!r}: must be threads, threads:N, processes, processes:N, or the address of a Dask "
                "scheduler, such as tcp://10.0.0.1:8786"
            )
        from ehamj.campaign.cluster import Dask

        return Dask(given.strip())
    from ehamj.campaign.cluster import Dask, is_dask

    if not is_dask(given):
        raise InputError(
            f"scheduler: must be a name, an address, or a Dask client or cluster, not {type(given).__name__}"
        )
    return Dask(given)
