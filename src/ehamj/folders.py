"""The folder of a result: where it may be written, and that it appears whole or not at all."""

import itertools
import os
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from ehamj.errors import InputError
from ehamj.unfinished import HELD, beside, clear_leftovers, remove

RUNS = Path("runs")
RESULT_FILES = ("scenario.toml", "result.nc", "summary.json")
"""Files without which a folder is no result."""

SAVING: list[Callable[..., None]] = []
"""How a result is saved with all that shows it: what does it stands far above, and `ehamj` puts it here."""


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
    above = next(path for path in (where.absolute(), *where.absolute().parents) if path.exists())
    if folder is not None and folder.exists():
        if not overwrite:
            why = f"exists already; name another folder or add {flag}"
        elif not folder.is_dir():
            why = "is a file, not a folder"
        elif any(folder.iterdir()) and not all((folder / name).is_file() for name in marks):
            why = f"{flag} replaces a folder of its own kind only, and this is none"
        elif Path.cwd().is_relative_to(folder.resolve()):
            why = "is where you stand; replace it from a folder above"
    if not why and not (above.is_dir() and os.access(above, os.W_OK)):
        why = f"cannot be written, since {str(above)!r} is no writable folder"
    if why:
        raise InputError(f"{said} {str(where)!r}: {why}")


def _numbered() -> Path:
    """Make the next number under runs/; of two runs that end together each gets its own."""
    RUNS.mkdir(exist_ok=True)
    numbers = [int(found.group()) for path in RUNS.glob("*") if (found := re.match(r"\d+", path.name))]
    for number in itertools.count(max(numbers, default=0) + 1):
        with suppress(FileExistsError):
            (RUNS / f"{number:04d}").mkdir()
            break
    return RUNS / f"{number:04d}"


@contextmanager
def new_folder(wanted: Path | None, overwrite: bool) -> Iterator[tuple[Path, Path]]:
    """The result's folder, and a temporary one that takes its place when everything in it is written.

    A result that is replaced moves aside, and is deleted when the new one has its place: an interruption leaves one of
    them, whole.
    """
    try:
        within = wanted.resolve().parent if wanted else RUNS
        within.mkdir(parents=True, exist_ok=True)
        clear_leftovers(within)
        folder = wanted or _numbered()
        final = folder.resolve()
        temporary = beside(final)
        HELD.add(temporary)
        temporary.mkdir(parents=True)
    except OSError as error:
        raise InputError(f"--out {str(wanted or RUNS)!r}: cannot be written ({error.strerror})") from error
    try:
        yield folder, temporary
        _put(temporary, final, overwrite)
    finally:
        remove(temporary)
        if wanted is None:
            with suppress(OSError):
                final.rmdir()  # only succeeds where nothing took its place


def _put(temporary: Path, final: Path, overwrite: bool) -> None:
    """Let a folder take its place, and what stood there, if it may, be deleted after."""
    if not (overwrite and final.is_dir()):
        temporary.replace(final)
        return
    aside = beside(final, "replaced")
    try:
        final.replace(aside)
        temporary.replace(final)
    finally:
        if aside.is_dir() and not final.is_dir():
            aside.replace(final)
    remove(aside)
