"""Records in tables of text."""

import re
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from ehamj.records.channel import Record
from ehamj.records.choices import SILENT, Choices
from ehamj.records.clock import filled, on_grid
from ehamj.records.components import STANDARD_AXES, Component, Loaded, answers_of, record_of
from ehamj.records.tables.header import factor_of
from ehamj.records.tables.layout import Column
from ehamj.records.tables.table import Table, read_table
from ehamj.records.tables.times import RowClock, row_clock
from ehamj.records.units import is_motion, is_silent

_COUNTERS = "index sample samples no no. nr nr. # scan row point number record count counter id"
COUNTERS = frozenset(_COUNTERS.split())
"""Names of columns that count rows."""

DOWNWARD = re.compile(
    r"^[-−]\s*[a-z]|(?:^|[\s_(-])(?:down|neg(?:ative)?|minus|invert(?:ed|iert)|abwärts)(?:$|[\s_)-])", re.I
)
"""In names of columns that may count downward, or against their axis."""

SENTINELS = (999.0, 9999.0, 99999.0, 999999.0, 999.25, 32767.0, 32768.0)
"""Magnitudes of numbers that often stand for no value."""


def read_table_record(path: Path, choices: Choices = SILENT) -> Record:
    """A record in a table of text: a row per sample, a column per component, and a clock.

    Columns of words, counters and times are passed over and named; others answer to their names, and to ``column 3``.
    Raises ValueError where the table cannot be read, or in several ways; the message names the choice that tells.
    """
    skip = choices.damaged == "skip"
    table = read_table(path, "ground.file", choices.table, skip)
    clock = row_clock(table, choices)
    passed = _passed(table, clock) if choices.axes is None else _wordy(table)
    components = [
        Component(
            _called(table, column),
            partial(_load, table, clock, column, choices),
            _answers(column),
            number=column.place + 1,
        )
        for column in table.columns
        if column not in clock.columns and (column not in passed or choices.axes is not None)
    ]
    if not components:
        raise ValueError(f"{table.told} has no column of numbers besides its times")
    told = ", ".join(f"{column.name!r} ({why})" for column, why in passed.items())
    notes = [table.understood(clock.text, told), *clock.notes]
    if table.passed:
        notes.append(f'record {table.label}: {table.passed} damaged rows were passed over (damaged = "skip")')
    notes += [f"{said}, which is not applied; ground.scale can" for said in table.layout.facts.factors]
    key = table.choices_key
    return record_of(path.name, components, choices, f"write the unit as 'x [m/s]', or state {key}.units", notes)


def _wordy(table: Table) -> dict[Column, str]:
    """Columns that hold no numbers, and what they hold."""
    holds = {"w": "words", "e": "empty", "t": "times"}
    return {column: holds[column.kind] for column in table.columns if column.kind in holds}


def _passed(table: Table, clock: RowClock) -> dict[Column, str]:
    """Columns that are no components unless the user picks them, and why."""
    passed = {column: why for column, why in _wordy(table).items() if column not in clock.columns}
    for column in table.columns:
        if column in passed or column in clock.columns:
            continue
        axis = {column.name, *answers_of(column.name)} & set(STANDARD_AXES)
        stated = None if column.unit is None or is_silent(column.unit) else column.unit
        if stated is not None and not axis and not is_motion(stated):
            passed[column] = stated
        elif column.name.lower() in COUNTERS and stated is None and _counts(table, column):
            passed[column] = "counts rows"
    return passed


def _counts(table: Table, column: Column) -> bool:
    """Whether a column rises by one from row to row."""
    try:
        return bool((np.diff(table.numbers(column, gaps=True)) == 1.0).all())
    except ValueError:
        return False


def _called(table: Table, column: Column) -> str:
    """The column's name, with its place where several have it."""
    alone = sum(other.name == column.name for other in table.columns) == 1
    return column.name if alone else f"{column.name} (column {column.place + 1})"


def _answers(column: Column) -> tuple[str, ...]:
    return tuple(dict.fromkeys((f"column {column.place + 1}", column.name, *answers_of(column.name))))


def _load(table: Table, clock: RowClock, column: Column, choices: Choices) -> Loaded:
    """The samples of a column on the uniform grid, from its first to its last that is not empty."""
    if choices.unit is None:
        _check_factor(table, column)
    values = table.numbers(column, gaps=True)[clock.rows]
    known = np.flatnonzero(~np.isnan(values))
    if not known.size:
        raise ValueError(f"{table.told}: column {column.name!r} holds no numbers")
    notes = (
        []
        if column.overruled is None
        else [
            f"column {column.name!r} of {table.label} states {column.overruled}, but {table.choices_key}.units says "
            f"{column.unit}, which holds"
        ]
    )
    if DOWNWARD.search(column.name):
        notes.append(
            f"column {column.name!r} of {table.label} may count the other way round by its name, and is taken as it "
            "stands; ground.scale with -1 for its axis turns it"
        )
    empty = int(known[-1] - known[0] + 1 - known.size)
    if empty:
        jumps = np.flatnonzero(np.diff(known) > 1)
        at = int(known[jumps[0]]) + 1
        first = f"empty cells of column {column.name!r}, the first in {table.line(int(clock.rows[at]))}"
        first += f" at {clock.index[at] / clock.rate:g} s"
        held = filled(table.label, jumps.size, empty / clock.rate, known.size / clock.rate, choices.gaps, first)
        notes.append(f"{held} ({first})")
    if known.size < values.size - empty:
        ends = [(int(known[0]), "first"), (values.size - 1 - int(known[-1]), "last")]
        edges = " and ".join(f"its {which} {count} rows" for count, which in ends if count)
        notes.append(f"column {column.name!r} of {table.label} is empty in {edges}: the record is cut to what all hold")
    begin = float(np.ceil(clock.index[known[0]] - 1e-9))
    samples = on_grid(clock.index[known] - begin, values[known])
    notes += _sentinels(table, column, values[known])
    return Loaded(samples, clock.rate, column.unit, begin / clock.rate, notes=tuple(notes))


def _check_factor(table: Table, column: Column) -> None:
    """Raise ValueError where the unit has a number before it: a factor, a range, or something else."""
    found = factor_of(column.unit or "")
    if found is not None:
        key = table.choices_key
        raise ValueError(
            f"{table.told}: the header of column {column.name!r} states {column.unit!r}: the number {found[0]!r} "
            f"before the unit may be a factor, and is not applied; state {key}.units = "
            f"{{ {column.name!r} = {found[1]!r} }}, and the factor as {key.rpartition('.')[0]}.scale"
        )


def _sentinels(table: Table, column: Column, values: Sequence[float]) -> list[str]:
    """A doubt about numbers far from all others that often stand for no value."""
    size = np.abs(values)
    special = np.isin(size, SENTINELS)
    if not special.any() or special.all() or size[special].min() < 10.0 * size[~special].max():
        return []
    worst = values[int(np.argmax(special))]
    return [
        f"column {column.name!r} of {table.label} holds {worst:g} {int(special.sum())} times, far from all else: if it "
        f'stands for no value, state {table.choices_key}.missing = ["{worst:g}"]'
    ]
