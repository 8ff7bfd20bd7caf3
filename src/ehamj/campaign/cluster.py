"""Blocks of designs on a cluster that Dask runs: each task is one block."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import islice
from typing import Any, Final

from ehamj.campaign.schedulers import AHEAD, Computed, Losses, Rows, Say, Scheduler
from ehamj.campaign.work import Block, Work, evaluate
from ehamj.errors import InputError, SimulationFailed
from ehamj.extras import check_extra

PATIENCE: Final = 10.0
"""How long a scheduler may take to answer [s]."""
LOOK: Final = 2.0
"""Time between two looks whether the cluster has workers, where nothing comes [s]."""
LOST: Final = (
    "one after the other, the workers that computed it were lost, as where it crashes them or takes too much memory"
)
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
        check_extra("distributed", f"scheduler {self.given!r}")
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
    from distributed import KilledWorker, as_completed

    losses, again = Losses(tries=1), list[Block]()  # Dask itself has tried it some times
    running: dict[Any, Block] = {}
    done = as_completed(loop=client.loop)
    try:
        while True:
            with _asked(client):
                room = max(AHEAD * sum(client.nthreads().values()), AHEAD) - len(running)
            # What was lost with its workers is computed with nothing beside it: whose fault it was is then known.
            now = islice(blocks, max(room, 0)) if not again else [again.pop(0)] if not running else []
            for block in now:
                # Not pure: what is asked again after a loss is not answered by what was lost.
                with _asked(client):
                    future = client.submit(evaluate, work, block, pure=False)
                    running[future] = block
                    done.add(future)
            if not running:
                return
            for future in _finished(client, done, say):
                block = running.pop(future)
                try:
                    with _asked(client):
                        rows = losses.found(block, future.result())
                except KilledWorker:
                    more, rows = losses.lost(block, LOST)
                    again += more
                if rows:
                    yield rows
    finally:
        if running:
            with suppress(Exception):  # where the scheduler is gone
                client.cancel(list(running), force=True)


@contextmanager
def _asked(client: Any) -> Iterator[None]:
    """Ask the scheduler something.

    Raises:
        SimulationFailed: if it is gone.
    """
    from concurrent.futures import CancelledError

    try:
        yield
    except Exception as error:
        if client.status == "running" and not isinstance(error, CancelledError):
            raise  # what the work itself says
        raise SimulationFailed(
            "the Dask scheduler is gone, or gave the study up; what is done is stored, and goes on where it is resumed"
        ) from error


def _finished(client: Any, done: Any, say: Say) -> list[Any]:
    """Futures that are done, once some are."""
    waiting = False
    while not done.has_ready():
        with done.thread_condition:
            done.thread_condition.wait_for(done.has_ready, LOOK)
        if client.status == "running" and waiting != (waiting := not done.has_ready() and _no_workers(client)):
            say(WAITING if waiting else "")
    if waiting:
        say("")
    return list(done.next_batch(block=False))


def _no_workers(client: Any) -> bool:
    with _asked(client):
        return not client.nthreads()
