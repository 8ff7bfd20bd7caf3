"""Where the complex amplitudes of lines are: in memory while they are few, else in a temporary file."""

import os
import tempfile
from collections.abc import Iterator
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from ehamj.errors import InputError
from ehamj.lines.grid import grid_size, is_whole

PART: Final = 8192
"""Lines that are looked at together."""


class Held(Protocol):
    """Complex amplitudes, read and written a slice at a time; an array is one."""

    @property
    def size(self) -> int:
        """How many there are."""
        ...

    def __getitem__(self, part: slice) -> NDArray[np.complex128]: ...

    def __setitem__(self, part: slice, values: NDArray[np.complex128]) -> None: ...


def room(size: int) -> Held:
    """Room for so many amplitudes, zero until they are written.

    Raises:
        InputError: if they need a temporary file, and there is no room for it.
    """
    return np.zeros(size, complex) if is_whole(grid_size(size)) else OnDisk(size)


def parts(begin: int, end: int, length: int = PART) -> Iterator[slice]:
    """Slices from ``begin`` to ``end``, at most ``length`` long."""
    return (slice(first, min(first + length, end)) for first in range(begin, end, length))


class OnDisk:
    """Complex amplitudes in a file without a name, which goes with its process; it may be read by many at once."""

    def __init__(self, size: int) -> None:
        self.size = size
        try:
            self._file = tempfile.TemporaryFile(prefix="ehamj-lines-", buffering=0)  # noqa: SIM115 closed when forgotten
            self._file.truncate(16 * size)
        except OSError as error:
            raise self._no_room(error) from error

    def __getitem__(self, part: slice) -> NDArray[np.complex128]:
        begin, end, _ = part.indices(self.size)
        values = np.empty(max(0, end - begin), complex)
        room, done = values.view(np.uint8).data, 0
        while done < len(room):  # at the place, not where the file stands: others read too
            done += os.preadv(self._file.fileno(), [room[done:]], 16 * begin + done)
        return values

    def __setitem__(self, part: slice, values: NDArray[np.complex128]) -> None:
        begin = part.indices(self.size)[0]
        given, done = np.ascontiguousarray(values, complex).view(np.uint8).data, 0
        try:
            while done < len(given):
                done += os.pwrite(self._file.fileno(), given[done:], 16 * begin + done)
        except OSError as error:
            raise self._no_room(error) from error

    def _no_room(self, error: OSError) -> InputError:
        return InputError(
            f"{self.size} lines of a random floor or force need {16e-6 * self.size:.3g} MB in the folder for temporary "
            f"files, {tempfile.gettempdir()}: {error.strerror or error}; make the duration shorter, or let TMPDIR name "
            "a folder with room"
        )
