"""The clock of a table's rows: a column of times, stamps in one column or two, or a rate that is stated."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ehamj.records.choices import Choices
from ehamj.records.clock import clock
from ehamj.records.table_choices import UNSAID
from ehamj.records.tables.header import is_time
from ehamj.records.tables.layout import Column
from ehamj.records.tables.preamble import Stated
from ehamj.records.tables.stamps import is_date, parts_of, stamps
from ehamj.records.tables.table import Table
from ehamj.records.units import is_silent, kind_of, time_unit
from ehamj.signals import Array

AGREE = 0.01
"""How far a stated rate may be from that of the times, relative: clocks are off by less, units by more."""

GUESSES = ("s", "ms", "us", "ns", "min")
"""Units of times that a stated rate decides among."""


@dataclass(frozen=True)
class RowClock:
    """Rate [Hz], the rows that have a time (m,), their places on the uniform grid (m,), and what was understood."""

    rate: float
    rows: NDArray[np.integer]
    index: Array
    columns: tuple[Column, ...]
    """That hold times, and are no components."""
    text: str
    notes: tuple[str, ...] = ()


class _Times(NamedTuple):
    """Times of all rows [s] (n,), NaN where there is none, to what they are rounded [s], and how they were read."""

    time: Array
    resolution: float
    columns: tuple[Column, ...]
    text: str


def row_clock(table: Table, choices: Choices) -> RowClock:
    """The clock of a record's table.

    Raises ValueError where there is none, where there are several, and where times are not believed (see `clock`).
    """
    users, key = choices.table or UNSAID, table.choices_key
    columns = _time_columns(table, users.time)
    every: NDArray[np.integer] = np.arange(len(table.rows))
    if users.rate is not None:
        text = f"{users.rate:g} Hz, as {key}.rate states"
        return RowClock(users.rate, every, every.astype(float), columns, text, _against(table, columns, choices))
    stated = _stated_rate(table, key)
    if not columns:
        if stated is None:
            raise ValueError(table.layout.facts.fault or _no_clock(table))
        text = f"{stated.rate:.10g} Hz from line {stated.line}" + (f" ({stated.guess})" if stated.guess else "")
        return RowClock(stated.rate, every, every.astype(float), (), text)
    groups = _groups(table, columns)
    if users.time_unit is not None and groups and all(group[-1].kind == "t" for group in groups):
        _check_unit_of_stamps(table, groups[0][-1], users.time_unit)
    times = _agreed(table, [_times(table, group, choices, stated) for group in groups], key)
    rows = np.flatnonzero(~np.isnan(times.time))
    rate, index, notes = clock(
        times.time[rows],
        table.label,
        choices.gaps,
        times.resolution,
        None if stated is None else stated.rate,
        lambda k: table.line(int(rows[k])),
        f"state {key}.rate to leave the times out"
        if users.time_unit
        else f"correct {key}.time_unit, or state {key}.rate",
    )
    if stated is not None and abs(stated.rate / rate - 1.0) > AGREE:
        differ = f"line {stated.line} of {table.label} states {stated.rate:g} Hz, but its times say {rate:.6g} Hz"
        if users.time is None:
            raise ValueError(
                f"{table.told}: {differ}; state {key}.rate to follow the line, or {key}.time = "
                f"{_pick(table, times.columns[0])} to follow the times"
            )
        notes.append(f"record {table.label}: {differ}, which hold")
    return RowClock(rate, rows, index, columns, f"time from {times.text}", tuple(notes))


def _time_columns(table: Table, wanted: str | None) -> tuple[Column, ...]:
    """Columns that hold times: the one the user names, or those that say so by name, unit or stamps."""
    if wanted is not None:
        found = [c for c in table.columns if wanted in (c.name, str(c.place + 1))]
        if not found:
            names = ", ".join(repr(column.name) for column in table.columns)
            raise ValueError(f"{table.choices_key}.time = {wanted!r} is no column of {table.label}; it has {names}")
        numbered = [column for column in found if wanted == str(column.place + 1)]
        if len(found) > 1 and len(numbered) != 1:
            ways = " or ".join(_pick(table, column) for column in found)
            raise ValueError(
                f"{table.choices_key}.time = {wanted!r} names several columns of {table.label}; state {ways}"
            )
        return ((numbered or found)[0],)
    usable = [column for column in table.columns if column.kind in "not"]
    silent = [column for column in usable if column.unit is None or is_silent(column.unit)]
    by_unit = [column for column in usable if column.unit is not None and kind_of(column.unit) == "time"]
    named = [c for c in usable if c.kind == "t" or (is_time(c.name) and (c in silent or c in by_unit))]
    return tuple(named or by_unit)


def _no_clock(table: Table) -> str:
    """What to say of a table that has no clock."""
    key, names = table.choices_key, ", ".join(repr(column.name) for column in table.columns)
    named = next((column for column in table.columns if is_time(column.name) and column.unit is not None), None)
    if named is not None:
        return (
            f"{table.told}: column {named.name!r} is in {named.unit!r}, which is no unit of time; state {key}.time_unit"
            f" and {key}.time, or {key}.rate"
        )
    headless = "" if table.layout.header is not None else ", and no header was found"
    return (
        f"{table.told} has no column of times (by name or unit) and no line that states the sampling rate; its columns "
        f"are {names}{headless}; state {key}.time (and {key}.time_unit), or {key}.rate"
    )


def _groups(table: Table, columns: tuple[Column, ...]) -> list[tuple[Column, ...]]:
    """Columns by the clock they make: a date and a time of day are one."""
    of_stamps = [column for column in columns if column.kind == "t"]
    dates = [column for column in of_stamps if is_date(next(filter(None, table.cells(column)[:100]), ""))]
    days = [column for column in of_stamps if column not in dates]
    if len(dates) == 1 and len(days) == 1:
        return [(dates[0], days[0]), *((column,) for column in columns if column.kind != "t")]
    return [(column,) for column in columns if column not in dates]


def _times(table: Table, group: tuple[Column, ...], choices: Choices, stated: Stated | None) -> _Times:
    """Times of one column, or of a date and a time of day."""
    name, users, key = " and ".join(repr(c.name) for c in group), choices.table or UNSAID, table.choices_key
    if group[-1].kind == "t":
        cells = [" ".join(parts).strip() for parts in zip(*(table.cells(column) for column in group), strict=True)]
        try:
            parts = parts_of(users.time_unit) or parts_of(group[-1].unit)
            return _Times(*stamps(cells, users.date_order, parts), group, f"{name} (dates or times of day)")
        except ValueError as error:
            raise ValueError(
                f"{table.told}: column {name} {error} (keys {key}.date_order, {key}.time_unit, {key}.time)"
            ) from error
    column = group[0]
    numbers = table.numbers(column, gaps=True)
    unit, text = users.time_unit or column.unit, ""
    if unit is None or is_silent(unit):
        unit = _guessed(numbers, stated)
        text = f", taken as {unit}, by the rate in line {stated.line}" if unit and stated else ""
    if unit is None:
        raise ValueError(
            f"{table.told}: the column of times {name} states no unit; write it as '{column.name} [s]', or state "
            f"{key}.time_unit"
        )
    try:
        size = time_unit(unit)
    except ValueError as error:
        raise ValueError(f"{table.told}: the unit of column {name}: {error}; state {key}.time_unit") from None
    dialect = table.layout.dialect
    plain = [dialect.ungrouped(cell) or cell for cell in _some(table.cells(column))]
    resolution = printed_resolution(plain, dialect.decimal)
    return _Times(size * numbers, size * resolution, group, f"{name} [{unit}]{text}")


def _check_unit_of_stamps(table: Table, column: Column, unit: str) -> None:
    """Raise ValueError where the user states a unit of times that are written as dates or times of day."""
    if parts_of(unit) is None:
        key = table.choices_key
        raise ValueError(
            f"{table.told}: {key}.time_unit = {unit!r}, but column {column.name!r} holds dates or times of day, which "
            f"have no unit; leave it out, or state 'mm:ss' or 'hh:mm' of times in two parts, or {key}.time"
        )


def _guessed(numbers: Array, stated: Stated | None) -> str | None:
    """The unit of times with which they have the stated rate, None if there is no such rate."""
    steps = np.diff(numbers[np.isfinite(numbers)])
    if stated is None or not steps.size:
        return None
    step = float(np.mean(steps[steps <= 1.5 * np.median(steps)]))
    return next((unit for unit in GUESSES if abs(step * time_unit(unit) * stated.rate - 1.0) < AGREE), None)


def _agreed(table: Table, found: Sequence[_Times], key: str) -> _Times:
    """The clock whose times are the finest, of clocks that tell the same; raises ValueError where they do not."""
    if not found:
        raise ValueError(f"{table.told} has dates, but no times; state {key}.time, or {key}.rate")
    best = min(found, key=lambda times: times.resolution)
    for other in found:
        both = np.isfinite(other.time) & np.isfinite(best.time)
        known = other.time[both] - best.time[both]
        if known.size and np.ptp(known) > 1.01 * (best.resolution + other.resolution) + 1e-9:
            raise ValueError(
                f"{table.told} has two clocks, {best.text} and {other.text}, which differ by up to "
                f"{np.ptp(known):.3g} s; state {key}.time = {_pick(table, best.columns[0])} or "
                f"{_pick(table, other.columns[0])}"
            )
    return best


def _pick(table: Table, column: Column) -> str:
    """What picks a column: its name, or its number where several have the name."""
    alone = sum(other.name == column.name for other in table.columns) == 1
    return repr(column.name if alone else str(column.place + 1))


def _stated_rate(table: Table, key: str) -> Stated | None:
    """The sampling rate that lines above the rows state; raises ValueError where they state several."""
    rates = table.layout.facts.rates
    if not rates:
        return None
    other = next((one for one in rates if abs(one.rate / rates[0].rate - 1.0) > 1e-3), None)
    if other is not None:
        raise ValueError(
            f"{table.told}: line {rates[0].line} states {rates[0].rate:g} Hz, and line {other.line} {other.rate:g} Hz; "
            f"state {key}.rate"
        )
    return rates[0]


def _against(table: Table, columns: tuple[Column, ...], choices: Choices) -> tuple[str, ...]:
    """The remark where times contradict the rate that the user states, as far as they can be read."""
    rate = choices.table.rate if choices.table else None
    said = [(one.rate, f"line {one.line}") for one in table.layout.facts.rates]
    for column in columns:
        if column.kind == "n" and column.unit is not None and kind_of(column.unit) == "time":
            steps = np.diff(table.numbers(column, gaps=True)) * time_unit(column.unit)
            steps = steps[np.isfinite(steps)]  # what starts again and again, as milliseconds of a second, tells no rate
            mean = float(steps.mean()) if steps.size and steps.min() >= 0.0 else 0.0
            said += [(1.0 / mean, f"column {column.name!r}")] if mean > 0 else []
    return tuple(
        f"record {table.label}: {where} says {other:.6g} Hz, but {table.choices_key}.rate = {rate:g} holds"
        for other, where in said
        if rate is not None and abs(other / rate - 1.0) > 1e-3
    )


def _some(cells: list[str]) -> list[str]:
    """Cells from all over a column."""
    return cells[:500] + cells[500 :: max(1, len(cells) // 500)]


def printed_resolution(cells: Sequence[str], decimal: str) -> float:
    """To what numbers are rounded by the digits that are printed: of fixed decimals, or of a number of digits."""
    places, digits, largest = -30, 0, 0.0
    for cell in cells:
        match = re.fullmatch(r"[-+]?(\d*)\.?(\d*)(?:[eEdD]([-+]?\d+))?", cell.replace(decimal, "."))
        if match is None or not (match[1] or match[2]):
            continue
        exponent = int(match[3] or 0)
        places = max(places, len(match[2]) - exponent)
        digits = max(digits, len((match[1] + match[2]).lstrip("0")))
        largest = max(largest, abs(float(f"{match[1] or 0}.{match[2] or 0}e{exponent}")))
    if places == -30:
        return 0.0
    by_digits = 10.0 ** (np.floor(np.log10(largest)) + 1 - digits) if largest > 0 and digits else 0.0
    return float(max(10.0**-places, by_digits))
