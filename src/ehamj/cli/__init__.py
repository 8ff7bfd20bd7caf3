"""The command line: printing, paths, exit codes, nothing else. Its commands stand in modules by what they do."""

import sys
from typing import TYPE_CHECKING, Any, NoReturn

from ehamj.interruption import EXIT_CODE, Interrupted, watched

if TYPE_CHECKING:
    from ehamj.cli.frame import app as app

__all__ = ["app", "main"]

_said = False
"""Whether the user knows that he interrupted."""


def __getattr__(name: str) -> Any:
    """The app, imported when it is asked for: whoever interrupts while it is imported sees no traceback."""
    if name != "app":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from ehamj.cli.frame import app

    return app


def main() -> NoReturn:
    """Run the command line; every error becomes one message and an exit code, what should be known a note."""
    try:
        with watched(_give_up):
            from ehamj.cli.outcome import exit_code

            code = exit_code()
    except (Interrupted, KeyboardInterrupt):
        _give_up()
        code = EXIT_CODE
    sys.exit(code)


def _give_up() -> None:
    """Remove what is half written, for a process that ends now, and say so, once."""
    global _said
    from multiprocessing import active_children

    from ehamj.unfinished import remove_all

    for process in active_children():
        process.kill()
    remove_all()
    if not _said:
        _said = True
        sys.stderr.write("\nehamj: interrupted; what was not finished is not kept\n")
