"""Long series: sums of many lines, and many samples, in memory that does not grow with their length."""

from ehamj.series.grid import check_lines, room
from ehamj.series.held import PART, Held, parts, stored
from ehamj.series.lines import Lines
from ehamj.series.recorded import Replayed, Stairs, Straight
from ehamj.series.sampled import Sampled

__all__ = [
    "PART",
    "Held",
    "Lines",
    "Replayed",
    "Sampled",
    "Stairs",
    "Straight",
    "check_lines",
    "parts",
    "room",
    "stored",
]
