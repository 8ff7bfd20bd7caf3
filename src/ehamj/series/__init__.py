"""Sums of many lines: what random floors and forces are made of, in memory that does not grow with their length."""

from ehamj.lines.held import PART, Held, parts, room
from ehamj.lines.periodic import Lines

__all__ = ["PART", "Held", "Lines", "parts", "room"]
