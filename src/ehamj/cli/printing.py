"""What commands print: tables, lines, lists of names, and JSON."""

import json
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from rich import box
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from ehamj.cli.folding import fitted, folded, hung, laid_out, natural
from ehamj.cli.frame import out

NUMBER: Final = re.compile(r"[-+−–]?[\d.]*(e[-+]\d+| × 10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?( ±[\d.]+)?")
"""What a table puts to the right."""
NAME_WIDTH: Final = 16
"""Of the column of names in a list."""


def print_table(
    title: str, heads: Sequence[str], rows: Iterable[Sequence[str | Text]], whole: int = 1, gap: int = 2
) -> None:
    """Print a table within the terminal's width: no word is cut.

    Numbers stand to the right. Where there is room, no line breaks in the first ``whole`` columns and in those of
    numbers; where not even the longest words have room beside each other, a row is a block of lines.

    Args:
        title: above it.
        heads: of the columns.
        rows: their cells.
        whole: see above.
        gap: spaces between columns (1 or more).
    """
    cells = [[cell if isinstance(cell, Text) else Text(cell) for cell in row] for row in rows]
    texts = [[cell.plain for cell in row] for row in cells]
    numbers = [all(NUMBER.fullmatch(row[k]) for row in texts) for k in range(len(heads))]
    kept = [number or k < whole for k, number in enumerate(numbers)]
    if title:
        out.print(Text(hung(title, out.width, ""), "bold"))
    for choice in (kept, [False] * len(heads)):
        widths = laid_out(heads, texts, choice, out.width - gap * (len(heads) - 1))
        if widths is not None:
            break
    else:
        _print_blocks(heads, cells)
        return
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, gap - 1, 0, 0))
    for head, number, width in zip(heads, numbers, widths, strict=True):
        table.add_column(
            Text(folded(head, width)), no_wrap=True, justify="right" if number else "left", width=width, overflow="fold"
        )
    for row in cells:
        wrapped = (Text(folded(c.plain, w), c.style) for c, w in zip(row, widths, strict=True))
        table.add_row(*wrapped)
    out.print(table)
    out.print()


def _print_blocks(heads: Sequence[str], rows: Sequence[Sequence[Text]]) -> None:
    """Print rows one below the other: the first cell, below it each other one behind its head."""
    for first, *others in rows:
        out.print(Text(hung(first.plain, out.width), first.style), soft_wrap=True)
        for head, cell in zip(heads[1:], others, strict=True):
            if cell.plain:
                said = f"  {' '.join(head.split())}: {cell.plain}".replace("  :", " ")
                out.print(Text(hung(said, out.width, "    "), cell.style), soft_wrap=True)
    out.print()


def say(text: str, label: str = "", whole: bool = False) -> None:
    """Print a line, a ``label`` in bold before it; nothing in it is markup.

    Before a terminal it breaks between words, and what follows is indented; elsewhere it is one line, however long, as
    is a command or a path (``whole``), which someone may copy.
    """
    line = f"{label}{text}"
    said = Text(line if whole else fitted(line, out))
    said.stylize("bold", 0, len(label))
    out.print(said, soft_wrap=True)


def print_json(content: dict[str, Any]) -> None:
    sys.stdout.write(json.dumps(content, allow_nan=False) + "\n")


def print_names(key: str, found: Mapping[str, str], about: str, as_json: bool) -> None:
    """List what there is: name and what it is ``about``, a line each where it is no terminal; as JSON under ``key``."""
    if as_json:
        print_json({key: [{"name": name, about: text} for name, text in found.items()]})
        return
    width = max(NAME_WIDTH, *map(natural, found)) + 1
    for name, text in found.items():
        line = f"{name:{width}}{text}"
        line = hung(line, out.width, " " * width) if out.is_terminal else line
        out.print(f"[bold]{escape(line[:width])}[/]{escape(line[width:])}", highlight=False, soft_wrap=True)
