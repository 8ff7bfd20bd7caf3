"""How a command ends: one message and an exit code for whatever may go wrong, what should be known as a note."""

import errno
import os
import platform
import sys
import tempfile
import traceback
import warnings
from pathlib import Path
from typing import Any, Final

from rich.markup import escape

from ehamj.caches import let_matplotlib_keep_its_fonts
from ehamj.cli.folding import fitted
from ehamj.cli.frame import app, log
from ehamj.cli.letters import write_any_letter
from ehamj.errors import DerivedAnew, InputError, NotShown, PutElsewhere, Recompiled, SimulationFailed
from ehamj.interruption import interrupted
from ehamj.unfinished import NO_ROOM

DONE: Final = 0
BAD_INPUT: Final = 2
FAILED: Final = 3
NOT_WRITTEN: Final = (*NO_ROOM, errno.EACCES, errno.EPERM, errno.EROFS, errno.EIO)
"""What a system answers that lets nothing be written."""
BEYOND: Final = "somewhere numbers are too large or too small to compute with; look whether all values are meant"
TOLD: Final = (DerivedAnew, PutElsewhere, Recompiled)
"""Warnings that a user is told as notes."""


def exit_code() -> int:
    """Run the command that the command line asks for; what it ends with."""
    write_any_letter()
    let_matplotlib_keep_its_fonts()
    try:
        with warnings.catch_warnings():
            for kind in TOLD:
                warnings.simplefilter("always", kind)
            warnings.showwarning = _noted
            app(prog_name="ehamj")  # also where another program runs it
    except (InputError, SimulationFailed, NotShown) as error:
        return _told(str(error), BAD_INPUT if isinstance(error, InputError) else FAILED)
    except SystemExit as ended:
        if interrupted():
            raise
        return _flushed(ended.code)
    except MemoryError as error:
        return _told(f"this does not fit in memory{_said(error)}", BAD_INPUT)
    except Exception as error:
        if interrupted():
            raise
        refused = isinstance(error, OSError) and error.errno in NOT_WRITTEN
        return _told(_not_written(error) if refused else _unforeseen(error), FAILED)
    return _flushed(DONE)


def _not_written(error: Any) -> str:
    where = f"{str(error.filename)!r}: " if error.filename else ""
    return f"{where}{error.strerror}; what could not be written is not kept"


def _told(message: str, code: int) -> int:
    line = fitted(f"ehamj: {message}", log)
    log.print(f"[bold red]ehamj:[/]{escape(line.removeprefix('ehamj:'))}", highlight=False, soft_wrap=True)
    return code


def _said(error: Exception) -> str:
    return f": {error}" if str(error) else ""


def _flushed(code: Any) -> Any:
    """An exit code once all of standard output is out; another where it cannot be written."""
    try:
        sys.stdout.flush()
    except OSError as error:
        sys.stdout = Path(os.devnull).open("w")  # noqa: SIM115  # else the interpreter tries again at its end
        return _told(f"standard output: {error.strerror}", FAILED)
    return code


def _unforeseen(error: Exception) -> str:
    """What to say of an error that nobody foresaw: one line, and where all of it is, for a report."""
    from importlib.metadata import version

    said = f"{type(error).__name__}{_said(error)}".splitlines()[0]
    text = (
        f"ehamj {version('ehamj')}, Python {platform.python_version()}, {platform.platform()}\n"
        f"{' '.join(sys.argv[1:])}\n\n{''.join(traceback.format_exception(error))}"
    )
    try:
        with tempfile.NamedTemporaryFile("w", prefix="ehamj-", suffix=".txt", encoding="utf-8", delete=False) as file:
            file.write(text)
    except OSError:
        return f"{said}: this should not happen, and is a fault of ehamj"
    return f"{said}: this should not happen, and is a fault of ehamj; please report it with {file.name!r}"


def _noted(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
    """A warning as a line on standard error; one that is not for the user as Python shows it."""
    if issubclass(category, TOLD):
        log.print(fitted(f"note: {message}", log), markup=False, highlight=False, soft_wrap=True)
    elif issubclass(category, RuntimeWarning):
        log.print(f"note: {BEYOND} ({message})", markup=False, highlight=False, soft_wrap=True)
    else:
        sys.stderr.write(warnings.formatwarning(message, category, *where[:2]))
