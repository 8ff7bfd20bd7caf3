"""One study at a time writes to a store: who comes second is told who is there.

The lock is one that SQLite holds on an empty file beside the store: the system releases it with the process, however
that ends, and those who read the store do not meet it.
"""

import os
import platform
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Final

from ehamj.errors import InputError

LOCK_FILE: Final = ".designs.lock"


@contextmanager
def held(folder: Path, holder: Callable[[], str]) -> Iterator[None]:
    """Hold the store in a folder, which is there, while the block lasts.

    Args:
        folder: of the study.
        holder: who holds it, where another does; asked then.

    Raises:
        InputError: if another study, of whatever process, holds it.
    """
    # Nothing is ever written to it, so that there is nothing to wait for, to roll back or to be damaged.
    with closing(sqlite3.connect(folder / LOCK_FILE, timeout=0.0, isolation_level=None)) as lock:
        try:
            lock.execute("BEGIN EXCLUSIVE")
        except sqlite3.OperationalError as error:
            if error.sqlite_errorcode & 0xFF != sqlite3.SQLITE_BUSY:
                raise OSError(None, f"{error}", str(folder / LOCK_FILE)) from error
            raise InputError(
                f"study {str(folder)!r}: {holder()} is at work on it; wait until it ends, or stop it and resume"
            ) from None
        try:
            yield
        finally:
            lock.execute("ROLLBACK")


def myself() -> str:
    """This process, for those who find the store held."""
    return f"process {os.getpid()} on {platform.node() or 'this computer'}"
