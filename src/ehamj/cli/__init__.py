"""The command line: printing, paths, exit codes, nothing else. Its commands stand in modules by what they do."""

import sys
from typing import NoReturn

from rich.markup import escape

from ehamj.cli.frame import app, log
from ehamj.errors import InputError, SimulationFailed

# Imported for their commands, which `ehamj --help` lists in this order.
from ehamj.cli import (  # noqa: F401  # isort: skip
    run, scenarios, design, modes, paper, transmissibility, study, stored, bench, verify,
)  # fmt: skip

__all__ = ["app", "main"]


def main() -> NoReturn:
    """Run the command line; every error becomes one message and an exit code."""
    try:
        app(prog_name="ehamj")  # also where another program runs it
    except (InputError, SimulationFailed) as error:
        log.print(f"[bold red]ehamj:[/] {escape(str(error))}", highlight=False, soft_wrap=True)
        sys.exit(2 if isinstance(error, InputError) else 3)
    sys.exit(0)
