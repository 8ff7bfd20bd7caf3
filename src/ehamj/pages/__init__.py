"""Pages without external parts: what stands on one, how numbers are written, and how it becomes files.

A `Page` is a list of `Section`; a section holds notes, figures and tables. `write_page` is the one way to HTML.
"""

from ehamj.pages.document import render, write_page
from ehamj.pages.parts import ANNEX, Page, Picture, Section, Table, badge, safe_name

__all__ = ["ANNEX", "Page", "Picture", "Section", "Table", "badge", "render", "safe_name", "write_page"]
