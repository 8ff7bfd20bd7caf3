"""Where a table's rows begin and end, and the lines above them that name columns and units."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice

from ehamj.records.table_choices import TableChoices
from ehamj.records.tables.cells import Dialect
from ehamj.records.tables.dialects import Shape
from ehamj.records.tables.header import PREFIX, bare_unit, header_cells, is_time, is_unit_row, named
from ehamj.records.tables.preamble import states
from ehamj.records.units import kind_of

COMMENTS = ("#", "%", "!", "//", "*")
"""Marks that lines to pass over begin with, unless the user says another."""

REMARKS = ("comment", "comments", "remark", "remarks")
"""Names of a last column that rows without a comment leave out, as LabVIEW writes it."""

ABOVE = 12
"""Lines above the rows among which the header is sought, blank ones apart."""


@dataclass(frozen=True)
class Places:
    """Lines (from 0) of the rows and of what names them, and the cells there."""

    first: int
    last: int
    header: int | None = None
    names: tuple[str, ...] = ()
    unit_line: int | None = None
    units: tuple[str | None, ...] = ()
    other: tuple[int, int] | None = None
    """A line right above the rows with another number of cells than they have, and that number."""


def places(lines: Sequence[str], shape: Shape, choices: TableChoices, marks: tuple[str, ...]) -> Places:
    """Where rows begin and end under a shape, and what stands above them."""
    first = choices.first_row - 1 if choices.first_row else _first(lines, shape, choices, marks)
    last = choices.last_row - 1 if choices.last_row else _last(lines, shape, first, marks)
    return _headed(lines, shape, Places(first, last), choices, marks)


def _first(lines: Sequence[str], shape: Shape, choices: TableChoices, marks: tuple[str, ...]) -> int:
    """The first row: one that another follows, or rows go back to without a break."""
    begin = max(choices.header or 0, choices.unit_line or 0)
    kept = (n for n in range(begin, len(lines)) if lines[n].strip() and not lines[n].lstrip().startswith(marks))
    first, before = -1, False
    for n in kept:
        if shape.is_row(lines[n]):
            first = n if not before else first
            if before:
                break
            before = True
        else:
            before = False
    if first < 0:
        raise ValueError(f"there is no row of numbers after line {begin}")
    above = first - 1
    while above >= begin and (not lines[above].strip() or shape.begins_as_row(lines[above])):
        first = above if lines[above].strip() else first
        above -= 1
    return first


def _last(lines: Sequence[str], shape: Shape, first: int, marks: tuple[str, ...]) -> int:
    """The last row, with lines after it that begin as one does."""
    last = next((n for n in range(len(lines) - 1, first - 1, -1) if shape.is_row(lines[n])), first)
    while last + 1 < len(lines) and shape.begins_as_row(lines[last + 1]):
        last += 1
    return last


def _headed(lines: Sequence[str], shape: Shape, found: Places, choices: TableChoices, marks: tuple[str, ...]) -> Places:
    """With the lines that name the columns and their units: those the user says, or the nearest above the rows."""
    width, dialect = len(shape.kinds), shape.dialect
    if choices.header is not None:
        line = lines[choices.header - 1]
        cells = header_cells(PREFIX.sub("", line), dialect, width, loose=True)
        found = replace(found, header=choices.header - 1, names=tuple(cells or ()))
        if cells is None or _parts(cells, False):
            found = replace(found, names=())
            found = replace(found, other=(choices.header - 1, len(dialect.cells(line))))
    if choices.unit_line is not None:
        cells = header_cells(PREFIX.sub("", lines[choices.unit_line - 1]), dialect, width, loose=True)
        found = replace(found, unit_line=choices.unit_line - 1, units=tuple(map(bare_unit, cells or ())))
    left = choices.first_row is not None  # rows that the user leaves out stand between
    lying = (n for n in range(found.first - 1, -1, -1) if lines[n].strip() and not (left and shape.is_row(lines[n])))
    above = list(islice(lying, ABOVE))
    for n in above if choices.header is None else ():
        comment = lines[n].lstrip().startswith(marks if dialect.delimiter == ";" else (*marks, ";"))
        if states(lines[n]) and (comment or _holds_number(lines[n], dialect)):
            continue
        bare = PREFIX.sub("", lines[n]) if comment else lines[n]
        cells = header_cells(bare, dialect, width, loose=False) or _short(bare, shape)
        cells = cells or header_cells(bare, dialect, width, loose=comment)
        if all(dialect.kind(cell) == "e" for cell in cells or dialect.cells(bare)):
            continue  # a ruled line, or an empty one
        if cells is None or not _are_names(cells, shape) or (comment and _is_prose(cells)) or _parts(cells, comment):
            count = len(dialect.cells(bare))
            if not comment and n == above[0] and count > 1 and not _is_prose(dialect.cells(bare)) and not found.units:
                return replace(found, other=(n, count))
            if found.units or not comment:
                break
            continue
        if not found.units and choices.unit_line is None and is_unit_row(cells):
            found = replace(found, unit_line=n, units=tuple(map(bare_unit, cells)))
            continue
        return replace(found, header=n, names=tuple(cells))
    return found


def _parts(cells: Sequence[str], comment: bool) -> bool:
    """Whether what would head a single column names several."""
    if len(cells) != 1 or comment:
        return False
    parts = re.split(r"[,;\t|](?![^\[({]*[\])}])", cells[0][:1000])
    return len(parts) > 1 and not any(kind_of(part) for part in parts)


def _holds_number(line: str, dialect: Dialect) -> bool:
    return any(dialect.kind(cell) in "no" for cell in dialect.cells(line)) or ":" in line or "=" in line


def _short(line: str, shape: Shape) -> list[str] | None:
    """Cells of a header that leaves out the last, empty column of rows, or names one for comments that no row has."""
    width = len(shape.kinds)
    if shape.kinds.endswith("e") and width > 1:
        cells = header_cells(line, shape.dialect, width - 1, loose=False)
        return None if cells is None else [*cells, ""]
    cells = header_cells(line, shape.dialect, width + 1, loose=False)
    return None if cells is None or cells[-1].lower() not in REMARKS else cells[:-1]


def _are_names(cells: Sequence[str], shape: Shape) -> bool:
    """Whether cells are words, or numbers of channels after the name of a time."""
    kinds = [shape.dialect.kind(cell) for cell in cells]
    if "t" in kinds or "w" not in kinds:
        return False
    return not {"n", "o"} & set(kinds) or is_time(named(cells[0]).name)


def _is_prose(cells: Sequence[str]) -> bool:
    """Whether a line says something in the form ``name: value``, or is a sentence."""
    return any(mark in cells[0].partition("[")[0] for mark in ":=") or any(len(cell) > 80 for cell in cells)
