"""Where blocks of designs are computed. What comes out depends on none of it."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from itertools import islice
from typing import Final

from ehamj.campaign.rows import Row
from ehamj.campaign.work import Block, Work, evaluate
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

    def __init__(self, tries: int = TRIES) -> None:
        self._tries = tries
        self._lost: dict[tuple[int, int], int] = {}
        self._cut: dict[int, tuple[Block, dict[int, Row]]] = {}
        """The block that a design was of, and which of its rows are there."""

    def lost(self, block: Block, how: str) -> tuple[list[Block], list[Row]]:
        """What to do again now that a worker of this block is lost (``how``), and rows of a whole block, if any are."""
        key = block.first, len(block.designs)
        self._lost[key] = self._lost.get(key, 0) + 1
        if self._lost[key] < self._tries:
            return [block], []
        if len(block.designs) > 1:
            whole: tuple[Block, dict[int, Row]] = block, {}
            self._cut |= dict.fromkeys((design.number for design in block.designs), whole)
            return block.single(), []
        return [], self.found(block, block.failed(how))

    def found(self, block: Block, rows: list[Row]) -> list[Row]:
        """Rows of a whole block; none while designs are missing of one that was cut."""
        if block.first not in self._cut:
            return rows
        whole, known = self._cut[block.first]
        known[block.first] = rows[0]
        return [known[one.number] for one in whole.designs] if len(known) == len(whole.designs) else []
