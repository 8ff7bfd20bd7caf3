"""Where a table's parts stand: preamble, header, units, rows, footer."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice

from ehamj.records.table_choices import TableChoices
from ehamj.records.tables.cells import Dialect
from ehamj.records.tables.dialects import GROUPED, Shape, chosen, sample_of, shapes
from ehamj.records.tables.header import (
    PREFIX,
    Named,
    bare_unit,
    factor_of,
    header_cells,
    is_time,
    is_unit_row,
    named,
)
from ehamj.records.tables.preamble import Facts, facts, states
from ehamj.records.units import kind_of
from ehamj.records.units import unit as unit_of

COMMENTS = ("#", "%", "!", "//", "*")
"""Marks that lines to pass over begin with, unless the user says another."""

REMARKS = ("comment", "comments", "remark", "remarks")
"""Names of a last column that rows without a comment leave out, as LabVIEW writes it."""

COMMAS = "; where commas are decimal marks too, nobody can tell: export it with semicolons"

ABOVE = 12
"""Lines above the rows among which the header is sought, blank ones apart."""


@dataclass(frozen=True)
class Column:
    """A column: its name, its unit as written (None where none is stated), its place from 0, and its usual kind."""

    name: str
    unit: str | None
    place: int
    kind: str
    overruled: str | None = None
    """Unit of the file's that the user overrules."""


@dataclass(frozen=True)
class Layout:
    """What was understood of a table's lines, which are counted from 0 here."""

    dialect: Dialect
    columns: tuple[Column, ...]
    first: int
    last: int
    header: int | None
    unit_line: int | None
    facts: Facts
    marks: tuple[str, ...]


@dataclass(frozen=True)
class _Found:
    """Lines (from 0) of the rows and of what names them, and the cells there."""

    first: int
    last: int
    header: int | None = None
    names: tuple[str, ...] = ()
    unit_line: int | None = None
    units: tuple[str | None, ...] = ()
    other: tuple[int, int] | None = None
    """A line right above the rows with another number of cells than they have, and that number."""


def layout(lines: Sequence[str], choices: TableChoices, told: str, key: str) -> Layout:
    """The parts of a table.

    Args:
        lines: of the file.
        choices: what the user says.
        told: what messages begin with.
        key: of the user's choices, for messages.

    Raises:
        ValueError: where there are no rows, or several ways to read them.
    """
    marks = COMMENTS if choices.comment is None else (choices.comment,)
    for name in ("header", "unit_line", "first_row", "last_row"):
        number = getattr(choices, name)
        if number is not None and number > len(lines):
            raise ValueError(f"{key}.{name} = {number}, but {told} has {len(lines)} lines")
    section = lines[(choices.first_row or 1) - 1 : choices.last_row]
    sample = sample_of(section, marks)
    candidates = shapes(sample, choices)
    if not candidates:
        raise ValueError(
            f"{told}: no row of numbers was found{_seen(sample)}; {key}.delimiter and {key}.decimal may help"
        )
    found = [_find(lines, shape, choices, marks) for shape in candidates]
    shape = chosen(
        candidates,
        [_fits(one, shape, choices) for one, shape in zip(found, candidates, strict=True)],
        sample,
        told,
        key,
        choices.decimal is not None,
    )
    place = found[candidates.index(shape)]
    early = [n for n in range(place.first) if shape.is_row(lines[n]) and not lines[n].lstrip().startswith(marks)]
    if len(early) > 2 and choices.first_row is None and choices.header is None:
        raise ValueError(
            f"{told}: line {early[0] + 1} is a row of numbers, but line {place.first} is none and rows go on after it; "
            f"correct it, or state {key}.first_row"
        )
    if place.other is not None and choices.columns is None:
        raise ValueError(f"{told}: {_unnamed(lines, shape, place.first, *place.other, key)}")
    return _complete(lines, shape, place, choices, marks, told, key)


def _unnamed(lines: Sequence[str], shape: Shape, first: int, line: int, count: int, key: str) -> str:
    """Why a line right above the rows names no columns, and the way out."""
    ways = f"state {key}.columns, or {key}.header"
    if count == len(shape.kinds):
        ways = f"{ways} (the line of the names)"
        return (
            f"line {line + 1}, {lines[line].strip()[:40]!r}, names no columns of the rows from line {first + 1}; {ways}"
        )
    told = f"line {line + 1} has {count} cells where the rows from line {first + 1} have {len(shape.kinds)}"
    return f"{told} ({shape.dialect}); {ways}, {key}.delimiter" + COMMAS * (shape.dialect.delimiter == ",")


def _fits(found: _Found, shape: Shape, choices: TableChoices) -> bool:
    """Whether as many columns are named as a shape has."""
    return bool(found.names) if choices.columns is None else len(choices.columns) == len(shape.kinds)


def _seen(sample: Sequence[str]) -> str:
    return f" (line {sample[len(sample) // 2].strip()[:60]!r} is none)" if sample else "; it is empty"


def _find(lines: Sequence[str], shape: Shape, choices: TableChoices, marks: tuple[str, ...]) -> _Found:
    """Where rows begin and end under a shape, and what stands above them."""
    first = choices.first_row - 1 if choices.first_row else _first(lines, shape, choices, marks)
    last = choices.last_row - 1 if choices.last_row else _last(lines, shape, first, marks)
    return _headed(lines, shape, _Found(first, last), choices, marks)


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


def _headed(lines: Sequence[str], shape: Shape, found: _Found, choices: TableChoices, marks: tuple[str, ...]) -> _Found:
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


def _complete(
    lines: Sequence[str],
    shape: Shape,
    found: _Found,
    choices: TableChoices,
    marks: tuple[str, ...],
    told: str,
    key: str,
) -> Layout:
    """The layout, with each column's name and unit from wherever they are stated."""
    width = len(shape.kinds)
    apart = {found.header, found.unit_line}
    above = [(n + 1, lines[n]) for n in range(found.first) if n not in apart and lines[n].strip()]
    said = facts(above, shape.dialect, width, shape.kinds.endswith("e"), told, key, _sure(lines, shape, found, choices))
    names = list(found.names) or [""] * width
    plain = [named(name) if not found.units else _named_apart(name) for name in names]
    if choices.columns is not None:
        if len(choices.columns) != width:
            raise ValueError(
                f"{key}.columns has {len(choices.columns)} names; {told} has {width} columns ({shape.dialect})"
            )
        plain = [Named(name, one.unit) for name, one in zip(choices.columns, plain, strict=True)]
    columns = []
    for k, (name, unit) in enumerate(plain):
        ways = (unit, found.units[k] if found.units else None, said.units[k] if said.units else None)
        unit = _agreed(ways, _stated(choices, name, k), f"{told}: column {name or k + 1!r}", key)
        if unit is None and said.unit is not None and not is_time(name):
            unit = said.unit
        stated = _stated(choices, name, k)
        overruled = unit if stated is not None and unit is not None and stated != unit else None
        columns.append(Column(name or f"column {k + 1}", stated or unit, k, shape.kinds[k], overruled))
    for name in choices.units or {}:
        if not any(name in (one.name, str(one.place + 1)) for one in columns):
            raise ValueError(f"{key}.units names {name!r}; {told} has {', '.join(one.name for one in columns)}")
    header = found.header if found.names else None
    return Layout(shape.dialect, tuple(columns), found.first, found.last, header, found.unit_line, said, marks)


def _sure(lines: Sequence[str], shape: Shape, found: _Found, choices: TableChoices) -> bool:
    """Whether the user or a row says which mark is the decimal one."""
    dialect = shape.dialect
    rows = (line for line in lines[found.first : found.last + 1][:2000] if dialect.decimal in line)
    cells = (cell for line in rows for cell in dialect.cells(line) if dialect.decimal in cell)
    proven = (dialect.kind(cell) == "n" and not GROUPED.fullmatch(cell.replace(",", ".")) for cell in cells)
    return choices.decimal is not None or choices.thousands is not None or any(proven)


def _agreed(ways: Sequence[str | None], users: str | None, told: str, key: str) -> str | None:
    """The unit that a header, a row of units and a comment state; raises ValueError where two of them differ."""
    stated = [way for way in ways if way]
    known = {kind_of(way) and unit_of(way): way for way in stated if kind_of(way)}
    if len(known) > 1 and users is None:
        raise ValueError(f"{told} is in {' and in '.join(map(repr, known.values()))}; state {key}.units")
    return stated[0] if stated else None


def _named_apart(cell: str) -> Named:
    """The name of a header's cell with units in a line of their own: brackets still hold a unit if it is one."""
    found = named(cell)
    return (
        found
        if found.unit is None or kind_of(found.unit) or factor_of(found.unit)
        else Named(cell.strip().strip('"'), None)
    )


def _stated(choices: TableChoices, name: str, place: int) -> str | None:
    """The unit that the user says of a column."""
    units = choices.units or {}
    return units.get(name, units.get(str(place + 1)))
