"""A table of text: understood first, then read, column by column."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ehamj.records.lines import lines_of
from ehamj.records.table_choices import UNSAID, TableChoices
from ehamj.records.tables.cells import Dialect
from ehamj.records.tables.layout import Column, Layout, layout
from ehamj.signals import Array

SHORT = 0.02
"""Share of cells that are shorter than one that is believed whole, where the file ends amid a line."""


@dataclass(frozen=True)
class Table:
    """Columns of a file of text; numbers are read, and judged, for the columns that are asked for only."""

    label: str
    key: str
    """Of the file's name in the scenario, for messages."""
    layout: Layout = field(repr=False)
    rows: list[str] = field(repr=False)
    numbers_of_lines: NDArray[np.integer] = field(repr=False)
    """Of each row, as an editor counts them (n,)."""
    encoding: str = "utf-8"
    passed: int = 0
    """Damaged rows that were passed over: they hold no value."""
    _read: dict[int, Array] = field(default_factory=dict, repr=False)

    @property
    def told(self) -> str:
        """What messages begin with."""
        return f"{self.key} = {self.label!r}"

    @property
    def choices_key(self) -> str:
        """Of what the user says about the table."""
        return choices_key(self.key)

    @property
    def columns(self) -> tuple[Column, ...]:
        """In the file's order; an empty last one, which a trailing separator leaves, is none."""
        columns = self.layout.columns
        last = columns[-1]
        return columns[:-1] if last.kind == "e" and last.name == f"column {len(columns)}" else columns

    def line(self, row: int) -> str:
        """Where a row (from 0) stands."""
        return f"line {self.numbers_of_lines[row]}"

    def numbers(self, column: Column, gaps: bool = False) -> Array:
        """The numbers of a column (n,); with ``gaps``, empty cells are NaN.

        Raises ValueError, naming line and cell, where a cell is no number.
        """
        values = self._bulk.get(column.place)
        if values is None:
            values = self._read.get(column.place)
        if values is None:
            values = self._read[column.place] = self._strict(column)
        if not gaps and np.isnan(values).any():
            line = self.line(int(np.argmax(np.isnan(values))))
            raise ValueError(f"{self.told}: the cell of column {column.name!r} in {line} is empty; it must be a number")
        return values

    def values(self) -> Array:
        """The numbers of all columns (row, column); raises ValueError where a cell is none."""
        return np.column_stack([self.numbers(column) for column in self.columns])

    def cells(self, column: Column) -> list[str]:
        """The cells of a column as text, empty ones as ''."""
        dialect, place = self.layout.dialect, column.place
        return ["" if dialect.empty(cell := dialect.cells(row)[place]) else cell for row in self.rows]

    @cached_property
    def _bulk(self) -> dict[int, Array]:
        """All columns of numbers at once, where every cell of theirs is a plain one."""
        dialect = self.layout.dialect
        places = [column.place for column in self.layout.columns if column.kind == "n"]
        if dialect.thousands or dialect.missing or not places:
            return {}
        comma = dialect.decimal == ","
        if comma and any("." in row for row in self.rows):
            return {}
        parted = None if dialect.delimiter == " " else dialect.delimiter
        for filled in (False, True) if parted else (False,):
            lines = (self._filled(row) for row in self.rows) if filled else iter(self.rows)
            plain = (row.replace(",", ".") for row in lines) if comma else lines
            with suppress(ValueError):
                found = np.loadtxt(plain, delimiter=parted, usecols=places, quotechar='"', comments=None, ndmin=2)
                if len(found) == len(self.rows):  # blank lines are left out without a word
                    return dict(zip(places, found.T, strict=True))
        return {}

    def _filled(self, row: str) -> str:
        """A row with NaN in empty cells."""
        mark = self.layout.dialect.delimiter
        if not row.strip():
            return mark.join(["nan"] * len(self.layout.columns))
        if mark + mark not in row and row[:1] != mark and row[-1:] != mark:
            return row
        return mark.join(cell or "nan" for cell in row.split(mark))

    def _strict(self, column: Column) -> Array:
        """A column cell by cell."""
        dialect, place = self.layout.dialect, column.place
        values = np.empty(len(self.rows))
        for n, row in enumerate(self.rows):
            value = dialect.number(cell := dialect.cells(row)[place])
            if value is None:
                raise ValueError(f"{self.told}: {self.line(n)} holds {cell[:40]!r} {self._no_number(column, cell)}")
            values[n] = value
        return values

    def _no_number(self, column: Column, cell: str) -> str:
        key, kind = self.choices_key, self.layout.dialect.kind(cell)
        where = f"in column {column.name!r}, which is not a number"
        if cell.startswith(column.name):
            return f"as a header does: the file holds several tables; state {key}.first_row and {key}.last_row"
        if kind == "o":
            return f"{where} with {self.layout.dialect}; state {key}.decimal and {key}.thousands, or correct it"
        return f'{where}; if it stands for no value, state {key}.missing = ["{cell[:40]}"]'

    def understood(self, clock: str = "", passed: str = "") -> str:
        """What was understood, in one line."""
        here, dialect = self.layout, self.layout.dialect
        parts = [str(dialect)] if len(here.columns) > 1 or dialect.decimal == "," else []
        parts += [] if self.encoding == "utf-8" else [self.encoding]
        parts.append("no header" if here.header is None else f"header in line {here.header + 1}")
        parts += [] if here.unit_line is None else [f"units in line {here.unit_line + 1}"]
        parts += [f"units in line {here.facts.unit_line}"] if here.facts.unit_line else []
        begin, end = self.numbers_of_lines[0], self.numbers_of_lines[-1]
        parts.append(f"{len(self.rows)} rows from line {begin} to {end}")
        ends = [", ".join(parts), clock, passed and f"passed over: {passed}"]
        return f"table {self.label}: " + "; ".join(part for part in ends if part)


def choices_key(key: str) -> str:
    """The key of a table's choices, beside that of its file."""
    return key.rpartition(".")[0] + ".table"


def read_table(path: Path, key: str = "ground.file", choices: TableChoices | None = None, skip: bool = False) -> Table:
    """A table of text, whatever parts its cells and marks its decimals, with or without header, preamble and footer.

    Args:
        path: of the file.
        key: of the file's name in the scenario, for messages; what the user says of the table stands beside it.
        choices: what the user says.
        skip: whether rows that break off or have too many cells are passed over.

    Raises:
        ValueError: where the file cannot be read as a table, or in several ways; it names the choice that tells.
    """
    choices = choices or UNSAID
    text = lines_of(path, key, choices.encoding)
    told = f"{key} = {path.name!r}"
    found = layout(text.lines, choices, told, choices_key(key))
    rows, numbers = _rows(text.lines, found)
    rows, passed = _even(
        rows, numbers, found, told, choices_key(key), text.ended or found.last + 1 < len(text.lines), skip
    )
    return Table(path.name, key, found, rows, numbers, text.encoding, passed)


def _rows(lines: list[str], found: Layout) -> tuple[list[str], NDArray[np.integer]]:
    """Rows without blank lines and comments, and their lines' numbers."""
    rows = lines[found.first : found.last + 1]
    numbers = np.arange(found.first + 1, found.last + 2)
    alone = len(found.columns) == 1  # a blank line is an empty cell there
    keep = [(alone or (not row.isspace() and row != "")) and not row.lstrip().startswith(found.marks) for row in rows]
    if all(keep):
        return rows, numbers
    return [row for row, kept in zip(rows, keep, strict=True) if kept], numbers[np.array(keep)]


def _even(
    rows: list[str], numbers: NDArray[np.integer], found: Layout, told: str, key: str, ended: bool, skip: bool
) -> tuple[list[str], int]:
    """Rows that all have as many cells as there are columns, and how many did not and are empty now."""
    width, dialect = len(found.columns), found.dialect
    count_of = _count(dialect)
    wrong = [n for n, row in enumerate(rows) if count_of(row) != width]
    wrong = [n for n in wrong if not _trimmed(rows, n, dialect, width)]
    if not ended and (not wrong or wrong[-1] != len(rows) - 1) and _breaks_off(rows, dialect):
        wrong.append(len(rows) - 1)
    if not wrong:
        return rows, 0
    if not skip:
        line, count = f"line {numbers[wrong[0]]}", len(dialect.cells(rows[wrong[0]]))
        if count == width:
            what = f"{line} ends without a line break, and its last cell is shorter than in other rows"
        else:
            what = f"{line} has {count} cells where the table has {width} columns ({dialect})"
        way = f"correct it, or state {key}.first_row or {key}.last_row"
        if key == choices_key("ground.file"):
            way += ', or set ground.damaged = "skip" to pass over it'
        raise ValueError(f"{told}: {what}; the file may be truncated or damaged: {way}")
    blank = "nan " * width if dialect.delimiter == " " else dialect.delimiter * (width - 1)
    for n in wrong:
        rows[n] = blank
    return rows, len(wrong)


def _count(dialect: Dialect) -> Callable[[str], int]:
    """Number of cells of a row."""
    mark = dialect.delimiter
    if mark == " ":
        return lambda row: len(dialect.cells(row))
    return lambda row: len(dialect.cells(row)) if '"' in row else row.count(mark) + 1


def _trimmed(rows: list[str], n: int, dialect: Dialect, width: int) -> bool:
    """Whether a row has the right number of cells but for empty ones at its end, which are then put right in place."""
    cells = dialect.cells(rows[n])
    if dialect.delimiter == " " or len(cells) <= width or any(cells[width:]):
        return False
    rows[n] = dialect.delimiter.join(f'"{cell}"' if dialect.delimiter in cell else cell for cell in cells[:width])
    return True


def _breaks_off(rows: list[str], dialect: Dialect) -> bool:
    """Whether the last cell of the last row, after which no line ends, is shorter than nearly all of its column."""
    if len(rows) < 3:
        return False
    sizes = [len(cells[-1]) for cells in map(dialect.cells, rows[-1001:]) if cells]
    return bool(sizes[-1] < np.quantile(sizes[:-1], SHORT))
