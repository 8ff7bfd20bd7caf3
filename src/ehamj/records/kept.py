"""What was read of a file is kept in memory: a thousand scenarios of one record read it once."""

import threading
from collections import OrderedDict
from collections.abc import Callable, Hashable
from pathlib import Path
from typing import Final, Generic, TypeVar

from ehamj.records.files import named_by

T = TypeVar("T")

ROOM: Final = 256e6
"""What is kept at most, beside what was asked for last [byte]."""

Identity = tuple[tuple[str, int, int], ...]


def identity(path: Path) -> Identity:
    """The files that a path names as they are now: where each is, when it was written [ns], its size [byte]."""
    stats = [(str(one.resolve()), one.stat()) for one in named_by(path)]
    return tuple((name, stat.st_mtime_ns, stat.st_size) for name, stat in stats)


class Kept(Generic[T]):
    """Results by file and by what was asked of it; a file that was written anew is read anew.

    ``size`` says how much memory a result takes [byte]. Two that ask at once: one reads.
    """

    def __init__(self, size: Callable[[T], float]) -> None:
        self._size, self._lock = size, threading.RLock()
        self._found: OrderedDict[Hashable, T] = OrderedDict()

    def get(self, path: Path, asked: Hashable, read: Callable[[], T]) -> T:
        """What was kept, or what ``read`` now gives; what it raises is not kept."""
        key = (str(path), identity(path), asked)
        with self._lock:
            found = self._found.pop(key, None)
            if found is None:
                found = read()
            self._found[key] = found
            while len(self._found) > 1 and sum(map(self._size, self._found.values())) > ROOM:
                self._found.popitem(last=False)
        return found
