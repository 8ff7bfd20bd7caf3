"""The page that an engineer hands on: what was simulated, the verdict, every figure and table, in one HTML file.

Its numbers are those of the summary, of the result's dataset and of its `ehamj.evaluation`; nothing is analysed here.
"""

from ehamj.report.page import report_page, write_report
from ehamj.report.shown import Shown

__all__ = ["Shown", "report_page", "write_report"]
