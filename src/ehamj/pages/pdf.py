"""A page as PDF, printed by a browser that is installed: none comes with ehamj."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Final

from ehamj.errors import InputError
from ehamj.result import written_whole

BROWSER: Final = "EHAMJ_BROWSER"
"""Environment variable that names the browser, where it is not one of `NAMES` on the path."""
NAMES: Final = (
    "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "microsoft-edge", "msedge",
)  # fmt: skip
"""Browsers that print without a window."""
LONGEST: Final = 120.0
"""Time that a browser has [s]."""
QUIET: Final = (
    "--headless", "--disable-gpu", "--no-first-run", "--no-pdf-header-footer", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
)  # fmt: skip


def browser() -> str | None:
    """The browser that prints, None where there is none."""
    return next(filter(None, map(shutil.which, (os.environ.get(BROWSER, ""), *NAMES))), None)


def check_browser(page: Path) -> str:
    """The browser that prints.

    Raises:
        InputError: if there is none; with what to do with the ``page`` instead.
    """
    found = browser()
    if found is None:
        raise InputError(
            f"--pdf: no Chromium, Chrome or Edge on the path, and none named by {BROWSER}; leave it out and print "
            f"{page} from any browser"
        )
    return found


def print_page(page: Path, target: Path) -> None:
    """Print a page as a PDF file, which appears when it is whole.

    Raises:
        InputError: if there is no browser, or it printed nothing.
    """
    command = [check_browser(page), *QUIET]
    if hasattr(os, "geteuid") and os.geteuid() == 0:  # as in a container; Chromium refuses to run as root otherwise
        command.append("--no-sandbox")
    with (
        tempfile.TemporaryDirectory(prefix="ehamj-", ignore_cleanup_errors=True) as profile,
        written_whole(target) as to,
    ):
        command += [f"--user-data-dir={profile}", f"--print-to-pdf={to.resolve()}", page.resolve().as_uri()]
        try:
            subprocess.run(command, capture_output=True, timeout=LONGEST, check=True)
        except subprocess.TimeoutExpired:
            raise InputError(_instead(command[0], f"did not finish within {LONGEST:g} s", page)) from None
        except (subprocess.CalledProcessError, OSError) as error:
            raise InputError(_instead(command[0], f"failed ({error})", page)) from None
        if not to.is_file() or not to.read_bytes().startswith(b"%PDF"):
            raise InputError(_instead(command[0], "wrote no PDF", page))


def _instead(program: str, what: str, page: Path) -> str:
    return f"--pdf: {program} {what}; print {page} from any browser"
