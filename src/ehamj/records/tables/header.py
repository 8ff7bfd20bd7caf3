"""Names and units of columns: in one cell, in rows of their own, in comments."""

import re
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

from ehamj.records.tables.cells import Dialect
from ehamj.records.units import is_silent, unit

OPENING = {"]": "[", ")": "(", "}": "{", ">": "<"}

_WORDS = "time timestamp datetime zeit zeitstempel uhrzeit date datum elapsed temps tiempo tempo tijd clock"
TIME_WORDS = frozenset(_WORDS.split())
"""Words in the name of a column of times."""

_NAMES = "t s ms us sec secs second seconds millis milliseconds micros microseconds"
TIME_NAMES = frozenset(_NAMES.split())
"""Whole names of columns of times."""

SAYS_UNIT = {"seconds": "s", "second": "s", "sec": "s", "secs": "s"} | {
    **{"millis": "ms", "milliseconds": "ms", "micros": "us", "microseconds": "us"}
}
"""Words in the name of a column of times that are its unit."""

QUANTITIES = {
    "acceleration": ("acc", "beschl"),
    "velocity": ("vel", "schwing", "geschw"),
    "displacement": ("disp", "weg", "pos", "auslenk"),
}
"""What words in the name of a column begin with, by what it then holds."""

LONGEST = 20_000
"""Characters of a header that may be parted otherwise than rows are."""
LONGEST_CELL = 200
"""Characters of a name with its unit."""

PREFIX = re.compile(r"^\s*(?:#|%|!|//|\*|;)+\s*")
"""Marks before a comment."""


class Named(NamedTuple):
    """A header's cell: the name, and the unit as written, None where there is none."""

    name: str
    unit: str | None


@lru_cache(1000)
def kind_of(text: str) -> str | None:
    """What a unit is of, None where it is none that is known."""
    try:
        return unit(text).kind
    except ValueError:
        return None


def words(name: str) -> list[str]:
    """Words of a name in lower case; ``accZ`` and ``acc_z`` are two."""
    apart = re.sub(r"(?<=[a-zäöü])(?=[A-Z])", " ", name)
    return [word for word in re.split(r"[\s_\-.:,/()\[\]]+", apart.lower()) if word]


def named(cell: str) -> Named:
    """Name and unit of a header's cell: ``z [m/s]``, ``z (m/s)``, ``z, m/s``, ``z in m/s``, ``z / m/s``, ``z_mg``, …

    Without brackets a unit is believed that is known; a single letter, only where the name says what it is of.
    """
    cell = cell.strip().strip('"').strip()
    if len(cell) > LONGEST_CELL:
        return Named(cell[:LONGEST_CELL], None)
    opening = _opening(cell)
    if opening is not None:
        return Named(cell[:opening].strip().rstrip(",;:/").strip(), cell[opening + 1 : -1].strip())
    for apart in (r"\s*[,;:]\s*", r"\s+in\s+", r"\s*/\s*"):
        name, mark, rest = _parted(cell, apart)
        if mark and name and kind_of(rest) and not kind_of(cell) and not (len(rest) == 1 and rest.isupper()):
            return Named(name, rest)
    for apart in ("_", " "):
        name, mark, rest = cell.rpartition(apart)
        kind = kind_of(rest) if mark and name.strip() else None
        if kind and _believed(name, rest, kind):
            return Named(name.strip(), rest)
    last = words(cell)[-1:]
    if last and last[0] in SAYS_UNIT:
        return Named(cell, SAYS_UNIT[last[0]])
    return Named(cell, None)


def _opening(cell: str) -> int | None:
    """Where the bracket opens that a cell ends with, None where it ends with none."""
    if not cell or cell[-1] not in OPENING:
        return None
    depth = 0
    for k in range(len(cell) - 1, -1, -1):
        depth += (cell[k] == cell[-1]) - (cell[k] == OPENING[cell[-1]])
        if depth == 0:
            # m/s^(2) and a/(m/s) end with a bracket that is part of the unit
            return k if k == 0 or cell[k - 1] not in "/^*·" else None
    return None


def _parted(cell: str, apart: str) -> tuple[str, str, str]:
    """A cell before, at and after the first place where ``apart`` matches."""
    match = re.search(apart, cell)
    if match is None:
        return cell, "", ""
    return cell[: match.start()].strip(), match[0], cell[match.end() :].strip()


def _believed(name: str, rest: str, kind: str) -> bool:
    """Whether the last part of a name is its unit: several letters, or a name that says what it is of."""
    if kind not in ("time", "displacement", "velocity", "acceleration"):
        return False
    if kind == "time":
        return is_time(name)
    if len(rest) > 1 and rest.lower() != "in" and ("/" in rest or not rest.isupper()):
        return True  # z_in may be a signal that comes in
    return rest.islower() and any(word.startswith(QUANTITIES[kind]) for word in words(name))


def is_time(name: str) -> bool:
    """Whether a column's name says that it holds times."""
    return name in TIME_NAMES or name.lower() in TIME_NAMES - {"t"} or bool(TIME_WORDS.intersection(words(name)))


def header_cells(line: str, dialect: Dialect, width: int, loose: bool) -> list[str] | None:
    """Cells of a line that may head ``width`` columns, None where it has another number of them.

    Args:
        line: of the file.
        dialect: of its rows.
        width: number of columns of the rows.
        loose: whether it may be parted otherwise than rows, as comments are.
    """
    if len(line) > LONGEST:
        return dialect.cells(line) if len(dialect.cells(line)) == width else None
    by_marks = [[cell.strip() for cell in line.split(mark)] for mark in ",;\t|"] if loose else []
    ways = [*by_marks, dialect.cells(line)] if dialect.delimiter == " " else [dialect.cells(line), *by_marks]
    if dialect.delimiter == " " or loose:
        ways += [re.split(r"\s{2,}|\t+", line.strip()), re.split(r"\s+(?![\[({<])(?![^\[({<]*[\])}>])", line.strip())]
    for n, cells in enumerate(ways):
        if n > 4 and dialect.delimiter != " " and not any(_opening(cell) for cell in cells):
            continue  # words of a sentence
        while len(cells) > width and not cells[-1]:
            cells = cells[:-1]
        if len(cells) == width and any(cells):
            return cells
    return None


def is_unit_row(cells: Sequence[str]) -> bool:
    """Whether cells are units, or say that there is none; one at least is, and none is a name with its unit."""
    if any(_opening(cell) and kind_of(named(cell).unit or "") for cell in cells):
        return False
    if any(is_time(cell) and kind_of(cell) is None for cell in cells):
        return False
    bare = [named(cell).unit if _opening(cell) == 0 else cell for cell in cells]
    known = [kind_of(cell or "") is not None for cell in bare]
    silent = [is_silent(cell or "") for cell in bare]
    return sum(known) > 0 and sum(known) + sum(silent) >= 0.5 * len(cells)


def bare_unit(cell: str) -> str | None:
    """A unit without its brackets, None where the cell states none."""
    found = named(cell).unit if _opening(cell) == 0 else cell
    return None if found is None or is_silent(found) else found
