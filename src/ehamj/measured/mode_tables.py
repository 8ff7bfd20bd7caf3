"""Modes in tables of text: a row per mode, a column per sensor, as modal software exports them."""

from pathlib import Path
from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.measured.modes import ModeTable
from ehamj.records.tables.layout import Column
from ehamj.records.tables.table import Table, read_table

PASSED: Final = ("mode", "name", "number", "no", "no.", "#", "type")
"""Columns that say nothing of a mode."""
VALUES: Final = {
    "frequency": "frequency", "f": "frequency", "freq": "frequency",
    "damping": "damping", "damping ratio": "damping", "zeta": "damping", "ζ": "damping",
    "frequency deviation": "frequency deviation", "damping deviation": "damping deviation",
    "shape deviation": "shape deviation",
}  # fmt: skip
"""Columns that are no sensor's, by their names."""
UNITS: Final = {
    "frequency": {"Hz": 1.0, "hz": 1.0, "HZ": 1.0, "kHz": 1e3},
    "damping": {"%": 0.01, "-": 1.0, "1": 1.0, "per cent": 0.01},
    "shape": {"%": 0.01, "-": 1.0, "1": 1.0},
}
"""Factors to SI of the units that they may have."""
PARTS: Final = {"re": "re", "real": "re", "im": "im", "imag": "im", "magnitude": "magnitude", "phase": "phase"}
"""Last words of the names of two columns that are one sensor's."""
ANGLES: Final = {"deg": np.pi / 180.0, "°": np.pi / 180.0, "rad": 1.0}


def read_mode_table(path: Path) -> ModeTable:
    """Modes of a table of text.

    A row is a mode. Columns are ``frequency`` [Hz] and, each if it is known, ``damping`` [-] or [%], ``frequency
    deviation``, ``damping deviation`` and ``shape deviation`` (over the shape's largest entry); all others are sensors
    by name: one column of numbers with signs, or two, ``NAME re`` and ``NAME im``, or ``NAME magnitude`` and ``NAME
    phase`` [deg or rad].

    Raises:
        ValueError: where it cannot be read so; the message names the column and what is allowed.
    """
    table = read_table(path, "file")
    values, sensors = _columns(table)
    if "frequency" not in values:
        raise ValueError(f"{table.told}: no column is called 'frequency [Hz]'; its columns are {_names(table)}")
    hertz = _value(table, values, "frequency")
    shapes = [_shape(table, name, parts) for name, parts in sensors.items()]
    real = all(set(parts) == {""} for parts in sensors.values())
    return ModeTable(
        tuple(sensors),
        hertz,
        _value(table, values, "damping", hertz.size),
        _value(table, values, "frequency deviation", hertz.size),
        _value(table, values, "damping deviation", hertz.size),
        np.array(shapes, complex).reshape(-1, hertz.size).T,
        _value(table, values, "shape deviation", hertz.size),
        real,
        f"the table {path.name}",
    )


def _names(table: Table) -> str:
    return ", ".join(repr(column.name) for column in table.columns)


def _columns(table: Table) -> tuple[dict[str, Column], dict[str, dict[str, Column]]]:
    """Columns of values, and those of each sensor by their part: "" where it has one column."""
    values: dict[str, Column] = {}
    sensors: dict[str, dict[str, Column]] = {}
    for column in table.columns:
        name = column.name.strip()
        if name.lower() in PASSED:
            continue
        if name.lower() in VALUES:
            values[VALUES[name.lower()]] = column
            continue
        if column.kind in ("w", "t"):
            raise ValueError(f"{table.told}: column {name!r} holds no numbers; remove it, or call it 'name'")
        stem, _, last = name.rpartition(" ")
        part = PARTS.get(last.lower(), "") if stem else ""
        sensors.setdefault(stem if part else name, {})[part] = column
    return values, sensors


def _value(table: Table, values: dict[str, Column], name: str, size: int = 0) -> Array:
    """A column in SI; NaN where there is none, or its cell is empty."""
    if name not in values:
        return np.full(size, np.nan)
    column, units = values[name], UNITS[name.split(" ")[0]]
    if column.unit is not None and column.unit not in units:
        allowed = ", ".join(units)
        raise ValueError(f"{table.told}: column {column.name!r} is in {column.unit!r}; it must be in one of {allowed}")
    return table.numbers(column, gaps=name != "frequency") * (1.0 if column.unit is None else units[column.unit])


def _shape(table: Table, name: str, parts: dict[str, Column]) -> ComplexArray:
    """The shapes' entries at one sensor, (k,)."""
    if set(parts) == {""}:
        return table.numbers(parts[""]).astype(complex)
    if set(parts) == {"re", "im"}:
        return np.asarray(table.numbers(parts["re"]) + 1j * table.numbers(parts["im"]))
    if set(parts) == {"magnitude", "phase"}:
        unit = parts["phase"].unit
        if unit not in ANGLES:
            raise ValueError(
                f"{table.told}: column {parts['phase'].name!r} states {'no unit' if unit is None else repr(unit)}; "
                "it must be in [deg] or [rad]"
            )
        angle = ANGLES[unit] * table.numbers(parts["phase"])
        return np.asarray(table.numbers(parts["magnitude"]) * np.exp(1j * angle))
    given = ", ".join(repr(column.name) for column in parts.values())
    raise ValueError(
        f"{table.told}: sensor {name!r} has {given}; it must have one column, or 're' and 'im', or "
        "'magnitude' and 'phase'"
    )
