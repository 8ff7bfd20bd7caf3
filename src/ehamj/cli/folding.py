"""How text and tables are fitted to a width: lines break between words, and no word is cut."""

import re
import textwrap
from collections.abc import Sequence

from rich.console import Console

from ehamj.plain.glue import GLUE, glued


def natural(text: str) -> int:
    """Width of a text that is not broken: its longest line."""
    return max(map(len, text.split("\n")))


def longest_word(text: str) -> int:
    """Width that a text needs at least, broken between its words."""
    return max(map(len, re.split(r"[ \n]", glued(text))))


def hung(text: str, width: int, after: str = "  ") -> str:
    """A text broken between words, numbers beside their units; each line after the first begins with ``after``.

    A word that is longer than the width, as a path may be, is left whole.
    """
    if width <= len(after) + 1:
        return text
    lines = [
        textwrap.fill(
            glued(line),
            width,
            subsequent_indent=after if not k else re.match(" *", line)[0] + after,  # type: ignore[index]
            break_long_words=False,
            break_on_hyphens=False,
        )
        for k, line in enumerate(text.split("\n"))
    ]
    return "\n".join(lines).replace(GLUE, " ")


def fitted(line: str, console: Console) -> str:
    """A line as it is said: before a terminal broken between words and indented, elsewhere one line however long."""
    return hung(line, console.width) if console.is_terminal else line


def folded(text: str, width: int) -> str:
    """A cell broken between words to a width."""
    return hung(text, width, "") if natural(text) > width else text


def laid_out(heads: Sequence[str], rows: Sequence[Sequence[str]], kept: Sequence[bool], width: int) -> list[int] | None:
    """Widths of a table's columns that fit together into one, None where their longest words do not.

    Args:
        heads: of the columns, which may break between words.
        rows: their cells.
        kept: of each column, whether no line breaks in its cells.
        width: that all columns may have together.
    """
    least, wanted = [], []
    for k, head in enumerate(heads):
        cells = [row[k] for row in rows]
        widest = max(map(natural, cells), default=0)
        need = widest if kept[k] else max(map(longest_word, cells), default=0)
        least.append(max(longest_word(head), need, 1))
        wanted.append(max(natural(head), widest, 1))
    room = width - sum(least)
    if room < 0:
        return None
    more = [full - own for full, own in zip(wanted, least, strict=True)]
    if sum(more) <= room:
        return wanted
    given = [room * part // sum(more) for part in more]
    for k in sorted(range(len(more)), key=lambda k: more[k] - given[k], reverse=True)[: room - sum(given)]:
        given[k] += 1
    return [own + part for own, part in zip(least, given, strict=True)]
