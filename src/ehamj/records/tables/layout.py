"""What a table's lines are understood as: its dialect, its rows, and columns with names and units."""

from collections.abc import Sequence
from dataclasses import dataclass

from ehamj.records.table_choices import TableChoices
from ehamj.records.tables.cells import Dialect
from ehamj.records.tables.dialects import GROUPED, Shape, chosen, sample_of, shapes
from ehamj.records.tables.header import Named, factor_of, is_time, named
from ehamj.records.tables.places import COMMENTS, Places, places
from ehamj.records.tables.preamble import Facts, facts
from ehamj.records.units import kind_of
from ehamj.records.units import unit as unit_of

COMMAS = "; where commas are decimal marks too, nobody can tell: export it with semicolons"


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
    try:
        found = [places(lines, shape, choices, marks) for shape in candidates]
    except ValueError as error:
        raise ValueError(f"{told}: {error}; correct {key}.header or {key}.unit_line") from None
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


def _fits(found: Places, shape: Shape, choices: TableChoices) -> bool:
    """Whether as many columns are named as a shape has."""
    return bool(found.names) if choices.columns is None else len(choices.columns) == len(shape.kinds)


def _seen(sample: Sequence[str]) -> str:
    return f" (line {sample[len(sample) // 2].strip()[:60]!r} is none)" if sample else "; it is empty"


def _complete(
    lines: Sequence[str],
    shape: Shape,
    found: Places,
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
        stated = _stated(choices, name, k)
        unit = _agreed(ways, stated, f"{told}: column {name or k + 1!r}", key)
        if unit is None and said.unit is not None and not is_time(name):
            unit = said.unit
        overruled = unit if stated is not None and unit is not None and stated != unit else None
        columns.append(Column(name or f"column {k + 1}", stated or unit, k, shape.kinds[k], overruled))
    for name in choices.units or {}:
        if not any(name in (one.name, str(one.place + 1)) for one in columns):
            raise ValueError(f"{key}.units names {name!r}; {told} has {', '.join(one.name for one in columns)}")
    header = found.header if found.names else None
    return Layout(shape.dialect, tuple(columns), found.first, found.last, header, found.unit_line, said, marks)


def _sure(lines: Sequence[str], shape: Shape, found: Places, choices: TableChoices) -> bool:
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
