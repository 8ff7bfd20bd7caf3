"""The command line: printing, paths, exit codes, nothing else. Its commands stand in modules by what they do."""

import sys
import warnings
from typing import Any, NoReturn

from rich.markup import escape

from ehamj.cli.frame import app, log
from ehamj.errors import DerivedAnew, InputError, SimulationFailed

__all__ = ["app", "main"]


def main() -> NoReturn:
    """Run the command line; every error becomes one message and an exit code, what should be known a note."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always", DerivedAnew)
            warnings.showwarning = _noted
            app(prog_name="ehamj")  # also where another program runs it
    except (InputError, SimulationFailed) as error:
        log.print(f"[bold red]ehamj:[/] {escape(str(error))}", highlight=False, soft_wrap=True)
        sys.exit(2 if isinstance(error, InputError) else 3)
    sys.exit(0)


def _noted(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
    """A warning as a line on standard error; one that is not for the user as Python shows it."""
    if issubclass(category, DerivedAnew):
        log.print(f"note: {message}", markup=False, highlight=False, soft_wrap=True)
    else:
        sys.stderr.write(warnings.formatwarning(message, category, *where[:2]))
