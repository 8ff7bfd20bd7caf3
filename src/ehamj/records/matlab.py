"""Records in MATLAB files: vectors, matrices and structs as loggers and their programs export them."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from ehamj.records.channel import Record
from ehamj.records.choices import SILENT, Choices
from ehamj.records.clock import clock, on_grid
from ehamj.records.components import Component, Loaded, answers_of, record_of
from ehamj.records.matlab_clock import Clock, clock_of, is_clock
from ehamj.records.matlab_files import opened
from ehamj.records.matlab_names import Scope, labels_of, unit_of
from ehamj.records.matlab_values import Numbers, Opaque, Value
from ehamj.signals import Array

WIDEST = 256
"""Columns that a matrix of channels may have."""


@dataclass(frozen=True)
class Found:
    """An array that could hold components: where it is, and what tells its times."""

    name: str
    key: str
    scopes: tuple[Scope, ...]
    numbers: Numbers
    clock: Clock | None

    @property
    def length(self) -> int:
        """Samples along the dimension that the times have, or along the longer one."""
        wanted = self.clock.length if self.clock is not None else None
        return wanted if wanted is not None and wanted in self.numbers.shape else max(self.numbers.shape)

    @property
    def columns(self) -> int:
        """Number of channels."""
        return int(np.prod(self.numbers.shape)) // self.length

    def column(self, number: int) -> np.ndarray:
        """The values of a channel, from 0, as stored, shape (length,)."""
        values = self.numbers.read().reshape(self.numbers.shape)
        return values[:, number] if values.shape[0] == self.length else values[number]


def read_matlab(path: Path, choices: Choices = SILENT) -> Record:
    """The numeric vectors of a MATLAB file, also inside structs.

    Times are a vector (``time``, ``t``), a rate (``fs``, ``SampleRate``, ``rate_hz``, …) or a step (``dt``, ``Ts``) in
    the same struct or around it. A component is called by its path, ``data.z`` or ``s.signals(2).values``, the columns
    of a matrix ``name(1)``, ``name(2)``, …; it answers to the last part and to a label beside it too. Without
    ``choices.axes`` arrays of other lengths than the longest are passed over, and named. Raises ValueError where clock
    or components are missing.
    """
    where = f"ground.file = {path.name!r}"
    with opened(path) as tree:
        found = list(_arrays(tree))
        timed = [one for one in found if one.clock is not None]
        if not timed:
            raise ValueError(f"{where} {_missing(tree, found)}")
        taken = (choices.axes is None and [one for one in timed if _fits(one, timed)]) or timed
        components = [component for one in taken for component in _components(one, path.name, choices)]
        over = [f"{one.name} ({' × '.join(map(str, one.numbers.shape))})" for one in found if one not in taken]
        notes = [f"arrays that do not fit are passed over: {', '.join(over)}"] if over else []
        return record_of(path.name, components, choices, "store a text units beside it", notes)


def _missing(tree: dict[str, Value], found: list[Found]) -> str:
    """What a file lacks to be a record."""
    opaque = [f"{name} ({value.kind})" for name, value in tree.items() if isinstance(value, Opaque)]
    told = f"; only MATLAB can read {', '.join(opaque)}: save numbers or a struct instead" if opaque else ""
    if not found:
        return f"holds no vector of numbers that could be a component{told}"
    return (
        f"has no times for {', '.join(one.name for one in found[:5])}: give a vector time or t [s], a number fs or "
        f"SampleRate [Hz], or a step dt [s]{told}"
    )


def _arrays(tree: dict[str, Value]) -> Iterator[Found]:
    """Arrays that could hold components, in the file's order."""

    def walk(scopes: tuple[Scope, ...], prefix: str) -> Iterator[Found]:
        for key, value in scopes[0].items():
            yield from at(value, key, prefix + _shown(key), scopes)

    def at(value: Value, key: str, name: str, scopes: tuple[Scope, ...]) -> Iterator[Found]:
        if isinstance(value, dict):
            yield from walk((value, *scopes), f"{name}.")
        elif isinstance(value, list):
            for n, one in enumerate(value, 1):
                yield from at(one, key, f"{name}({n})" if isinstance(one, dict) else f"{name}{{{n}}}", scopes)
        elif isinstance(value, Numbers) and not is_clock(key, scopes[0]):
            shape = tuple(n for n in value.shape if n != 1)
            if 1 <= len(shape) <= 2 and min(shape) <= (WIDEST if len(shape) == 2 else np.inf):
                flat = Numbers((*shape, 1)[:2], value.read, value.complex)
                yield Found(name, key, scopes, flat, clock_of(key, shape, scopes))

    yield from walk((tree,), "")


def _shown(name: str) -> str:
    """A name on one line, whatever a damaged file has made of it."""
    return "".join(letter if letter.isprintable() else "?" for letter in name)


def _fits(one: Found, others: list[Found]) -> bool:
    """Whether an array is as long as its times, or as the longest of those that share its rate."""
    assert one.clock is not None
    if one.clock.length is not None:
        return one.length == one.clock.length
    return one.length == max(o.length for o in others if o.clock is not None and o.clock.scope is one.clock.scope)


def _components(one: Found, label: str, choices: Choices) -> Iterator[Component]:
    for number in range(one.columns):
        alone = one.columns == 1
        name = one.name if alone else f"{one.name}({number + 1})"
        texts = labels_of(one.name, one.key, one.scopes, number, one.columns)
        own = _shown(one.key)
        answers = [own if alone else f"{own}({number + 1})", *map(_shown, texts)]
        answers += [axis for text in (one.name, *texts) for axis in answers_of(text)] if alone or texts else []
        load = partial(_load, one, name, number, label, choices)
        yield Component(name, load, tuple(dict.fromkeys(answers)))


def _load(one: Found, name: str, number: int, label: str, choices: Choices) -> Loaded:
    where = f"ground.file = {label!r}: {name}"
    assert one.clock is not None
    if one.numbers.complex:
        raise ValueError(f"{where} is complex; a time history must be real")
    if one.clock.length is not None and one.length != one.clock.length:
        raise ValueError(f"{where} has {one.length} values and {one.clock.name} has {one.clock.length}")
    samples: Array = np.asarray(one.column(number), float)
    stated = unit_of(name, one.key, one.scopes, number, one.columns, choices)
    rates = one.clock.rates(where)
    if one.clock.times is None:
        return Loaded(samples, rates[0], stated, one.clock.begin(where))
    time, resolution = one.clock.seconds(where)
    rate, index, notes = clock(time, label, choices.gaps, resolution, rates[0] if rates else None)
    if any(abs(stored / rate - 1.0) > 1e-3 for stored in rates):
        raise ValueError(f"{where}: {one.clock.name} has {rate:g} Hz, and {rates[0]:g} Hz is stated too; delete one")
    return Loaded(on_grid(index, samples), rate, stated, float(time[0]), notes=tuple(notes))
