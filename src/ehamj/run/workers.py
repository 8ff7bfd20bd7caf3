"""Threads that work through what comes from an iterator, item by item as they get free."""

import os
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import wait
from typing import TypeVar

from ehamj.interruption import pool_of

T = TypeVar("T")
R = TypeVar("R")

PATIENCE = 0.2
"""Time between two calls of what the caller wants to do meanwhile [s]."""


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def worked_through(
    items: Iterable[T], work: Callable[[int, T], R], threads: int, meanwhile: Callable[[], None] = lambda: None
) -> list[R]:
    """What ``work`` makes of each item and its number, in the items' order.

    An item is asked for when a thread is free for it, so that a generator is never ahead of the work.

    Args:
        items: what to work through.
        work: called on one of the threads.
        threads: how many.
        meanwhile: called now and then on the thread of the caller, and at the end.

    Raises:
        Exception: of the first item that failed; those that run then end, and no other begins.
    """
    queue, lock, stopped = enumerate(items), threading.Lock(), threading.Event()
    found: dict[int, R] = {}
    failures: dict[int, Exception] = {}

    def worker() -> None:
        while not stopped.is_set():
            with lock:
                number = len(found) + len(failures)  # where the iterator itself fails
                try:
                    number, item = next(queue)
                except StopIteration:
                    return
                except Exception as error:
                    failures[number] = error
                    stopped.set()
                    return
            try:
                found[number] = work(number, item)
            except Exception as error:
                failures[number] = error
                stopped.set()

    with pool_of(threads) as pool:
        running = [pool.submit(worker) for _ in range(threads)]
        try:
            while wait(running, timeout=PATIENCE).not_done:
                meanwhile()
            for one in running:
                one.result()  # where a pool that this one works for is asked to stop
        finally:  # as where the user interrupts
            stopped.set()
    meanwhile()
    if failures:
        raise failures[min(failures)]
    return [found[number] for number in sorted(found)]
