"""One way into a recording: a file that appears when it is whole, paths, what stays in it and what moves, colours."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray
from rerun.chunk import RrdReader
from rerun.error_utils import catch_and_log_exceptions

from ehamj.arrays import Array
from ehamj.result import written_whole

Color = tuple[int, int, int]

TIMELINE: Final = "sim_time"
"""Simulated time, in whole nanoseconds."""

GROUND_COLOR: Final[Color] = (110, 165, 235)
"""Everything that is the ground: its lines, its pads."""

FAULT_COLOR: Final[Color] = (255, 70, 60)
"""What has failed."""

RESULT_COLORS: Final[tuple[Color, ...]] = (
    (92, 214, 140),
    (240, 110, 150),
    (240, 220, 90),
    (105, 220, 225),
    (190, 150, 255),
    (255, 170, 90),
)
"""One per result, over again when there are more."""

MOUNT_COLORS: Final[tuple[Color, ...]] = (
    (79, 195, 247),
    (255, 183, 77),
    (129, 199, 132),
    (240, 110, 130),
    (190, 150, 255),
    (240, 220, 90),
    (105, 220, 225),
    (200, 160, 130),
)
"""One per mount of a group, in their order."""


@contextmanager
def recorded(
    path: Path, application: str, title: str, layout: Callable[[], rrb.Blueprint], mark: str | None = None
) -> Iterator[rr.RecordingStream]:
    """A recording that becomes the file when everything is logged; ``mark`` tells it from others, by default chance.

    Raises:
        OSError: if the file cannot be written.
    """
    # Rerun only warns of what it cannot log, unless told otherwise: here it is told for this block and thread alone.
    with written_whole(Path(path)) as temporary, catch_and_log_exceptions(strict=True):
        recording = rr.RecordingStream(application, recording_id=mark)
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


def entity(*parts: str) -> str:
    """An entity path, its parts escaped: labels and mounts may hold blanks and slashes."""
    return rr.new_entity_path(list(parts))


def result_color(index: int) -> Color:
    """Colour of a result by its place in the comparison."""
    return RESULT_COLORS[index % len(RESULT_COLORS)]


def nanoseconds(time: Array) -> NDArray[np.int64]:
    """Time stamps [s] as whole nanoseconds; Rerun truncates float seconds and would be off by one."""
    return np.round(time * 1e9).astype(np.int64)
