"""Where is kept what a later run need not make again: the user's cache folder, or one of his own in the temporary one.

Compiled code is run as it is found, so that a folder under the temporary one that others may write is none.
"""

import os
import stat
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path

from platformdirs import user_cache_path


@cache
def cache_folder() -> Path | None:
    """The cache folder, or None if none can be written.

    ``EHAMJ_CACHE_DIR`` names one; without it, it is the user's, and where that cannot be written, as for a user
    without a home, one of his own under the system's temporary folder.
    """
    for path in _candidates():
        with suppress(OSError):
            path.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=path):
                return path
    return None


def _candidates() -> Iterator[Path]:
    if named := os.environ.get("EHAMJ_CACHE_DIR"):
        yield Path(named)
        return
    yield user_cache_path("ehamj")
    with suppress(OSError):
        yield _own(Path(tempfile.gettempdir()))


def _own(temporary: Path) -> Path:
    """A folder under the temporary one that is this user's alone; raises OSError where it is another's."""
    user = os.getuid() if hasattr(os, "getuid") else 0  # elsewhere the temporary folder is the user's
    path = temporary / f"ehamj-{user}"
    path.mkdir(mode=0o700, exist_ok=True)
    found = path.lstat()
    shared = found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    if not stat.S_ISDIR(found.st_mode) or (hasattr(os, "getuid") and (found.st_uid != user or shared)):
        raise PermissionError(f"{path}: others may write it")
    return path


def let_matplotlib_keep_its_fonts() -> None:
    """Where the user has no home that can be written, name Matplotlib a folder: else it says so at each start, and
    lists all fonts again."""
    if "MPLCONFIGDIR" in os.environ:
        return
    with suppress(RuntimeError):  # no home is known
        home = Path.home()
        if any(os.access(path, os.W_OK) for path in (home, home / ".config", home / ".config/matplotlib")):
            return
    if folder := cache_folder():
        os.environ["MPLCONFIGDIR"] = str(folder / "matplotlib")
