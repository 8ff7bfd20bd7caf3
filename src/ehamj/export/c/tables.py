"""What the templates of a law's C are filled with: the tables of the stepping loop, taken apart."""

from collections.abc import Iterator, Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from ehamj.arrays import Array
from ehamj.control import Controller, LinearController
from ehamj.control.compiled.learning import LEARNER, Paced
from ehamj.control.compiled.lines import FOLLOWED, LEAST, PLACES, Followed
from ehamj.control.compiled.opening import FIELDS, HELD, SIZE
from ehamj.control.compiled.spools import FIELDS as SPOOL_FIELDS
from ehamj.control.compiled.spools import SPOOL, Paces
from ehamj.control.compiled.spools import Followed as FollowedSpool
from ehamj.control.compiled.stage import KNOWN, Moves, Remembered
from ehamj.control.learners import STATED, Learner, Learnt
from ehamj.control.loop import DigitalLoop
from ehamj.control.spools import KnownSpool
from ehamj.control.stage import AT_START
from ehamj.control.units import plain_unit, signal_units
from ehamj.control.valves import Known
from ehamj.export.c.text import enumerators, fields_of, filled, number, table, used_in
from ehamj.isolator.flow_curve import POINTS

DENSE: Final = 0.5
"""Share of numbers that are not zero from which a matrix is kept full: columns of single numbers take room too."""


class Table(NamedTuple):
    """A constant table of C."""

    kind: str
    name: str
    size: int
    text: str


class Named(NamedTuple):
    """A reading or a valve."""

    enumerator: str
    said: str


def readings_of(controller: LinearController, loop: DigitalLoop) -> list[Named]:
    """The readings, in their order."""
    names, zeroed = controller.reads, loop.sensing.zeroed
    units = map(plain_unit, signal_units(names))
    return [
        Named(one, f"{name} [{unit}]{', from rest' if rest else ''}")
        for one, name, unit, rest in zip(enumerators(names), names, units, zeroed, strict=True)
    ]


def valves_of(controller: LinearController) -> list[Named]:
    """The valves, in their order."""
    names = controller.converter.outputs
    return [Named(one, f"{name} [V]") for one, name in zip(enumerators(names), names, strict=True)]


def laws_of(parts: Sequence[Controller], loop: DigitalLoop) -> tuple[list[dict[str, Any]], list[Table]]:
    """The laws as entries of their table, and the tables that these name."""
    entries: list[dict[str, Any]] = []
    tables: list[Table] = []
    for k, (part, row) in enumerate(zip(parts, loop.laws.table, strict=False)):
        at, count = int(row["inputs_at"]), int(row["inputs"])
        entry: dict[str, Any] = {name: int(row[name]) for name in ("states", "inputs", "lines")}
        entry |= {"first": int(row["states_at"]), "line": int(row["line_at"]), "reading": f"READING_{k}", "L": "NULL"}
        read = loop.laws.inputs_of[at : at + count]
        tables.append(_whole("uint16_t", f"READING_{k}", read))
        matrices = {name: getattr(part, name) for name in "ABCD"}
        if part.anti_windup is not None:
            matrices["L"] = part.anti_windup
        for name, matrix in matrices.items():
            tables += _matrix(f"{name}_{k}", matrix)
            entry[name] = f"&{name}_{k}[0]"
        entries.append(entry)
    return entries, tables


def _matrix(name: str, matrix: Array) -> Iterator[Table]:
    """A matrix, and the tables that it is made of."""
    steps = name.startswith("A")
    rows, columns = matrix.shape
    there = matrix != 0.0
    if steps:
        there |= np.eye(rows) != 0.0
    dense = bool(there.sum() >= DENSE * matrix.size)
    at = np.argwhere(there | dense)
    entries = [_diagonal(matrix[i, i]) if steps and i == j else f"R({number(matrix[i, j])})" for i, j in at]
    yield Table("real_t", f"{name}_NUMBER", max(len(entries), 1), filled(entries or ["R(0.0)"]))
    if dense:
        own = f"    {{{rows}U, {columns}U, {name}_NUMBER, NULL, NULL}}"
    else:
        yield _whole("uint16_t", f"{name}_COLUMN", at[:, 1])
        yield _whole("uint32_t", f"{name}_BEGIN", np.concatenate([[0], np.cumsum(there.sum(axis=1))]))
        own = f"    {{{rows}U, {columns}U, {name}_NUMBER, {name}_COLUMN, {name}_BEGIN}}"
    yield Table("matrix_t", name, 1, own)


def _diagonal(entry: float) -> str:
    """An entry of A's diagonal, of which single precision keeps what it is more than one."""
    return f"DIAGONAL({number(entry)}, {number(entry - 1.0)})"


def _whole(kind: str, name: str, values: Any) -> Table:
    return Table(kind, name, max(len(values), 1), table(values if len(values) else [0], whole=True))


def lines_of(loop: DigitalLoop) -> tuple[dict[str, Any], int]:
    """Lines that are followed: where their states and pairs lie, and what is known of them; and all their pairs."""
    laws = loop.laws
    places, first = [], 0
    for at, pairs, _ in laws.lines.reshape(-1, PLACES).tolist():
        places.append((at, pairs, first))
        first += pairs
    return {"lines": places, "line_numbers": laws.followed.reshape(-1, FOLLOWED), "least_share": LEAST}, first


def stage_of(loop: DigitalLoop) -> dict[str, Any]:
    """What the stage knows of each valve, and what it learns; nothing where there is none."""
    laws = loop.laws
    if not laws.valves.size:
        return {"staged": False, "learns": False, "pressures": ()}
    rows = laws.valves.reshape(-1, KNOWN)
    found: dict[str, Any] = {
        "staged": True,
        "learns": bool(laws.learners.size),
        "known": rows[:, :FIELDS],
        "curves": rows[:, FIELDS:SIZE],
        "moves": rows[:, SIZE:],
        "points": POINTS,
        "held_share": HELD,
        "level": AT_START**2,
        "pressures": laws.pressures[:-1].reshape(-1, 2).tolist() if laws.pressures.size else (),
        "supply": int(laws.pressures[-1]) if laws.pressures.size else -1,
    }
    if laws.learners.size:
        learners = laws.learners.reshape(-1, LEARNER)
        count = len(Learner._fields)
        found |= {"learner": learners[:, :count], "paced": learners[:, count:], "strokes": laws.strokes.tolist()}
        found["stated"] = STATED
    return found


def spools_of(loop: DigitalLoop, laws: int) -> dict[str, Any]:
    """What is known of the spools that are fed back; nothing where there are none."""
    if not loop.laws.spools.size:
        return {"fed": False}
    rows = loop.laws.spools.reshape(-1, SPOOL)
    own = {"spool": rows[:, :SPOOL_FIELDS], "paces": rows[:, SPOOL_FIELDS:], "positions": loop.laws.positions.tolist()}
    return {"fed": True, "fed_row": laws, **own}


KINDS: Final = {
    **{kind.__name__: kind for kind in (Known, Moves, Remembered, Learner, Paced, Learnt, KnownSpool, Paces)},
    "Followed": FollowedSpool,
    "Line": Followed,
}
"""Named tuples that are structures of the C."""
NUMBERS: Final = {
    "Known": "known", "Learner": "learner", "Paced": "paced", "KnownSpool": "spool",
}  # fmt: skip
"""Tables of those of which the C does not ask for all fields, by what holds their rows."""


def shortened(filled: dict[str, Any], sources: str) -> dict[str, Any]:
    """What templates are filled with, with the structures' fields, but for those that no C asks for."""
    types = {name: fields_of(kind) for name, kind in KINDS.items()}
    rows = {}
    for name, place in NUMBERS.items():
        kept = used_in(sources, types[name])
        types[name] = [types[name][k] for k in kept]
        if place in filled:
            rows[place] = filled[place][:, kept]
    return filled | rows | {"types": types}
