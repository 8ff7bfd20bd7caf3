"""Where a long series is: in memory, or in a temporary file; and the blocks of it that are at hand."""

import os
import tempfile
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator
from typing import Any, Final, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.errors import InputError

BLOCK: Final = 65536
"""Samples of a block at most."""

KEPT: Final = 4
"""Blocks that are kept: runs of one floor beside each other may be at as many places of it."""

PART: Final = 8192
"""Lines that are looked at together."""

Number = TypeVar("Number", np.float64, np.complex128)
Number_co = TypeVar("Number_co", np.float64, np.complex128)
T = TypeVar("T")


class Held(Protocol[Number]):
    """Numbers, read and written a slice at a time; an array is one."""

    @property
    def size(self) -> int:
        """How many there are."""
        ...

    def __getitem__(self, part: slice, /) -> NDArray[Number]: ...

    def __setitem__(self, part: slice, values: NDArray[Number], /) -> None: ...


def is_whole(samples: int) -> bool:
    """Whether a series is held whole: it is no longer than all the blocks that are kept."""
    return samples <= KEPT * BLOCK


def stored(values: Array) -> Held[np.float64]:
    """Samples where they may stay: the array itself, or a file if there are many.

    Raises:
        InputError: if there is no room for a temporary file.
    """
    if is_whole(values.size):
        return values
    found: OnDisk[np.float64] = OnDisk(values.size, np.float64)
    found[:] = values
    return found


def parts(begin: int, end: int, length: int = PART) -> Iterator[slice]:
    """Slices from ``begin`` to ``end``, at most ``length`` long."""
    return (slice(first, min(first + length, end)) for first in range(begin, end, length))


class Recent(Generic[T]):
    """The last `KEPT` blocks that were asked for."""

    def __init__(self, make: Callable[[int], T]) -> None:
        self._make, self._lock = make, threading.Lock()
        self._kept: OrderedDict[int, T] = OrderedDict()

    def __getitem__(self, number: int) -> T:
        with self._lock:  # two that ask at once: one computes
            block = self._kept.pop(number, None)
            if block is None:
                while len(self._kept) >= KEPT:
                    self._kept.popitem(last=False)
                block = self._make(number)
            self._kept[number] = block
        return block


class OnDisk(Generic[Number]):
    """Numbers in a file without a name, which goes with its process, zero until written; many may read at once."""

    def __init__(self, size: int, dtype: type[Number]) -> None:
        self.size = size
        self._dtype: np.dtype[Number] = np.dtype(dtype)
        try:
            # Closed, and gone, when the last who knows it forgets it.
            self._file = tempfile.TemporaryFile(prefix="ehamj-", buffering=0)  # noqa: SIM115
            self._file.truncate(self._dtype.itemsize * size)
        except OSError as error:
            raise self._no_room(error) from error

    def __getitem__(self, part: slice, /) -> NDArray[Number]:
        begin, end, _ = part.indices(self.size)
        values: NDArray[Any] = np.empty(max(0, end - begin), self._dtype)
        room, done = values.view(np.uint8).data, 0
        while done < len(room):  # at the place, not where the file stands: others read too
            done += os.preadv(self._file.fileno(), [room[done:]], self._dtype.itemsize * begin + done)
        return values

    def __setitem__(self, part: slice, values: NDArray[Number], /) -> None:
        begin = part.indices(self.size)[0]
        given, done = np.ascontiguousarray(values, self._dtype).view(np.uint8).data, 0
        try:
            while done < len(given):
                done += os.pwrite(self._file.fileno(), given[done:], self._dtype.itemsize * begin + done)
        except OSError as error:
            raise self._no_room(error) from error

    def _no_room(self, error: OSError) -> InputError:
        try:
            folder = f", {tempfile.gettempdir()}"
        except OSError:  # it finds none that can be written
            folder = ""
        return InputError(
            f"duration: a floor or force as long as the run needs {1e-6 * self._dtype.itemsize * self.size:.3g} MB in "
            f"the folder for temporary files{folder}: {error.strerror or error}; make the duration "
            "shorter, or let TMPDIR name a folder with room"
        )
