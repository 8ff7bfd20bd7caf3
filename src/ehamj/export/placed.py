"""Exports that appear all together, or not at all."""

import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple

from ehamj.errors import InputError
from ehamj.export.formats import FORMATS, Format
from ehamj.export.subject import Subject
from ehamj.folders import check_file, check_out, new_folder
from ehamj.unfinished import HELD, beside, clear_leftovers, remove


class Exported(NamedTuple):
    """What was exported."""

    files: Mapping[Path, str]
    """What each file is and how to open it."""
    notes: tuple[str, ...]


def check_targets(chosen: Mapping[str, Path], overwrite: bool) -> None:
    """Refuse what cannot be written; called before anything is computed.

    Args:
        chosen: where to, by the format's name.
        overwrite: whether files may be replaced, and in folders of the same kind those that an export writes.

    Raises:
        InputError: which names the option.
    """
    if not chosen:
        lines = "; ".join(f"{one.option} {one.takes} ({one.what})" for one in FORMATS.values())
        raise InputError(f"export: no format is named; name one or more of: {lines}")
    _check_apart(chosen)
    taken: dict[Path, str] = {}
    for name, target in chosen.items():
        one = FORMATS[name]
        if one.suffix:
            _check_files(one, target, overwrite)
        else:
            check_out(target, overwrite, one.marks, one.option)
        for path in (target, *one.beside(target)):
            if other := taken.get(path.resolve()):
                raise InputError(f"{one.option} {str(target)!r}: {other} writes {str(path)!r} too; name another file")
            taken[path.resolve()] = one.option


def _check_apart(chosen: Mapping[str, Path]) -> None:
    """Raise InputError where one target lies within the folder that another is."""
    folders = {FORMATS[name].option: target for name, target in chosen.items() if not FORMATS[name].suffix}
    for name, target in chosen.items():
        for option, folder in folders.items():
            if folder.resolve() in target.resolve().parents:
                raise InputError(
                    f"{FORMATS[name].option} {str(target)!r}: is within {str(folder)!r}, which {option} writes whole; "
                    "name a place beside it"
                )


def _check_files(one: Format, target: Path, overwrite: bool) -> None:
    """Raise InputError unless a file, and what stands next to it, may be written."""
    if target.suffix != one.suffix:
        raise InputError(f"{one.option} {str(target)!r}: must end in {one.suffix}")
    for path in (target, *one.beside(target)):
        if path.exists() and not (overwrite and path.is_file()):
            raise InputError(f"{one.option} {str(path)!r}: exists already; name another file or add --overwrite")
        check_file(path, one.option)


def export_to(
    subject: Subject, chosen: Mapping[str, Path], overwrite: bool, progress: Callable[[str], None]
) -> Exported:
    """Write a subject in some formats, which take their places when all are whole.

    Args:
        subject: what is exported.
        chosen: where to, by the format's name; checked (`check_targets`).
        overwrite: whether what is there may be replaced.
        progress: called with what is being written.

    Raises:
        InputError: if the subject has nothing for a format, or cannot be computed.
    """
    files: dict[Path, str] = {}
    notes: dict[str, list[str]] = {}
    with ExitStack() as places:
        for name, target in chosen.items():
            one = FORMATS[name]
            progress(f"writing {target}")
            if one.suffix:
                written = one.write(subject, places.enter_context(_new_files(target)))
                within = target.parent
            else:
                place = places.enter_context(new_folder(target, overwrite))
                written = one.write(subject, place.target)
                if overwrite and target.is_dir():
                    _keep(target, place.target, one.option)
                within = target
            files |= {within / file: said.replace("{path}", str(within / file)) for file, said in written.files.items()}
            for note in written.notes:
                notes.setdefault(note, []).append(one.option)
    return Exported(files, tuple(f"{', '.join(options)}: {note}" for note, options in notes.items()))


def _keep(there: Path, new: Path, option: str) -> None:
    """Copy what a folder holds, and the ``new`` one that takes its place does not, into that one.

    The folder stays as it is until then, so that an interruption loses nothing of it.

    Raises:
        InputError: if something cannot be copied, or a folder stands where a file is written.
    """
    for path in there.iterdir():
        taken = new / path.name
        folder = path.is_dir() and not path.is_symlink()
        if folder and taken.exists() and not taken.is_dir():
            raise InputError(f"{option}: {str(path)!r} is a folder where a file is written; move it")
        try:
            if folder:
                taken.mkdir(exist_ok=True)
                _keep(path, taken, option)
                shutil.copystat(path, taken)
            elif not taken.exists():
                shutil.copy2(path, taken, follow_symlinks=False)
        except OSError as error:
            raise InputError(f"{option}: {str(path)!r} cannot be kept ({error.strerror or error}); move it") from error


@contextmanager
def _new_files(target: Path) -> Iterator[Path]:
    """The path of a file's name in a folder beside its own, of which all files go to where it belongs in the end."""
    clear_leftovers(target.parent)
    temporary = beside(target.absolute())
    HELD.add(temporary)
    temporary.mkdir()
    try:
        yield temporary / target.name
        for path in temporary.iterdir():
            path.replace(target.parent / path.name)
    finally:
        remove(temporary)
