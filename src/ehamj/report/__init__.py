"""The page that an engineer hands on: what was simulated, the verdict, every figure and table, in one HTML file.

Its numbers are those of the summary and of the result's dataset; nothing is analysed again here.
"""

from ehamj.report.page import draw, page, write_report
from ehamj.report.parts import Picture

__all__ = ["Picture", "draw", "page", "write_report"]
