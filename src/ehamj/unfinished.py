"""What is written stands beside its place until it is whole, under a name that says whose it is.

A process that is killed leaves it there; the next one that writes in the same folder clears it.
"""

import errno
import os
import platform
import re
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Final, Literal
from zlib import crc32

_NAME: Final = re.compile(r"\.(?P<place>.+)\.(?P<kind>unfinished|replaced)-(?P<host>[0-9a-f]{8})-(?P<process>\d+)-.*")

NO_ROOM: Final = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
"""What a system answers where there is no room."""
MARGIN: Final = 2**20
"""Beside the numbers of a file, for what says what they are [B]."""

HELD: set[Path] = set()
"""What this process has begun and neither put in its place nor removed."""


def beside(path: Path, kind: Literal["unfinished", "replaced"] = "unfinished") -> Path:
    """A name beside ``path`` for what is to take its place, or for what gives its place up; of the same suffix."""
    return path.with_name(f".{path.name}.{kind}-{_host()}-{os.getpid()}-{os.urandom(4).hex()}{path.suffix}")


def check_room(path: Path, size: int) -> None:
    """Raise OSError unless a file of ``size`` bytes can be written at ``path``, which is not there before or after.

    HDF5 ends the process where a disk gets full while it writes.
    """
    try:
        occupy(path, size + MARGIN)
    except OSError as error:
        said = f"{error.strerror}; {size + MARGIN} bytes are needed"
        raise OSError(error.errno, said, str(path.parent)) from error
    finally:
        path.unlink(missing_ok=True)


def occupy(path: Path, size: int) -> None:
    """Make a file of ``size`` bytes that has its room on disk, where the system can tell; raises OSError without."""
    if not hasattr(os, "posix_fallocate"):
        return
    try:
        with path.open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, size)
    except OSError as error:
        if error.errno in NO_ROOM:  # others: a file system that cannot tell
            raise


def clear_leftovers(folder: Path) -> None:
    """Remove what processes of this computer that are gone have left in a folder.

    What one had moved away, and nothing had replaced yet, goes back to its place.
    """
    found = [(told, path) for path in folder.glob(".*-*") if (told := _NAME.fullmatch(path.name))]
    for told, path in sorted(found, key=lambda one: one[0]["kind"]):
        if told["host"] != _host() or _runs(int(told["process"])):
            continue
        place = folder / told["place"]
        if told["kind"] == "replaced" and (not place.exists() or _empty(place)):
            with suppress(OSError):
                path.replace(place)
            continue
        was_there = path.exists()
        remove(path)
        if told["kind"] == "unfinished" and was_there and not path.exists() and _empty(place):
            with suppress(OSError):
                place.rmdir()  # it was made to hold the name


def remove(path: Path) -> None:
    """Remove a file or a folder, if it is there."""
    import shutil

    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)
    HELD.discard(path)


def remove_all() -> None:
    """Remove whatever this process has begun, which ends now."""
    for path in list(HELD):
        with suppress(OSError):
            remove(path)


def _empty(place: Path) -> bool:
    return place.is_dir() and not any(place.iterdir())


@cache
def _host() -> str:
    """Where this process is seen: other computers, and containers, may share its disk."""
    spaces = [Path("/proc/sys/kernel/random/boot_id"), Path("/proc/self/ns/pid")]
    with suppress(OSError):
        return f"{crc32(f'{spaces[0].read_text()} {spaces[1].stat().st_ino}'.encode()):08x}"
    return f"{crc32(platform.node().encode()):08x}"


def _runs(process: int) -> bool:
    import psutil

    return bool(psutil.pid_exists(process))
