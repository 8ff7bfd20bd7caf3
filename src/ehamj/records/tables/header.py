"""Names and units of columns: in one cell, in rows of their own, in comments."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from ehamj.records.tables.cells import Dialect
from ehamj.records.units import ORDERS, Kind, is_motion, is_silent, kind_of

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

NUMBER = r"\d(?:[\d.,']*\d)?(?:e[-+]?\d+|\s*(?:\^|\*\*)\s*[-−+]?\d+|[-−⁻⁺]?[⁰¹²³⁴-⁹]+|(?<=10)[-−]\d+)?(?:\s*/\s*\d+)?"
TIMES = "[x×*·]"
FACTOR = re.compile(rf"({TIMES}?\s*{NUMBER})[\s_]*{TIMES}?[\s_]*([^\W\d_].*)", re.IGNORECASE)
"""A number before a unit: a factor, for all that anybody can tell."""

SCALED = re.compile(rf"[\s_]+({TIMES}\s*{NUMBER}|\d[\d.,]*e[-+]?\d+|10\s*\^\s*[-−]?\d+|0[.,]0*1)$", re.IGNORECASE)
"""A number at the end of a name that counts nothing."""

BEGINS = re.compile(r"(?<![a-zäöü\d.,^−⁻-])(?=[x×*·]?\s*\d)", re.IGNORECASE)
"""Where a number may begin in a header's cell."""

NUMBERED = re.compile(
    r"(?:ch|chan|channel|kanal|sensor|geophone?|point|messpunkt|mp|pos|position|no|nr|ai|axis|achse|node|slot|track)\.?",
    re.IGNORECASE,
)
"""Words after which a whole number counts channels."""

PREFIX = re.compile(r"^\s*(?:#|%|!|//|\*|;)+\s*")
"""Marks before a comment."""


class Named(NamedTuple):
    """A header's cell: the name, and the unit as written, None where there is none."""

    name: str
    unit: str | None


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
        name, unit_text = cell[:opening].strip().rstrip(",;:/").strip(), cell[opening + 1 : -1].strip()
        scaled = SCALED.search(name) if kind_of(unit_text) else None
        return Named(name[: scaled.start()], f"{scaled[1]} {unit_text}") if scaled else Named(name, unit_text)
    found = _multiple(cell) or _unbracketed(cell)
    if found is not None:
        return found
    last = words(cell)[-1:]
    if last and last[0] in SAYS_UNIT:
        return Named(cell, SAYS_UNIT[last[0]])
    return Named(cell, None)


def _multiple(cell: str) -> Named | None:
    """Name and unit of a cell such as ``z 0.01 mm``, whose unit has a factor; numbers of channels are none."""
    for begin in BEGINS.finditer(cell):
        match = FACTOR.fullmatch(cell, begin.start())
        name = re.sub(r"(?:\s+in)?[\s_,;:/]*$", "", cell[: begin.start()])
        if match is None or not name:
            continue
        last = words(name)[-1:]
        counts = match[1].isdigit() and (
            match[1] == "1"
            or bool(last and NUMBERED.fullmatch(last[0]))
            or (len(match[1]) == 1 and cell[begin.start() - 1] == "_")
        )
        if not counts and (is_motion(match[2]) or (kind_of(match[2]) == "time" and is_time(name))):
            return Named(name, cell[begin.start() :].strip())
    return None


def factor_of(text: str) -> tuple[str, str] | None:
    """The number before a unit, and the unit; None where it has none."""
    match = FACTOR.fullmatch(text.strip())
    return (match[1].strip(), match[2]) if match and kind_of(match[2]) else None


def _unbracketed(cell: str) -> Named | None:
    """Name and unit of a cell without brackets; a unit after the last blank may hold a ``/``."""
    if kind_of(cell):
        return None
    for apart in (r"\s*[,;:]\s*", r"\s+in\s+"):
        name, mark, rest = _parted(cell, apart)
        if mark and name and kind_of(rest) and not (len(rest) == 1 and rest.isupper()):
            return Named(name, rest)
    for blank in reversed(list(re.finditer(r"[\s_]+", cell))):
        name, rest = cell[: blank.start()], cell[blank.end() :]
        kind = kind_of(rest) if name and name[-1] not in "/*·^" else None
        if kind and _believed(name, rest, kind):
            return Named(name, rest)
    name, mark, rest = _parted(cell, r"\s*/\s*")
    kind = kind_of(rest) if mark and name and not (len(rest) == 1 and rest.isupper()) else None
    return Named(name, rest) if kind and (kind != "time" or is_time(name)) else None


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


def _believed(name: str, rest: str, kind: Kind) -> bool:
    """Whether the last part of a name is its unit: several letters, or a name that says what it is of."""
    if kind not in ORDERS:
        return kind == "time" and is_time(name)
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
    # N and A are north and a name as often as newton and ampere: beside others only they are believed.
    sure = [one and cell not in ("A", "N") for one, cell in zip(known, bare, strict=True)]
    return any(sure) and sum(known) + sum(silent) >= 0.5 * len(cells)


def bare_unit(cell: str) -> str | None:
    """A unit without its brackets, None where the cell states none."""
    found = named(cell).unit if _opening(cell) == 0 else cell
    return None if found is None or is_silent(found) else found
