"""Whether a recording is whole."""

from pathlib import Path

from rerun.chunk import RrdReader


def check_whole(path: Path) -> None:
    """Read the file's end: Rerun writes on a thread of its own, and what goes wrong there it only prints.

    Raises:
        OSError: if the file is not whole.
    """
    try:
        RrdReader(path).store()
    except (OSError, RuntimeError, ValueError) as error:
        raise OSError(f"recording not written whole; is the disk full, or Rerun off (RERUN=off)? {error}") from error
