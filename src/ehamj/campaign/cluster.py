"""Blocks of designs on a cluster that Dask runs: each task is one block."""

import importlib.util
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from typing import Any, Final

from ehamj.campaign.schedulers import AHEAD, Computed, Losses, Rows, Say, Scheduler
from ehamj.campaign.work import Block, Work, evaluate
from ehamj.errors import InputError, SimulationFailed

PATIENCE: Final = 10.0
"""How long a scheduler may take to answer [s]."""
LOOK: Final = 2.0
"""Time between two looks whether the cluster has workers, where nothing comes [s]."""
WAITING: Final = "waits for workers of the cluster"


def is_dask(given: Any) -> bool:
    """Whether something is a client or a cluster of Dask's."""
    return hasattr(given, "scheduler_info") or hasattr(given, "scheduler_address")


@dataclass(frozen=True)
class Dask(Scheduler):
    """The workers of a Dask scheduler: its address, a ``distributed.Client``, or a cluster object of any kind."""

    given: Any

    @contextmanager
    def running(self, say: Say) -> Iterator[Computed]:
        """A client, which is closed if it is ours."""
        if importlib.util.find_spec("distributed") is None:
            raise InputError(
                f"scheduler {self.given!r}: needs Dask, which is not installed here: pip install 'ehamj[dask]'"
            )
        from distributed import Client

        if isinstance(self.given, Client):
            yield lambda work, blocks: _computed(self.given, work, blocks, say)
            return
        try:
            client = Client(self.given, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise InputError(
                f"scheduler {str(self.given)!r}: no Dask scheduler answers there: {str(error) or type(error).__name__}"
            ) from error
        try:
            yield lambda work, blocks: _computed(client, work, blocks, say)
        finally:
            with suppress(Exception):  # one that is gone cannot be told
                client.close(timeout=PATIENCE)


def _computed(client: Any, work: Work, blocks: Iterator[Block], say: Say) -> Rows:
    from distributed import KilledWorker

    losses, again = Losses(), list[Block]()
    running: dict[Any, Block] = {}
    try:
        while True:
            room = max(AHEAD * sum(client.nthreads().values()), AHEAD) - len(running)
            now, again = again[: max(room, 0)], again[max(room, 0) :]
            for block in (*now, *islice(blocks, max(room - len(now), 0))):
                # A key of its own each time: what was lost is no answer to what is asked again.
                running[client.submit(evaluate, work, block, pure=False)] = block
            if not running:
                return
            for one in _finished(client, list(running), say):
                block = running.pop(one)
                error = one.exception()
                if isinstance(error, KilledWorker):  # Dask itself has tried it some times
                    more, rows = losses.lost(block, f"the workers that computed it were lost ({_told(error)})")
                    again += more
                elif error is not None:
                    raise error
                else:
                    rows = losses.found(block, one.result())
                if rows:
                    yield rows
    finally:
        if running:
            with suppress(Exception):  # where the scheduler is gone
                client.cancel(list(running), force=True)


def _finished(client: Any, futures: list[Any], say: Say) -> list[Any]:
    """Which are done, once some are.

    Raises:
        SimulationFailed: if the scheduler is gone.
    """
    from concurrent.futures import FIRST_COMPLETED, CancelledError

    from distributed import wait

    waiting = False
    while True:
        try:
            done = list(wait(futures, timeout=LOOK, return_when=FIRST_COMPLETED).done)
            break
        except TimeoutError:
            lost = client.status != "running"
            if not lost and waiting != (waiting := not client.nthreads()):
                say(WAITING if waiting else "")
        except CancelledError:
            lost = True
        if lost:
            raise SimulationFailed("the Dask scheduler is gone, or it gave the study up; what is done is stored")
    if waiting:
        say("")
    return done


def _told(error: Any) -> str:
    return str(error).splitlines()[0].split(". ")[0]
