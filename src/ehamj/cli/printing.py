"""What commands print: tables, lines, lists of names, and JSON."""

import json
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich import box
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from ehamj.cli.frame import out

NUMBER = re.compile(r"[-+−–]?[\d.]*(e[-+]\d+)?( ±[\d.]+)?")
"""What a table puts to the right."""


def print_table(
    title: str, heads: Sequence[str], rows: Iterable[Sequence[str | Text]], whole: int = 1, gap: int = 2
) -> None:
    """Print a table: cells as they are, numbers to the right, in the first ``whole`` columns no line breaks, and so
    many spaces between columns (1 or more)."""
    cells = [[cell if isinstance(cell, Text) else Text(cell) for cell in row] for row in rows]
    table = Table(title=Text(title), box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, gap - 1, 0, 0))
    for k, head in enumerate(heads):
        number = all(NUMBER.fullmatch(row[k].plain) for row in cells)
        table.add_column(Text(head), no_wrap=number or k < whole, justify="right" if number else "left")
    for row in cells:
        table.add_row(*row)
    out.print(table)


def say(text: str, words: bool = False) -> None:
    """Print a line as it is: nothing in it is markup, and it breaks where the terminal does, or between its words."""
    out.print(text, markup=False, highlight=False, soft_wrap=not words)


def print_json(content: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(content, allow_nan=False) + "\n")


def print_names(key: str, found: Mapping[str, str], about: str, as_json: bool) -> None:
    """List what there is, a line each: name and what it is ``about``; as JSON under ``key``."""
    if as_json:
        print_json({key: [{"name": name, about: text} for name, text in found.items()]})
        return
    for name, text in found.items():
        out.print(f"[bold]{name:16}[/] {escape(text)}", highlight=False, soft_wrap=True)
