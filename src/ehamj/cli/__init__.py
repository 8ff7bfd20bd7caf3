"""The command line: printing, paths, exit codes, nothing else. Its commands stand in modules by what they do."""

import sys
from typing import NoReturn

from rich.markup import escape

from ehamj.cli.frame import app, log
from ehamj.errors import InputError, SimulationFailed

# Imported for their commands, which `ehamj --help` lists in this order.
from ehamj.cli import running, designing, modal, analysing, responding, studying, showing, checking  # isort: skip

__all__ = ["analysing", "app", "checking", "designing", "main", "modal", "responding", "running", "showing", "studying"]


def main() -> NoReturn:
    """Run the command line; every error becomes one message and an exit code."""
    try:
        app()
    except (InputError, SimulationFailed) as error:
        log.print(f"[bold red]ehamj:[/] {escape(str(error))}", highlight=False, soft_wrap=True)
        sys.exit(2 if isinstance(error, InputError) else 3)
    sys.exit(0)
