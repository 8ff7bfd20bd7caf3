"""Long series: sums of many lines, and many samples, in memory that does not grow with their length."""

from ehamj.series.grid import check_lines, room
from ehamj.series.held import PART, Held, parts, stored
from ehamj.series.lines import Lines
from ehamj.series.sampled import Sampled

__all__ = ["PART", "Held", "Lines", "Sampled", "check_lines", "parts", "room", "stored"]
