"""Work that holds the interpreter, such as drawing, done in processes of its own beside each other."""

import contextlib
import gc
import multiprocessing
import os
import pickle
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import as_completed
from multiprocessing import connection
from multiprocessing.process import BaseProcess
from typing import Any, Final

from ehamj.interruption import INTERRUPTING, pool_of
from ehamj.run.workers import processors

Job = Callable[[], None]
Failed = Callable[[str, Exception], None]

RARELY: Final = (50_000, 20, 100)
"""Thresholds of the garbage collector in a process that ends with its jobs: a figure is many small objects that refer
to each other, and looking for those that nobody needs took a sixth of the time that drawing does."""


def work_off(
    jobs: Sequence[tuple[str, Job]],
    finished: Callable[[str], None],
    apart: bool = False,
    failed: Callable[[str, Exception], None] | None = None,
) -> None:
    """Do jobs, which begin in order, as many at once as there are processors.

    Args:
        jobs: name and what is done; a job gives nothing back but what it wrote.
        finished: called with the name of each that is.
        apart: whether processes may do it, that know all that this one knows and share its memory: of a command, which
            knows what else runs beside it. A library's caller may have threads whose locks nobody would open there.
            They are forked, so that on systems where that is not safe threads do the jobs, as without ``apart``.
        failed: called with the name of a job that failed and its error; the others go on.

    Raises:
        Exception: without ``failed``, of the first job that failed; no other job begins, and none goes on.
        RuntimeError: if a process is gone before its job was done.
    """
    if not jobs:
        return
    count = min(processors(), len(jobs))
    own = apart and count > 1 and sys.platform == "linux" and threading.current_thread() is threading.main_thread()
    (_forked if own else _threaded)(jobs, finished, failed or _raised, count)


def _raised(name: str, error: Exception) -> None:
    raise error


def _threaded(jobs: Sequence[tuple[str, Job]], finished: Callable[[str], None], failed: Failed, count: int) -> None:
    with pool_of(count) as pool:
        running = {pool.submit(job): name for name, job in jobs}
        for one in as_completed(running):
            try:
                one.result()
            except Exception as error:
                failed(running[one], error)
            else:
                finished(running[one])


def _forked(jobs: Sequence[tuple[str, Job]], finished: Callable[[str], None], failed: Failed, count: int) -> None:
    context = multiprocessing.get_context("fork")
    taken = context.Value("i", 0)
    gc.collect()
    gc.freeze()  # what a collector has never looked at stays shared memory
    running: dict[connection.Connection, BaseProcess] = {}
    try:
        for _ in range(count):
            ours, theirs = context.Pipe(duplex=False)
            process: BaseProcess = context.Process(target=_work, args=(jobs, taken, theirs), daemon=True)
            with _uninterrupted(), warnings.catch_warnings():
                warnings.filterwarnings("ignore", "This process .* is multi-threaded", DeprecationWarning)
                process.start()
            theirs.close()
            running[ours] = process
        while running:
            for ready in connection.wait(list(running)):
                assert isinstance(ready, connection.Connection)
                try:
                    name, failure = ready.recv()
                except EOFError:
                    process = running.pop(ready)
                    process.join()
                    if process.exitcode:
                        raise RuntimeError(f"a process that wrote files ended with {process.exitcode}") from None
                    continue
                if failure is not None:
                    failed(name, failure)
                else:
                    finished(name)
    finally:
        for process in running.values():
            process.terminate()
        for process in running.values():
            process.join()
        gc.unfreeze()


@contextlib.contextmanager
def _uninterrupted() -> Iterator[None]:
    """What interrupts waits until a process is forked that from its first line on is not to hear it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, INTERRUPTING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _work(jobs: Sequence[tuple[str, Job]], taken: Any, told: Any) -> None:
    """Do jobs that no other process has taken, until none is left or the first process is gone."""
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the first process stops this one
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, INTERRUPTING)
    gc.set_threshold(*RARELY)
    parent = os.getppid()
    while os.getppid() == parent:
        with taken.get_lock():
            number, taken.value = taken.value, taken.value + 1
        if number >= len(jobs):
            return
        name, job = jobs[number]
        try:
            job()
        except Exception as error:
            error.add_note(f"in the process that wrote the {name}:\n{traceback.format_exc()}")
            _tell(told, (name, error))  # where nobody can do without it, this process is stopped
        else:
            _tell(told, (name, None))


def _tell(told: Any, message: tuple[str, Exception | None]) -> None:
    name, error = message
    with contextlib.suppress(BrokenPipeError):  # the first process is gone
        try:
            pickle.loads(pickle.dumps(error))
        except Exception:  # an error that the first process could not make again
            plain = RuntimeError(f"{type(error).__name__}: {error}")
            for note in getattr(error, "__notes__", ()):
                plain.add_note(note)
            message = name, plain
        told.send(message)
