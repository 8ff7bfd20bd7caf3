"""The folder of a result: where it may be written, and that it appears whole or not at all."""

import errno
import itertools
import os
import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from ehamj.errors import InputError, PutElsewhere
from ehamj.unfinished import HELD, beside, clear_leftovers, remove

RUNS = Path("runs")
RESULT_FILES = ("scenario.toml", "result.nc", "summary.json")
"""Files without which a folder is no result."""

NAME_MAX: Final = 255
"""Longest name of a file in nearly every file system [byte]."""
PATH_MAX: Final = 4096
"""Longest path [byte]."""
AROUND: Final = 64
"""What a temporary name has more than the name that it holds the place of [byte]."""
DEEP: Final = 400
"""What paths within a result's folder have more than its own [byte]."""
TAKEN: Final = (errno.ENOTEMPTY, errno.EEXIST, errno.ENOTDIR)
"""What a system answers where another process was quicker."""


def check_out(
    folder: Path | None, overwrite: bool, marks: Sequence[str], said: str = "--out", flag: str = "--overwrite"
) -> None:
    """Raise InputError unless ``folder`` may be written; called before anything is computed.

    Only a folder that holds the files ``marks`` is replaced: it is of the kind that will be written.

    Args:
        folder: to be made; without, one under runs/.
        overwrite: whether one that is there may be replaced.
        marks: files that a folder of the kind holds.
        said: what messages begin with.
        flag: what allows to replace.
    """
    where, why = folder or RUNS, ""
    check_name(where, said)
    above = next(path for path in (where.absolute(), *where.absolute().parents) if path.exists())
    if folder is not None and folder.exists():
        if not folder.is_dir():
            why = "is a file, not a folder"
        elif any(folder.iterdir()) and not all((folder / name).is_file() for name in marks):
            why = f"exists already; name another folder ({flag} replaces one of its own kind only, and this is none)"
        elif not overwrite:
            why = f"exists already; name another folder or add {flag}"
        elif Path.cwd().is_relative_to(folder.resolve()):
            why = "is where you stand; replace it from a folder above"
    if not why and not (above.is_dir() and os.access(above, os.W_OK)):
        why = f"cannot be written, since {str(above)!r} is no writable folder"
    if why:
        raise InputError(f"{said} {str(where)!r}: {why}")


def check_name(path: Path, said: str) -> None:
    """Raise InputError where a name is longer than the system has room for, with what stands beside it meanwhile."""
    longest, within = max((len(os.fsencode(part)) for part in path.parts), default=0), len(os.fsencode(path.absolute()))
    if longest + AROUND > NAME_MAX:
        raise InputError(
            f"{said} {str(path)[:40] + '…'!r}: has a name of {longest} bytes; at most {NAME_MAX - AROUND} are possible"
        )
    if within + DEEP > PATH_MAX:
        raise InputError(
            f"{said} {str(path)[:40] + '…'!r}: is a path of {within} bytes; {PATH_MAX - DEEP} are possible"
        )


def check_file(path: Path, said: str) -> None:
    """Raise InputError unless a file may be written at a path, in place of one that is there."""
    check_name(path, said)
    folder = path.absolute().parent
    if path.is_dir():
        raise InputError(f"{said} {str(path)!r}: is a folder")
    if not folder.is_dir():
        raise InputError(f"{said} {str(path)!r}: cannot be written, since {str(folder)!r} is no folder")
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise InputError(f"{said} {str(path)!r}: cannot be written")


def numbered_folder() -> Path:
    """Make the next number under runs/; of two runs that end together each gets its own."""
    RUNS.mkdir(exist_ok=True)
    numbers = [int(found.group()) for path in RUNS.glob("*") if (found := re.match(r"\d+", path.name))]
    for number in itertools.count(max(numbers, default=0) + 1):
        with suppress(FileExistsError):
            (RUNS / f"{number:04d}").mkdir()
            break
    return RUNS / f"{number:04d}"


class Place:
    """Where a result is written."""

    def __init__(self, folder: Path, target: Path) -> None:
        self.folder = folder
        """The result's folder; known for certain when everything is written, since another run may take it before."""
        self.target = target
        """A temporary one that takes its place then."""


@contextmanager
def new_folder(wanted: Path | None, overwrite: bool) -> Iterator[Place]:
    """The place of a result, which is put there when everything in it is written.

    A result that is replaced moves aside, and is deleted when the new one has its place: an interruption leaves one of
    them, whole. One whose folder another process has taken meanwhile is put beside it.

    Warns:
        PutElsewhere: if it is.
    """
    try:
        within = wanted.resolve().parent if wanted else RUNS
        within.mkdir(parents=True, exist_ok=True)
        clear_leftovers(within)
        folder = wanted or numbered_folder()
        temporary = beside(folder.resolve())
        HELD.add(temporary)
        temporary.mkdir(parents=True)
    except OSError as error:
        raise InputError(f"--out {str(wanted or RUNS)!r}: cannot be written ({error.strerror})") from error
    place = Place(folder, temporary)
    try:
        yield place
        others = _others(folder, wanted is None)
        while not _put(temporary, place.folder.resolve(), overwrite and place.folder == folder):
            place.folder = next(others)
        if wanted is not None and place.folder != folder:
            said = f"{str(folder)!r} was taken by another run meanwhile: this result is in {str(place.folder)!r}"
            warnings.warn(said, PutElsewhere, stacklevel=3)
    finally:
        remove(temporary)
        if wanted is None:
            with suppress(OSError):
                folder.rmdir()  # only succeeds where nothing took its place


def _others(folder: Path, numbered: bool) -> Iterator[Path]:
    """Where to put a result whose folder is taken, one after the other."""
    for number in itertools.count(2):
        yield numbered_folder() if numbered else folder.with_name(f"{folder.name}-{number}")


def _put(temporary: Path, final: Path, overwrite: bool) -> bool:
    """Let a folder take its place, and what stood there, if it may, be deleted after; whether the place was free."""
    aside = beside(final, "replaced")
    try:
        if overwrite and final.is_dir():
            final.replace(aside)
        temporary.replace(final)
    except OSError as error:
        if error.errno not in TAKEN or not temporary.is_dir():
            raise
        return False
    finally:
        if aside.is_dir() and not final.exists():
            aside.replace(final)
        remove(aside)
    return True
