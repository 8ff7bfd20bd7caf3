"""The page that an engineer hands on: what was simulated, the verdict, every figure and table, in one HTML file.

Its numbers are those of the summary and of the result's dataset; nothing is analysed again here.
"""

from ehamj.report.page import report_page, write_report

__all__ = ["report_page", "write_report"]
