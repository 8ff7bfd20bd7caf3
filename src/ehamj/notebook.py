"""How objects look in a notebook: a table of text, everything in it escaped."""

from collections.abc import Iterable, Sequence
from html import escape

_LEFT = ' style="text-align:left"'


def html_table(rows: Iterable[Sequence[str]], head: Sequence[str] = (), title: str = "") -> str:
    """A table as HTML, the first cell of each row its name.

    Args:
        rows: cells of text, any number.
        head: names of the columns.
        title: what stands above it.
    """
    named = f"<caption{_LEFT}>{escape(title)}</caption>" if title else ""
    above = f"<thead><tr>{''.join(f'<th{_LEFT}>{escape(cell)}</th>' for cell in head)}</tr></thead>" if head else ""
    body = "".join(
        f"<tr><th{_LEFT}>{escape(name)}</th>{''.join(f'<td{_LEFT}>{escape(cell)}</td>' for cell in cells)}</tr>"
        for name, *cells in rows
    )
    return f"<table>{named}{above}<tbody>{body}</tbody></table>"


def html_list(title: str, items: Iterable[str], below: str = "") -> str:
    """A title, a list of sentences, and a line below them, as HTML."""
    points = "".join(f"<li>{escape(item)}</li>" for item in items)
    return f"<p><b>{escape(title)}</b></p><ul>{points}</ul>" + (f"<p>{escape(below)}</p>" if below else "")
