"""What every reader of records shares: axes, quantities and units, and remarks on what was found."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isclose, isfinite

import numpy as np

from ehamj.records.channel import Channel, Place, Record, Response
from ehamj.records.choices import AxisChoice, Choices, Picks
from ehamj.records.units import Quantity, is_motion, is_silent, kind_of, motion_unit, unit
from ehamj.signals import Array

STANDARD_AXES: dict[str, Place] = {"E": "x", "N": "y", "Z": "z", "x": "x", "y": "y", "z": "z"}


@dataclass(frozen=True)
class Loaded:
    """What a component holds: samples (n,) on a uniform grid, as the file has them."""

    samples: Array = field(repr=False)
    rate: float
    """[Hz]"""
    unit: str | tuple[Quantity, float] | None = None
    """As the file writes it, or quantity and SI value; None where it states none."""
    time: float = 0.0
    """Of the first sample, on the file's own clock [s]."""
    response: Response | None = None
    """Counts per SI unit at frequencies [Hz]; None where the samples are in their unit already."""
    notes: tuple[str, ...] = ()
    calibration: float = 1.0
    """Factor on the samples that the file states [-]."""


@dataclass(frozen=True)
class Component:
    """One component that a file holds, before anything of it is judged.

    ``load`` reads and judges it, and is called for components that are picked only. It answers to its ``name``, to
    ``answers`` (most special first) and to its number in the file, from 1. Components of several ``source`` (stations)
    make one record only where each has a mount of its own.
    """

    name: str
    load: Callable[[], Loaded] = field(repr=False)
    answers: tuple[str, ...] = ()
    source: str = ""
    number: int | None = None
    """In the file, from 1; None: its place among the components."""


def record_of(
    label: str, components: Sequence[Component], choices: Choices, remedy: str, notes: Sequence[str] = ()
) -> Record:
    """The record of a file: components picked, loaded, in SI and on one clock; or what `Picks` take of it.

    Args:
        label: the file's name.
        components: what the file holds.
        choices: what the user says.
        remedy: how the file itself could state the unit, for messages.
        notes: remarks on reading.

    Raises:
        ValueError: naming the key that resolves it, where components, units, or times cannot be agreed.
    """
    if isinstance(choices, Picks):
        found: Record = choices.takes(label, components, remedy, notes)
        return found
    chosen = choose_axes(components, choices.axes)
    sources = sorted({components[k].source for k in chosen})
    if len(sources) > 1 and not per_mount(chosen.values()):
        several = f"ground.file = {label!r} holds several stations: {', '.join(sources)}"
        raise ValueError(f"{several}; choose with ground.axes, or give each its mount")
    loaded = {k: components[k].load() for k in chosen}
    begin = max(one.time for one in loaded.values())
    channels, remarks = [], [*notes]
    for k, one in loaded.items():
        name = components[k].name or f"component {k + 1}"
        if not 0 < one.rate < inf or not isfinite(one.time):
            clock = f"begins at {one.time:g} s and has {one.rate:g} Hz"
            raise ValueError(
                f"ground.file = {label!r}: {name} {clock}, which no record has; leave it out of ground.axes"
            )
        holds, size = agreed_unit(choices, one.unit, name, remedy)
        foreign = isinstance(one.unit, str) and not is_silent(one.unit) and not is_motion(one.unit)
        if choices.unit is not None and foreign:
            what = "1 V" if _volts(one.unit) else f"its unit {one.unit!r}"
            remarks.append(f"{name}: {what} is taken as ground.unit = {choices.unit!r}, times ground.scale")
        if one.calibration != 1.0:
            remarks.append(f"{name}: the file's calibration factor {one.calibration:g} is applied")
        with np.errstate(invalid="ignore", over="ignore"):  # what is not finite is refused by its place
            samples = one.samples * (size * one.calibration)
        channels.append(Channel(chosen[k], name, one.rate, holds, samples, one.time - begin, one.response))
        remarks += one.notes
    record = recorded(label, channels, remarks, ", ".join(sources).strip("."))
    if record.duration <= 0:
        raise ValueError(f"ground.file = {label!r}: its channels have no time in common")
    return record


_BESIDE = (
    "acc accel acceleration accelerometer beschleunigung vel velocity geschwindigkeit schwinggeschwindigkeit speed "
    "disp displacement position weg ch chan channel kanal axis achse dir direction richtung sensor signal data geo "
    "geophone seismometer floor ground boden machine base foot motion vibration schwingung component comp point linear "
    "a v d g ac dc m mm um s ms"
)
BESIDE_AXES = frozenset(_BESIDE.split())
"""Words that may stand beside an axis in the name of a motion along it."""


def answers_of(name: str) -> tuple[str, ...]:
    """The axis in a name of several words, such as ``Acceleration z``, ``ACC_X`` or ``Z-axis``.

    Nothing of a name with words that may make it something else (``max_x``, ``X_Value``, ``z down``, ``-z``).
    """
    if re.search(r"(?:^|[^A-Za-z0-9])[-−]\s*[xyz]\b", name, re.IGNORECASE):
        return ()
    words = {word.lower() for word in re.split(r"[^A-Za-zäöüß]+|(?<=[a-z])(?=[XYZ](?![a-z]))", name) if word}
    letters = sorted(words & {"x", "y", "z"})
    return tuple(letters) if len(letters) == 1 and words - {"x", "y", "z"} <= BESIDE_AXES else ()


def _likely(answers: Sequence[str]) -> str:
    """The axis that a component's names end in, as ``vz`` does; x where they end in none."""
    return next((name[-1].lower() for name in reversed(answers) if name and name[-1].lower() in "xyz"), "x")


def choose_axes(components: Sequence[Component], axes: AxisChoice) -> dict[int, Place]:
    """Axis of each component that is used, by its place in the file.

    ``axes`` maps names, or numbers from 1, to axes; None for the standard ones. Raises ValueError for a component
    without axis, a name without component, and an axis taken twice.
    """
    known: Mapping[str, Place] = STANDARD_AXES if axes is None else axes
    taken = {name for one in components for name in (one.name, *one.answers)}
    numbers = [str(one.number or k + 1) for k, one in enumerate(components)]
    names = [
        (one.name, *one.answers, *([] if number in taken or axes is None else [number]))
        for one, number in zip(components, numbers, strict=True)
    ]
    chosen: dict[int, Place] = {}
    for k, answers in enumerate(names):
        axis = next((known[name] for name in answers if name in known), None)
        if axis is not None:
            chosen[k] = axis
        elif axes is None:
            own = toml_key(next(filter(None, reversed(answers)), numbers[k]))
            raise ValueError(
                f"ground.axes does not say which axis {called(components, k)} is; name it, for instance axes = "
                f'{{ {own} = "{_likely(answers)}" }}, which is --set ground.axes.{own}={_likely(answers)} (and turn it '
                f"round with ground.scale where it points the other way); else {', '.join(STANDARD_AXES)} are known"
            )
    held = ", ".join(called(components, k) for k in range(len(components)))
    missing = [name for name in axes or {} if not any(name in answers for answers in names)]
    if missing:
        raise ValueError(f"ground.axes names {missing[0]!r}, which the record does not hold; it holds {held}")
    twice = [axis for axis, count in Counter(chosen.values()).items() if count > 1]
    if twice:
        both = ", ".join(called(components, k) for k, axis in chosen.items() if axis == twice[0])
        raise ValueError(
            f"ground.axes: {both} are all {twice[0]}; each axis takes one component; choose with ground.axes, by name "
            "or by number"
        )
    if not chosen:
        raise ValueError(f"ground.axes = {axes} leaves no component; the record holds {held}")
    return chosen


def called(components: Sequence[Component], k: int) -> str:
    """How messages call a component: by its name, and by its number where that is needed to tell it apart."""
    name = components[k].name
    alone = sum(one.name == name for one in components) == 1
    number = components[k].number or k + 1
    return repr(name) if name and alone else f"number {number}" + (f" ({name!r})" if name else "")


def toml_key(name: str) -> str:
    """A name as TOML wants its keys."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'


def per_mount(places: Iterable[str]) -> bool:
    """Whether some of the places are those of a single mount."""
    return any(" " in place for place in places)


def agreed_unit(
    choices: Choices, stated: str | tuple[Quantity, float] | None, name: str, remedy: str
) -> tuple[Quantity, float]:
    """What a component holds, and its unit's SI value: as the file says (``stated``), or as the user says.

    Where the file says counts, volts or what is not known, the user says what one count or 1 V is. Raises ValueError
    where neither says it, or the two disagree.
    """
    wanted, users = choices.quantity, choices.user_unit
    found = None if isinstance(stated, str) and is_silent(stated) else stated
    if isinstance(found, str):
        try:
            found = None if users and kind_of(found) in ("counts", "voltage") else motion_unit(found)
        except ValueError as error:
            if users is None:
                raise ValueError(f"ground.file: the unit of {name!r}: {error}; ground.unit can say it") from None
            found = None
    if users is not None and found is not None and (users[0] != found[0] or not isclose(users[1], found[1])):
        raise ValueError(
            f"ground.unit = {choices.unit!r}, but the file states another unit of {name!r} itself; leave ground.unit "
            "out"
        )
    if users is not None and (volts := _volts(stated)):
        users = users[0], users[1] * volts
    found = found or users
    if found is None:
        if wanted == "auto":
            raise ValueError(
                f"ground.quantity = 'auto', but the file does not say what {name!r} holds; set ground.unit, or "
                f"ground.quantity to displacement, velocity or acceleration (samples are then SI), or {remedy}"
            )
        return wanted, 1.0
    if wanted not in ("auto", found[0]):
        raise ValueError(
            f"ground.quantity = {wanted!r}, but the file says that {name!r} is {found[0]}; use 'auto' or {found[0]!r}"
        )
    return found


def _volts(stated: object) -> float | None:
    """How many volts the unit of a sensor's voltage is, None of others."""
    return unit(stated).size if isinstance(stated, str) and kind_of(stated) == "voltage" else None


def recorded(label: str, channels: Sequence[Channel], notes: Sequence[str] = (), name: str | None = None) -> Record:
    """The record of a file, called ``label`` unless it has a name; its notes begin with what was read."""
    parts = (f"{c.axis} from {c.name} ({c.quantity}, {c.end - c.time:g} s at {c.rate:g} Hz)" for c in channels)
    summary = f"record {label}: " + "; ".join(parts)
    return Record(name or label, tuple(channels), (summary, *_differences(channels), *notes))


def _differences(channels: Sequence[Channel]) -> list[str]:
    """Remarks where channels differ in rate or span."""
    notes = []
    if len({channel.rate for channel in channels}) > 1:
        notes.append("sampling rates differ: " + ", ".join(f"{c.axis} {c.rate:g} Hz" for c in channels))
    late, early = (max(values) - min(values) for values in ([c.time for c in channels], [c.end for c in channels]))
    if max(late, early) * min(channel.rate for channel in channels) > 1.5:
        notes.append(f"channels begin up to {late:g} s and end up to {early:g} s apart; the common part is used")
    return notes
