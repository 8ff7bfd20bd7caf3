"""One way into a recording: a file that appears when it is whole, what stays in it and what moves."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import RrdReader
from rerun.error_utils import catch_and_log_exceptions

from ehamj.replay.names import TIMELINE, Array, nanoseconds
from ehamj.result import written_whole


@contextmanager
def recorded(
    path: Path, application: str, title: str, layout: Callable[[], rrb.Blueprint]
) -> Iterator[rr.RecordingStream]:
    """A recording that becomes the file when everything is logged.

    Raises:
        OSError: if the file cannot be written.
    """
    # Rerun only warns of what it cannot log, unless told otherwise: here it is told for this block and thread alone.
    with written_whole(Path(path)) as temporary, catch_and_log_exceptions(strict=True):
        recording = rr.RecordingStream(application)
        try:
            temporary.touch()  # fails with the system's own error where nothing can be written
            recording.save(temporary, default_blueprint=layout())
            recording.send_recording_name(title)
            yield recording
        finally:
            recording.disconnect()
        check_whole(temporary)


def fixed(recording: rr.RecordingStream, path: str, what: Any) -> None:
    """Log what stays as it is."""
    recording.log(path, what, static=True, strict=True)


def moving(recording: rr.RecordingStream, path: str, time: Array, columns: Any, timeline: str = TIMELINE) -> None:
    """Log what has a value at each time [s]."""
    stamps = rr.TimeColumn(timeline, duration=nanoseconds(time).view("timedelta64[ns]"))
    recording.send_columns(path, [stamps], columns, strict=True)


def check_whole(path: Path) -> None:
    """Read the file's end: Rerun writes on a thread of its own, and what goes wrong there it only prints.

    Raises:
        OSError: if the file is not whole.
    """
    try:
        RrdReader(path).store()
    except (OSError, RuntimeError, ValueError) as error:
        raise OSError(f"recording not written whole; is the disk full, or Rerun off (RERUN=off)? {error}") from error
