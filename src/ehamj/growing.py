"""A NetCDF file of channels that grows block by block, and is opened without being read."""

import errno
import os
import shutil
import weakref
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple, Self

import numpy as np

from ehamj.errors import InputError
from ehamj.plain.needs import gib
from ehamj.unfinished import HELD, MARGIN, check_room, occupy, remove

if TYPE_CHECKING:
    import xarray as xr

FILE: Final = "result.nc"
IN_MEMORY: Final = 2**29
"""Size of the rows of runs that step together [byte] up to which they stay in memory: a minute and a half of the
default machine at 2 kHz. A result of that size is written and read in a second or two, and several fit side by side."""

RESERVE: Final = 2**23
"""Held on the file's disk while it grows, and let go when it has ended: where others fill the disk meanwhile, the file
can still be closed, and what says what it holds be written beside it [B]."""
COPIES: Final = 1.6
"""What of a result is in memory at once where all of it is, over its size: its channels, and what is made of them."""


class Growing:
    """A file that gets rows appended. Columns stand in pieces of their own: whoever reads one reads no other."""

    def __init__(self, folder: Path, rows: int, count: int) -> None:
        """In a folder that is made for it, and goes with it.

        Args:
            folder: that is not there yet.
            rows: that all parts have but the last.
            count: rows that are to come, for which there must be room.
        """
        self.folder, self._rows, self._count, self._written = folder.absolute(), rows, count, 0
        self._file: Any = None
        self._gone = weakref.finalize(self, _put_away, self.folder, os.getpid())

    @property
    def path(self) -> Path:
        """Of the file."""
        return self.folder / FILE

    @property
    def _reserve(self) -> Path:
        return self.folder / "reserve"

    def add(self, part: "xr.Dataset") -> None:
        """Append rows; where that fails, those before them stay.

        Raises:
            OSError: where there is no room.
        """
        if self._file is None:
            self._begin(part)
        if shutil.disk_usage(self.folder).free < part.nbytes + MARGIN:  # others write too
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(self.folder.parent))
        for name, channel in part.variables.items():
            if channel.dims[:1] == ("time",):
                self._append(self._file.variables[name]._h5ds.id, channel.values, self._written)
        self._written += part.sizes["time"]

    def _begin(self, part: "xr.Dataset") -> None:
        """Lay out all rows that are to come: a time without end would be counted anew whenever a channel is read."""
        import h5netcdf
        import h5py

        HELD.add(self.folder)
        self.folder.mkdir(parents=True)
        check_room(self.path, part.nbytes // max(part.sizes["time"], 1) * self._count + RESERVE)
        occupy(self._reserve, RESERVE)
        self._file = h5netcdf.File(self.path, "w")
        self._file.attrs.update(part.attrs)
        self._file.dimensions = {name: self._count if name == "time" else size for name, size in part.sizes.items()}
        for name, channel in part.variables.items():
            grows, kind = channel.dims[:1] == ("time",), channel.dtype
            kind = h5py.string_dtype() if kind.kind in "OU" else kind
            pieces = (min(self._rows, self._count), *[1] * (channel.ndim - 1)) if grows else None
            own = self._file.create_variable(str(name), channel.dims, kind, chunks=pieces)
            own.attrs.update(channel.attrs)
            if not grows:
                own[...] = channel.values.astype(object) if channel.dtype.kind == "U" else channel.values

    def _append(self, file: Any, values: Any, first: int) -> None:
        """Rows of a channel, each piece of a column whole; what the last lacks is outside of the file's extent."""
        size = file.get_create_plist().get_chunk()[0]
        for at in np.ndindex(values.shape[1:]):
            column = values[(slice(None), *at)]
            for begin in range(0, len(column), size):
                piece = np.zeros(size, values.dtype)
                own = column[begin : begin + size]
                piece[: len(own)] = own
                file.write_direct_chunk((first + begin, *at), piece)

    def ended(self, attributes: "Callable[[xr.Dataset], Mapping[str, Any]]") -> "Kept":
        """What was written. The folder goes when nobody holds any of its channels any more.

        ``attributes`` makes of the channels what is to be known of all of them.
        """
        import h5netcdf

        self._reserve.unlink(missing_ok=True)
        for channel in self._file.variables.values():
            if channel.dimensions[:1] == ("time",) and self._written < self._count:  # what broke off is shorter
                channel._h5ds.resize(self._written, axis=0)
        self._file.close()
        with _opened(self.path)[1] as read:
            known = attributes(read)
        with h5netcdf.File(self.path, "a") as file:
            file.attrs.update(known)
        store, dataset = _opened(self.path)
        weakref.finalize(store, _put_away, self.folder, os.getpid())
        self._gone.detach()
        return Kept(self.path, dataset, _told(self.path))


class Kept(NamedTuple):
    """Channels in a file, which are read as they are asked for."""

    path: Path
    """Where it stood when it was opened, absolute."""
    dataset: "xr.Dataset"
    told: tuple[int, int]
    """What tells the file from another that takes its place."""

    @classmethod
    def of(cls, path: Path) -> Self:
        """Open a file, none of whose channels is in memory until it is asked for, nor after."""
        path = path.absolute()
        return cls(path, _opened(path)[1], _told(path))

    def load(self) -> "xr.Dataset":
        """All channels in memory.

        Raises:
            InputError: where they do not fit, with what else there is made of.
        """
        import psutil

        need, free = COPIES * self.dataset.nbytes, psutil.virtual_memory().available
        if need > free:
            raise InputError(
                f"report and replay need all {self.dataset.sizes['time']} rows in memory, about {gib(need)}, "
                f"and {gib(free)} are free; summary.json has the numbers, result.nc opens with xarray "
                "a part at a time, and a run with a lower record_rate or duration has both"
            )
        return self.dataset.copy().load()

    def put(self, place: Path) -> bool:
        """Give what is temporary its name, once; copy what has one, or is on another file system.

        False where it no longer stands where it stood, and its channels alone can be read.
        """
        try:
            if _told(self.path) != self.told:
                return False
        except OSError:
            return False
        # Of what is ours alone: who edits a stored result is not to edit its copy.
        if self.path.parent in HELD and self.path.stat().st_nlink == 1:
            with suppress(OSError):
                os.link(self.path, place)
                return True
        check_room(place, self.path.stat().st_size)
        shutil.copyfile(self.path, place)
        return True


def copied(dataset: "xr.Dataset", rows: int, place: Path, folder: Path) -> None:
    """Write channels that are read as they are asked for to a file, so many rows at a time.

    ``folder`` is one for the time being on the same file system, which is not there yet.
    """
    count = dataset.sizes["time"]
    file = Growing(folder, rows, count)
    for first in range(0, count, rows):
        file.add(dataset.isel(time=slice(first, first + rows)))
    file.ended(lambda _: dataset.attrs).put(place)


def _opened(path: Path) -> "tuple[Any, xr.Dataset]":
    """What reads a file, and its channels, each of which holds on to that."""
    import xarray as xr  # takes its time

    from ehamj.opened import Store

    store = Store.open(str(path), phony_dims="access")
    return store, xr.open_dataset(store, cache=False)


def _told(path: Path) -> tuple[int, int]:
    """Device and number of a file."""
    found = path.stat()
    return found.st_dev, found.st_ino


def _put_away(folder: Path, process: int) -> None:
    if os.getpid() == process:  # and none that was forked from it
        remove(folder)
