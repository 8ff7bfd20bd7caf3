"""Components of a record that are no ground: picked by name, of any kind of unit that a rig's loggers know, in SI."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import isclose, isfinite
from pathlib import Path
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.records.channel import Record
from ehamj.records.choices import Picks, Reading
from ehamj.records.components import Component, Loaded, called
from ehamj.records.kept import Kept
from ehamj.records.readers import READERS, check_used, reader_of
from ehamj.records.units import SAID, Kind, is_silent, unit
from ehamj.series import Sampled

SI: Final = "SI"
"""As a unit: the samples of a file that states none are SI."""

FEWEST: Final = 16
"""Samples of a component at least."""

OPEN: Final[tuple[Kind, ...]] = ("counts", "voltage")
"""Kinds that a logger writes of any quantity: the user says what one count or 1 V is."""


@dataclass(frozen=True)
class Pick:
    """A component that is wanted, and what it is to be."""

    key: str
    """Key of the table that wants it, for messages: ``control.signals.0``."""
    kind: Kind
    what: str
    """What it is wanted for, for messages: ``chamber_pressure front-left 1``."""
    component: str | None = None
    """Its name, one that it answers to, or its number in the file from 1; None: the only one that there is."""
    unit: str | None = None
    """What its samples are in, or what 1 V or one count of it stands for; `SI`; None: as the file says."""
    full_scale: float | None = None
    """Of a WAV file: what its largest sample stands for [unit]."""


@dataclass(frozen=True)
class Series:
    """A component in SI, finite samples (n,) at ``time`` + k/``rate`` on the file's own clock."""

    component: str
    kind: Kind
    rate: float
    """[Hz]"""
    time: float
    """[s]"""
    samples: Array = field(repr=False)
    notes: tuple[str, ...] = ()

    @property
    def end(self) -> float:
        """Time at which the last sample's interval ends [s]."""
        return self.time + self.samples.size / self.rate

    @cached_property
    def smooth(self) -> Sampled:
        """A quintic spline through the samples, on the file's clock; made once for all that replay it."""
        return Sampled(self.rate, self.samples, self.time)


_READ: Final[Kept[tuple[Series, ...]]] = Kept(lambda found: sum(one.samples.nbytes for one in found))


def read_picked(path: Path, picks: Sequence[Pick], reading: Reading, key: str) -> tuple[Series, ...]:
    """What is wanted of a file, in the order of ``picks``; read once, and kept while the file stays what it is.

    Args:
        path: of the file, in any format that `ehamj.records.readers` knows.
        picks: what is wanted.
        reading: how the file is read.
        key: of the table that names the file, for messages: ``force.0``.

    Raises:
        InputError: naming key, component and way out, where the file cannot be read, does not hold what is wanted or
            holds it in another unit.
    """
    asked = (tuple(picks), reading.model_dump_json(), key)
    return _READ.get(path, asked, lambda: _read(path, picks, reading, key))


def _read(path: Path, picks: Sequence[Pick], reading: Reading, key: str) -> tuple[Series, ...]:
    found: list[Series] = []

    def takes(label: str, components: Sequence[Component], remedy: str, notes: Sequence[str]) -> Record:
        chosen = [_chosen(label, components, pick) for pick in picks]
        loaded = {k: _loaded(components[k], pick) for k, pick in zip(chosen, picks, strict=True)}
        for k, pick in zip(chosen, picks, strict=True):
            name = components[k].name or f"component {k + 1}"
            found.append(_series(label, name, loaded[k], pick, keyed(remedy, key), notes))
        return Record(label, ())

    shared = {name: getattr(reading, name) for name in Reading.model_fields}
    scaled = all(pick.full_scale is not None for pick in picks)
    if not scaled and any(pick.full_scale is not None for pick in picks):
        bare = next(pick.key for pick in picks if pick.full_scale is None)
        raise InputError(f"{bare}.full_scale is missing: components of one WAV file state all theirs")
    choices = Picks.stated(
        **shared,
        takes=takes,
        axes={},
        remove_response=False,
        full_scale=1.0 if scaled else None,
        unit=SI if all(pick.unit is not None for pick in picks) else None,
    )
    try:
        reader = reader_of(path)
        if scaled and reader is not READERS["wav"]:
            raise ValueError("ground.full_scale is for *.wav files only; leave it out")
        check_used(path, reader, choices)
        reader.read(path, choices)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(keyed(str(error), key)) from error
    return tuple(found)


def keyed(message: str, key: str) -> str:
    """A message of a reader, in which keys are those of a ground, with the keys of who reads."""
    return re.sub(r"\bground\.(?=[a-z_])", f"{key}.", message.replace("ground.axes", f"{key}.component"))


def _loaded(component: Component, pick: Pick) -> Loaded:
    try:
        return component.load()
    except ValueError as error:
        raise InputError(keyed(str(error), pick.key)) from error


def _chosen(label: str, components: Sequence[Component], pick: Pick) -> int:
    """Number from 0 of the component that is wanted, by its name, else by what it answers to, else by its number."""
    held = ", ".join(called(components, k) for k in range(len(components)))
    if pick.component is None:
        if len(components) == 1:
            return 0
        raise InputError(f"{pick.key}.component is missing: {label!r} holds {held}; name one of them")
    ways: tuple[Iterable[bool], ...] = (
        (one.name == pick.component for one in components),
        (pick.component in one.answers for one in components),
        (str(one.number or k + 1) == pick.component for k, one in enumerate(components)),
    )
    for way in ways:
        of_it = [k for k, is_it in enumerate(way) if is_it]
        if len(of_it) > 1:
            several = ", ".join(str(components[k].number or k + 1) for k in of_it)
            raise InputError(
                f"{pick.key}.component = {pick.component!r}: {label!r} holds {len(of_it)} that are called so, numbers "
                f"{several}; name one by its number"
            )
        if of_it:
            return of_it[0]
    raise InputError(f"{pick.key}.component = {pick.component!r}: {label!r} does not hold it; it holds {held}")


def _series(label: str, name: str, one: Loaded, pick: Pick, remedy: str, notes: Sequence[str]) -> Series:
    """A component in SI; raises InputError, naming the key, where it is not what it must be."""
    if not 0 < one.rate < np.inf or not isfinite(one.time):
        clock = f"begins at {one.time:g} s and has {one.rate:g} Hz"
        raise InputError(f"{pick.key}: {name} of {label!r} {clock}, which no record has; leave it out")
    size = _size(name, one, pick, remedy) * one.calibration * (pick.full_scale or 1.0)
    with np.errstate(invalid="ignore", over="ignore"):  # what is not finite is refused by its place
        samples = np.asarray(one.samples * size, float)
    if samples.ndim != 1 or samples.size < FEWEST:
        raise InputError(f"{pick.key}: {name} of {label!r} holds {samples.size} samples; at least {FEWEST} are needed")
    wrong = np.flatnonzero(~np.isfinite(samples))
    if wrong.size:
        raise InputError(
            f"{pick.key}: {name} of {label!r} holds {wrong.size} values that are not finite, the first is sample "
            f"{wrong[0] + 1} (at {one.time + wrong[0] / one.rate:g} s) = {samples[wrong[0]]}; every sample must be a "
            "finite number"
        )
    told = [*notes, *one.notes]
    if one.calibration != 1.0:
        told.append(f"{name}: the file's calibration factor {one.calibration:g} is applied")
    samples.flags.writeable = False  # it is shared
    return Series(name, pick.kind, one.rate, one.time + 0.0, samples, tuple(told))  # no −0


def _size(name: str, one: Loaded, pick: Pick, remedy: str) -> float:
    """SI value of a component's unit, as the file says or the user."""
    users = users_size(pick)
    stated = _stated(name, one, pick, users is not None)
    if stated is None:
        if users is None:
            raise InputError(
                f"{pick.key}.unit is missing: the file does not say what {name!r} is in; state {SAID[pick.kind]}, or "
                f"unit = {SI!r} if its samples are SI already; or {remedy}"
            )
        return users
    kind, size = stated
    if kind in OPEN and kind != pick.kind:
        if users is None:
            what = "counts of a converter" if kind == "counts" else "volts"
            raise InputError(
                f"{pick.key}.unit is missing: {name!r} is in {what}, and {pick.what} is {_an(pick.kind)}; say what one "
                f"of them stands for with unit ({SAID[pick.kind]}) and scale"
            )
        return users * (size if kind == "voltage" else 1.0)
    if kind != pick.kind:
        raise InputError(
            f"{pick.key}: {name!r} is in {_written(one)}, which is of {kind}, and {pick.what} is {_an(pick.kind)} "
            f"({SAID[pick.kind]}); name another component or channel"
        )
    if users is not None and not isclose(users, size):
        raise InputError(
            f"{pick.key}.unit = {pick.unit!r}, but the file states {_written(one)} of {name!r} itself; leave unit out"
        )
    return size


def users_size(pick: Pick) -> float | None:
    """SI value of the unit that the user states, None where he states none; raises InputError at others."""
    if pick.unit is None:
        return None
    if pick.unit == SI:
        return 1.0
    known = f"known for {pick.what} are {SAID[pick.kind]}, or {SI!r}"
    try:
        found = unit(pick.unit)
    except ValueError:
        raise InputError(f"{pick.key}.unit = {pick.unit!r} is not a unit that is known; {known}") from None
    if found.kind != pick.kind:
        raise InputError(
            f"{pick.key}.unit = {pick.unit!r} is of {found.kind}, but {pick.what} is {_an(pick.kind)}; {known}"
        )
    return found.size


def _stated(name: str, one: Loaded, pick: Pick, said: bool) -> tuple[Kind, float] | None:
    """Kind and SI value of the unit that the file states, None where it states none that is known and the user does."""
    if one.unit is None or (isinstance(one.unit, str) and is_silent(one.unit)):
        return None
    if isinstance(one.unit, tuple):
        return one.unit
    try:
        found = unit(one.unit)
    except ValueError:
        if said:
            return None
        raise InputError(
            f"{pick.key}.unit is missing: the file states {one.unit!r} of {name!r}, which is not a unit that is known; "
            f"state {SAID[pick.kind]}"
        ) from None
    return found.kind, found.size


def _written(one: Loaded) -> str:
    return repr(one.unit) if isinstance(one.unit, str) else f"the SI unit of {one.unit[0] if one.unit else ''}"


def _an(kind: Kind) -> str:
    return f"an {kind}" if kind[0] in "aeiou" else f"a {kind}"
