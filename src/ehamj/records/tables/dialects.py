"""Which dialect a table is written in: every one is tried, and what two of them read differently is refused."""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ehamj.records.table_choices import TableChoices
from ehamj.records.tables.cells import NAMES, NUMBER, Dialect

SAMPLE = 400
"""Lines from the middle of a table that its dialect is sought in."""


GROUPED = re.compile(r"[-+]?[1-9]\d{0,2}\.\d{3}")
"""A number whose mark may part thousands."""


class Shape(NamedTuple):
    """What rows look like in a dialect: the kind of each column by most of its cells."""

    dialect: Dialect
    kinds: str
    rows: int = 0
    """How many lines look so."""
    odd: float = 0.0
    """Cells of each that are neither numbers nor times, in the mean."""
    doubtful: bool = False
    """Whether all that might be numbers have marks that no number has."""

    @property
    def lead(self) -> int:
        """The first column of numbers or times, by which a row is known."""
        return next(k for k, kind in enumerate(self.kinds) if kind in "nt")

    def is_row(self, line: str) -> bool:
        """Whether a line has the columns, each of its kind or empty, and a number."""
        kinds = self.dialect.kinds(line)
        return len(kinds) == len(self.kinds) and self._fits(kinds)

    def begins_as_row(self, line: str) -> bool:
        """Whether a line holds a number or a time where rows do first."""
        kinds = self.dialect.kinds(line)
        return len(kinds) > self.lead and kinds[self.lead] in "nt"

    def _fits(self, kinds: str) -> bool:
        pairs = list(zip(self.kinds, kinds, strict=True))
        return any(pair[1] in "no" for pair in pairs) and all(
            found in {"n": "noe", "o": "noe", "t": "te"}.get(usual, "notew") for usual, found in pairs
        )


def sample_of(lines: Sequence[str], comments: tuple[str, ...]) -> list[str]:
    """Lines of the latter half (of a short file: all), where rows are most likely, without blank ones and comments."""
    kept = [line for line in lines[len(lines) // 2 if len(lines) >= 60 else 0 :][: 2 * SAMPLE] if line.strip()]
    return [line for line in kept if not line.lstrip().startswith(comments)][:SAMPLE]


def shapes(sample: Sequence[str], choices: TableChoices) -> list[Shape]:
    """Every dialect in which the lines are rows of numbers, as far as the user leaves it open."""
    found = []
    text = "".join(sample)
    for dialect in _dialects(choices, text):
        shape = _shape(sample, dialect)
        if shape is not None:
            found.append(shape)
    found = [shape for shape in found if not shape.doubtful] or found
    most = max((shape.rows for shape in found), default=0)
    return [shape for shape in found if shape.rows >= 0.5 * most]


def _dialects(choices: TableChoices, text: str) -> Iterator[Dialect]:
    """Dialects that may be that of a text: marks that it does not hold make no difference."""
    missing = frozenset(choices.missing or ())
    marks = [mark for mark in NAMES if mark in ",; " or mark in text]
    for delimiter in marks if choices.delimiter is None else (choices.delimiter,):
        for decimal in (".," if "," in text else ".") if choices.decimal is None else (choices.decimal,):
            if decimal != choices.thousands:
                yield Dialect(delimiter, decimal, choices.thousands, missing)


def _shape(sample: Sequence[str], dialect: Dialect) -> Shape | None:
    """The shape of most lines with a number; None where no line is a row of it."""
    kinds = [kinds for kinds in map(dialect.kinds, sample) if "n" in kinds or "o" in kinds]
    if not kinds:
        return None
    widths = Counter(map(len, kinds))
    width = max(widths, key=lambda size: (widths[size], size))
    alike = [one for one in kinds if len(one) == width]
    usual = "".join(_usual(column) for column in zip(*alike, strict=True))
    rows = [one for one in alike if Shape(dialect, usual)._fits(one)]
    if rows:  # without lines above the rows that look alike
        usual = "".join(
            "e" if set(column) == {"e"} else kind for kind, column in zip(usual, zip(*rows, strict=True), strict=True)
        )
    if "n" not in usual and "o" not in usual:
        return None
    odd = sum(one.count("o") + one.count("w") for one in rows) / max(1, len(rows))
    doubtful = "n" not in usual
    return Shape(dialect, usual.replace("o", "n") if doubtful else usual, len(rows), odd, doubtful) if rows else None


def _usual(column: tuple[str, ...]) -> str:
    """The kind of a column: of most of its cells that are not empty; numbers and times before words."""
    count = Counter(column)
    if count["e"] == len(column):
        return "e"
    if count["o"] > count["n"] and count["o"] + count["n"] >= max(count["t"], count["w"]):
        return "o"
    return max("ntw", key=lambda kind: count[kind] + (count["o"] if kind == "n" else 0))


def chosen(
    candidates: Sequence[Shape], named: Sequence[bool], sample: Sequence[str], told: str, key: str, stated: bool
) -> Shape:
    """The one dialect that explains the table best: its header has as many cells as its rows, and fewest are words.

    Args:
        candidates: from `shapes`.
        named: whether the header fits each of them.
        sample: lines that they were found in.
        told: what messages begin with.
        key: of the user's choices, for messages.
        stated: whether the user says what the decimal mark is.

    Raises:
        ValueError: where two dialects explain it and give other numbers, or a mark may part thousands.
    """
    fitting = [shape for shape, fits in zip(candidates, named, strict=True) if fits] or list(candidates)
    mixed = [_mixed(shape, sample) for shape in fitting]
    fitting = [shape for shape, cells in zip(fitting, mixed, strict=True) if cells == min(mixed)]
    least = min(shape.odd for shape in fitting)
    fitting = [shape for shape in fitting if shape.odd == least]
    first = fitting[0]
    for other in fitting[1:]:
        rows = (line for line in sample if first.is_row(line) or other.is_row(line))
        differing = next((line for line in rows if _read(first, line) != _read(other, line)), None)
        if differing is not None:
            raise ValueError(
                f"{told}: {differing.strip()[:60]!r} may be read in two ways: {_words(first, differing)}, or "
                f"{_words(other, differing)}; state {key}.delimiter and {key}.decimal"
            )
    if not stated:
        _check_marks(first, sample, told, key)
    return first


def _mixed(shape: Shape, sample: Sequence[str]) -> int:
    """Cells of a few rows that hold what parts cells in other dialects; blanks part none where tabs may."""
    rows = [line for line in sample if shape.is_row(line)][:20]
    marks = set(";\t|") - {shape.dialect.delimiter}
    if shape.dialect.delimiter == " ":
        return sum("\t" in row.strip() for row in rows)
    return sum(_parts(cell, marks) for row in rows for cell in shape.dialect.cells(row))


def _parts(cell: str, marks: set[str]) -> bool:
    """Whether a cell holds marks, or a number beside words."""
    pieces = cell.split()
    return bool(marks.intersection(cell)) or (len(pieces) > 1 and any(piece.isdigit() for piece in pieces))


def _read(shape: Shape, line: str) -> list[float | str | None]:
    """What a row's cells are, but for empty ones at its end; NaN, which equals nothing, becomes a word."""
    dialect = shape.dialect
    cells = dialect.cells(line)
    found = [c if dialect.number(c) is None else "" if dialect.kind(c) == "e" else dialect.number(c) for c in cells]
    while found and found[-1] == "":
        found.pop()
    return found


def _words(shape: Shape, line: str) -> str:
    cells = _read(shape, line)
    values = ", ".join(f"{cell:g}" if isinstance(cell, float) else repr(cell) for cell in cells)
    return f"{shape.dialect} ({len(cells)} cells: {values[:60]})"


def _check_marks(shape: Shape, sample: Sequence[str], told: str, key: str) -> None:
    """Raise ValueError where every decimal mark might part thousands as well: 1,234 is one and a bit, or many."""
    dialect = shape.dialect
    if dialect.thousands is not None or (dialect.delimiter == "," and dialect.decimal == "."):
        return
    cells = [c for line in sample if shape.is_row(line) for c in dialect.cells(line) if dialect.decimal in c]
    numbers = [cell for cell in cells if NUMBER[dialect.decimal].fullmatch(cell)]
    if numbers and all(GROUPED.fullmatch(cell.replace(dialect.decimal, ".")) for cell in numbers):
        other = {".": ",", ",": "."}[dialect.decimal]
        raise ValueError(
            f"{told}: the mark in {numbers[0]!r} may be a decimal one or part thousands, and no cell tells; state "
            f"{key}.decimal = {dialect.decimal!r}, or {key}.decimal = {other!r} and {key}.thousands = "
            f"{dialect.decimal!r}"
        )
