"""What the parts of a recording share: its timeline, entity paths and colours."""

from typing import Final

import numpy as np
import rerun as rr
from numpy.typing import NDArray

Array = NDArray[np.float64]
Color = tuple[int, int, int]

TIMELINE: Final = "sim_time"
"""Simulated time, in whole nanoseconds."""

GROUND_COLOR: Final[Color] = (110, 165, 235)
"""Everything that is the ground: its lines, its pads."""

RESULT_COLORS: Final[tuple[Color, ...]] = (
    (92, 214, 140),
    (240, 110, 150),
    (240, 220, 90),
    (105, 220, 225),
    (190, 150, 255),
    (255, 170, 90),
)
"""One per result, over again when there are more."""

MOUNT_COLORS: Final[tuple[Color, ...]] = ((79, 195, 247), (255, 183, 77), (129, 199, 132), (240, 110, 130))
"""One per mount, in their order."""


def entity(*parts: str) -> str:
    """An entity path, its parts escaped: labels and mounts may hold blanks and slashes."""
    return rr.new_entity_path(list(parts))


def result_color(index: int) -> Color:
    """Colour of a result by its place in the comparison."""
    return RESULT_COLORS[index % len(RESULT_COLORS)]


def nanoseconds(time: Array) -> NDArray[np.int64]:
    """Time stamps [s] as whole nanoseconds; Rerun truncates float seconds and would be off by one."""
    return np.round(time * 1e9).astype(np.int64)
