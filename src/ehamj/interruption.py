"""Where the user interrupts: threads stop, and a command ends in a second with nothing half written."""

import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor

EXIT_CODE: Final = 130
"""Of a command that was interrupted, as shells have it: 128 + SIGINT."""
GRACE: Final = 0.7
"""Time after which a command that is within a library's code is ended from outside [s]."""

INTERRUPTING: Final = (signal.SIGINT, signal.SIGTERM)


class Interrupted(BaseException):
    """The user interrupts. No `Exception`: nothing that handles failures is to handle it."""


class _Own(threading.local):
    """Of a thread: what asks it to stop, that of its pool and of the pools that this one works for."""

    asked: tuple[threading.Event, ...] = ()


_own = _Own()


def check() -> None:
    """Raise `Interrupted` where this thread's pool is asked to stop; called by whatever runs for long."""
    if any(one.is_set() for one in _own.asked):
        raise Interrupted


@contextmanager
def pool_of(threads: int | None = None) -> "Iterator[ThreadPoolExecutor]":
    """A pool of threads. Where its block fails or the user interrupts, none begins, and those that `check` stop."""
    from concurrent.futures import ThreadPoolExecutor

    stop = threading.Event()
    asked = (*_own.asked, stop)

    def begin() -> None:
        _own.asked = asked

    pool = ThreadPoolExecutor(threads, initializer=begin)
    try:
        yield pool
    except BaseException:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)
        raise
    pool.shutdown()


_heard = threading.Event()


def interrupted() -> bool:
    """Whether the user has interrupted this command: what fails from then on may fail because of that, as a library
    that is being imported."""
    return _heard.is_set()


def _interrupt(*_: Any) -> None:
    _heard.set()
    raise KeyboardInterrupt


def _unraisable(found: Any) -> None:
    """Where C calls Python nobody can be told of an interruption."""
    if not interrupted():
        sys.__unraisablehook__(found)


@contextmanager
def watched(give_up: Callable[[], None]) -> Iterator[None]:
    """While the block lasts SIGTERM interrupts as SIGINT does, unless whoever began this process has it ignored; call
    it on the main thread, of a process that ends with the block where it is interrupted.

    Python hears of a signal between two of its own instructions. Where a library computes or writes for longer than
    `GRACE`, a thread that waits for nothing else calls ``give_up``, and ends the process.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    reading, writing = os.pipe()
    if hasattr(os, "set_blocking"):
        os.set_blocking(writing, False)
    heard = [one for one in INTERRUPTING if signal.getsignal(one) not in (signal.SIG_IGN, None)]
    before = {one: signal.signal(one, _interrupt) for one in heard}
    shown, sys.unraisablehook = sys.unraisablehook, _unraisable
    woken = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)

    def watch() -> None:
        if hasattr(signal, "pthread_sigmask"):
            signal.pthread_sigmask(signal.SIG_BLOCK, INTERRUPTING)
        while number := os.read(reading, 1)[0]:
            if number in before:
                time.sleep(GRACE)
                give_up()
                os._exit(EXIT_CODE)

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield
    except BaseException:
        if interrupted():
            raise Interrupted from None
        raise
    finally:
        if not interrupted():  # else the thread sees to it that the process ends
            sys.unraisablehook = shown
            signal.set_wakeup_fd(woken)
            os.write(writing, b"\0")
            thread.join()
            os.close(writing)
            os.close(reading)
            for one, handler in before.items():
                signal.signal(one, handler)
