"""Long series: sums of many lines, and many samples, in memory that does not grow with their length."""

from ehamj.series.grid import room
from ehamj.series.held import PART, Held, parts, stored
from ehamj.series.lines import Lines
from ehamj.series.sampled import Sampled

__all__ = ["PART", "Held", "Lines", "Sampled", "parts", "room", "stored"]
