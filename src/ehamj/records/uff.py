"""Records in universal files (UFF): time responses of dataset 58, through pyuff."""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ehamj.records.channel import Place, Record
from ehamj.records.choices import SILENT, Choices, GapChoice
from ehamj.records.clock import clock, on_grid
from ehamj.records.components import Component, Loaded, existing, reading, record_of
from ehamj.records.units import KNOWN, ORDERS, Quantity, is_silent, unit

DIRECTIONS: dict[int, Place] = {1: "x", 2: "y", 3: "z"}
DATA_TYPES: dict[int, Quantity] = {8: "displacement", 11: "velocity", 12: "acceleration"}
TIME_RESPONSE = 1
"""Function type of a time response."""


def read_uff(path: Path, choices: Choices = SILENT) -> Record:
    """The time responses of a universal file.

    A component is called by node and direction, ``12:+Z``, and answers to ``z`` as well; a negative direction turns its
    sign. Its unit is the label of the ordinate (m/s, g, …); without a label it is SI of the data type, if the file's
    dataset 164 does not say that its units are others. Raises ValueError where the file cannot be read, holds no time
    response or is truncated, and see `clock`.
    """
    sets, si = _sets(path)
    found = {f"{s['rsp_node']}:{_direction(s['rsp_dir'])}": s for s in sets}
    if len(found) < len(sets):
        raise ValueError(f"ground.file = {path.name!r} holds several time responses of one node and direction")
    components = [
        Component(name, partial(_loaded, path, name, content, si, choices.gaps), _axis(content["rsp_dir"]))
        for name, content in found.items()
    ]
    return record_of(path.name, components, choices, "label its ordinate with the unit")


def _axis(direction: int) -> tuple[str, ...]:
    return (DIRECTIONS[abs(direction)],) if abs(direction) in DIRECTIONS else ()


def _loaded(path: Path, name: str, content: dict[str, Any], si: bool, gaps: GapChoice) -> Loaded:
    samples, stated = np.asarray(content["data"]), int(content["num_pts"])
    if samples.size < stated:
        held = f"{name} holds {samples.size} of {stated} samples"
        raise ValueError(f"ground.file = {path.name!r}: {held}; the file may be truncated")
    if np.iscomplexobj(samples):
        raise ValueError(f"ground.file = {path.name!r}: {name} is complex; a time response must be real")
    time = np.asarray(content["x"], float)[:stated]
    rate, index, notes = clock(time, path.name, gaps)
    unit, remarks = _unit(content, name, si)
    sign = -1.0 if content["rsp_dir"] < 0 else 1.0
    return Loaded(on_grid(index, sign * samples[:stated]), rate, unit, float(time[0]), notes=(*notes, *remarks))


def _sets(path: Path) -> tuple[list[dict[str, Any]], bool]:
    """The file's time responses, and whether its units are SI as far as it says."""
    import pyuff

    existing(path)
    with reading(path, " as a universal file"):
        file = pyuff.UFF(str(path))
        kinds = file.get_set_types()
        read = {n: file.read_sets(n) for n, kind in enumerate(kinds) if int(kind) in (58, 164)}
    sets = [s for s in read.values() if s["type"] == 58 and s["func_type"] == TIME_RESPONSE]
    if not sets:
        raise ValueError(f"ground.file = {path.name!r} holds no time response (dataset 58, function type 1)")
    units = [s for s in read.values() if s["type"] == 164]
    return sets, all(float(s["length"]) == 1.0 for s in units)


def _direction(number: int) -> str:
    axis = DIRECTIONS.get(abs(number))
    return str(number) if axis is None else f"{'-' if number < 0 else '+'}{axis.upper()}"


def _unit(content: dict[str, Any], name: str, si: bool) -> tuple[str | tuple[Quantity, float] | None, list[str]]:
    """What a time response holds: the label of its unit, or SI; None where it does not say; and a remark."""
    label = str(content.get("ordinate_axis_units_lab") or "").strip()
    holds = DATA_TYPES.get(int(content["ordinate_spec_data_type"]))
    if not is_silent(label):
        try:
            kind = unit(label).kind
        except ValueError as error:
            raise ValueError(f"ground.file: the unit of UFF component {name!r}: {error}") from None
        if holds is not None and kind in ORDERS and kind != holds:
            raise ValueError(f"ground.file: UFF component {name} is {holds} by its data type, but in {label!r}")
        return label, []
    if holds is None:
        return None, []
    if not si:
        raise ValueError(
            f"ground.file: UFF component {name} has no unit label, and dataset 164 says that the file is not in SI; "
            f"label the ordinate with its unit: {KNOWN}"
        )
    return (holds, 1.0), [f"{name} has no unit label: taken as SI, as its data type ({holds}) has it"]
