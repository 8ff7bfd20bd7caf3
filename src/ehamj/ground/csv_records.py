"""Records in CSV files whose header names the units."""

from pathlib import Path

import numpy as np

from ehamj.ground.channel import Channel, Record
from ehamj.ground.components import SILENT, Choices, agreed_unit, choose_axes, clock, on_grid, summary
from ehamj.ground.tables import parse_unit, read_table

TIME_UNITS = {"s": 1.0, "ms": 1e-3}


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
        if unit not in TIME_UNITS:
            raise ValueError(f"ground.file: CSV column {names[clocks[0]]!r} has the unit {unit!r}; known are s and ms")
        rate_hz, index, notes = clock(table[:, clocks[0]] * TIME_UNITS[unit], path.name, choices.gaps)
    assert rate_hz is not None
    chosen = choose_axes({name: (name,) for i, name in enumerate(names) if i not in clocks}, choices.axes)
    channels = []
    for name, axis in chosen.items():
        column = columns[names.index(name)]
        holds, size = agreed_unit(choices, parse_unit(column), f"column {name!r}", "write the unit as 'x [m/s]'")
        samples = on_grid(index, table[:, names.index(name)] * size)
        channels.append(Channel(axis, name, rate_hz, holds, samples))
    notes.insert(0, summary(path.name, channels))
    return Record(path.name, tuple(channels), tuple(notes))
