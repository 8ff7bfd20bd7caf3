"""CSV files whose header names the units: any table, and records."""

import re
from collections import Counter
from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ehamj.records.channel import Record
from ehamj.records.choices import SILENT, Choices
from ehamj.records.clock import clock, on_grid
from ehamj.records.components import Component, Loaded, answers_of, record_of
from ehamj.records.units import time_unit
from ehamj.signals import Array


class Column(NamedTuple):
    """A CSV column: its name and its unit as written, None where it has none."""

    name: str
    unit: str | None


def parse_header(line: str, delimiter: str = ",", key: str = "ground.file") -> list[Column]:
    """Columns of a header such as ``time [s], x [m/s], z [mm/s^2]``; raises ValueError at any other cell."""
    columns = []
    for cell in line.split(delimiter):
        match = re.fullmatch(r"\s*([^\[\]]*?)\s*(?:\[([^\[\]]*)\])?\s*", cell)
        if match is None or not match[1]:
            raise ValueError(f"{key}: CSV header cell {cell.strip()[:40]!r} is not of the form 'name [unit]'")
        columns.append(Column(match[1], None if match[2] is None else match[2].strip()))
    twice = [name for name, count in Counter(column.name for column in columns).items() if count > 1]
    if twice:
        raise ValueError(f"{key}: the CSV header names {twice[0]!r} more than once")
    return columns


def read_table(path: Path, key: str = "ground.file") -> tuple[list[Column], Array, float | None]:
    """Columns, numbers (row, column) and the rate [Hz] that a comment ``# rate_hz = 1000`` states, of a CSV file.

    One header line (it may be a comment) names columns and units; cells are parted by comma, semicolon or tab. Raises
    ValueError, naming ``key``, where the file breaks that.
    """
    try:
        raw = path.read_bytes()
    except OSError as error:
        raise ValueError(f"{key} = {path.name!r} cannot be read: {error.strerror} ({path})") from error
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")  # spreadsheets on Windows write µ and ² like this
    lines = text.splitlines()
    rate_hz, header, header_at = None, "", 0
    for number, line in enumerate(lines):
        stated = re.fullmatch(r"#\s*rate_hz\s*[=:]\s*(\S+)\s*", line)
        if stated:
            rate_hz = float(stated[1]) if _is_number(stated[1]) else 0.0
            if not 0.0 < rate_hz < np.inf:
                raise ValueError(f"{key}: rate_hz = {stated[1]} must be a positive number, in Hz")
        elif line.lstrip().startswith("#"):
            header, header_at = line.lstrip().lstrip("#"), number + 1
        elif line.strip():
            if not _is_number(re.split(r"[,;\t]", line)[0]):
                header, header_at = line, number + 1
            break
    if not header_at:
        raise ValueError(
            f"{key} = {path.name!r}: the first line must name columns and units, as in 'time [s], z [m/s]'"
        )
    delimiter = next((mark for mark in "\t;" if mark in header), ",")
    columns = parse_header(header, delimiter, key)
    rows = [(n, line) for n, line in enumerate(lines[header_at:], header_at + 1) if line.split("#")[0].strip()]
    table: Array = np.empty((0, 0))
    with suppress(ValueError):
        table = np.loadtxt([line for _, line in rows], delimiter=delimiter, ndmin=2) if rows else table
    if table.shape[1] != len(columns):
        raise ValueError(f"{key} = {path.name!r}: " + _csv_fault(rows, len(columns), delimiter))
    return columns, table, rate_hz


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _csv_fault(rows: Sequence[tuple[int, str]], width: int, delimiter: str) -> str:
    """What is wrong with the first bad row."""
    for number, line in rows:
        cells = line.split("#")[0].split(delimiter)
        if len(cells) != width:
            return f"line {number} has {len(cells)} cells where the header has {width}; the file may be truncated"
        for cell in cells:
            if not _is_number(cell):
                return f"line {number} holds {cell.strip()!r}, which is not a number"
    return "it holds no samples"


def read_csv(path: Path, choices: Choices = SILENT) -> Record:
    """A CSV record.

    One header line (it may be a comment) names columns and units; then one row per sample. Either a column ``time`` [s]
    or [ms], uniform within 1e-3 of a step, or a comment ``# rate_hz = 1000``. Columns are parted by comma, semicolon or
    tab. Raises ValueError where the file breaks that.
    """
    columns, table, rate_hz = read_table(path)
    names = [column.name for column in columns]
    clocks = [index for index, name in enumerate(names) if name.lower() in ("time", "t")]
    if bool(clocks) == (rate_hz is not None):
        both = "neither" if rate_hz is None else "both"
        raise ValueError(f"ground.file = {path.name!r}: give a column 'time [s]' or a line '# rate_hz = …', not {both}")
    notes: list[str] = []
    index = np.arange(float(len(table)))
    if clocks:
        unit = columns[clocks[0]].unit
        try:
            seconds = table[:, clocks[0]] * time_unit(unit or "")
        except ValueError as error:
            raise ValueError(f"ground.file: the unit of CSV column {names[clocks[0]]!r}: {error}") from None
        rate_hz, index, notes = clock(seconds, path.name, choices.gaps)
    assert rate_hz is not None
    step_rate = rate_hz

    def load(column: int) -> Loaded:
        return Loaded(on_grid(index, table[:, column]), step_rate, columns[column].unit)

    components = [
        Component(name, partial(load, k), answers_of(name)) for k, name in enumerate(names) if k not in clocks
    ]
    return record_of(path.name, components, choices, "write the unit as 'x [m/s]'", notes)
