"""Responses of a file as those of ehamj's channels: pairs picked, in ehamj's units, each with its variance."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array, ComplexArray
from ehamj.control.units import plain_unit
from ehamj.errors import InputError, did_you_mean
from ehamj.measured.measured import MeasuredResponses
from ehamj.measured.reading import Wanted, place_of, wanted_of
from ehamj.measured.responses.raw import RawResponse
from ehamj.measured.responses.settings import ResponseChoices
from ehamj.measured.responses.table import read_response_table
from ehamj.measured.responses.touchstone import looks_touchstone, read_touchstone
from ehamj.measured.responses.uff import read_uff
from ehamj.measured.responses.variance import variance
from ehamj.measured.settings import Measurement
from ehamj.records.files import existing
from ehamj.records.picked import keyed, users_size
from ehamj.records.readers import HEAD
from ehamj.records.units import powers

UNIVERSAL: Final = (".uff", ".unv")
SAME: Final = 1e-5
"""How near two frequencies lie that are one, over the highest."""
ABOVE: Final = 1e-3
"""How far rounding may carry a coherence above one."""


def read_responses(
    path: Path, measurement: Measurement, mounts: tuple[str, ...], said: ResponseChoices, key: str, name: str = ""
) -> MeasuredResponses:
    """What was measured of each output over each input.

    A universal file names its places, ``12:+Z``, which the table's keys (or ``component``) pick; of a table of text and
    a Touchstone-like file ``said.pair`` tells what is what, where there are several. Frequencies at 0 are left out.

    Args:
        path: of the file.
        measurement: what outputs and inputs are.
        mounts: of the machine, whose channels they are.
        said: averages, and how the file is read.
        key: of the test's table, for messages: ``test.0``.
        name: of the test.

    Raises:
        InputError: naming key and way out: for a response that is not there, is of another unit than its channels have,
            is not finite, or of which nothing says how well it is known.

    Phases are those of e^(+iωt), in which a late output's phase is negative.
    """
    wanted = wanted_of(measurement, mounts, key, path.name)
    outputs, inputs = ([one for one in wanted if one.role == role] for role in ("output", "input"))
    if not outputs or not inputs:
        raise InputError(f"{key}.measurement: a response needs an input and an output; there is only {wanted[0].role}")
    try:
        raws, by_place = _raws(path, said, [one.component for one in outputs], [one.component for one in inputs])
    except InputError:
        raise
    except ValueError as error:
        raise InputError(keyed(str(error), key)) from error
    pairs = _pairs(raws, by_place, outputs, inputs, key, path.name)
    frequency = _frequency(list(pairs.values()), key, path.name)
    kept = frequency > 0.0
    shape = (int(kept.sum()), len(outputs), len(inputs))
    response, deviated, coherence = np.full(shape, np.nan, complex), np.full(shape, np.nan), np.full(shape, np.nan)
    notes: list[str] = [] if kept.all() else [f"{path.name}: values at 0 Hz are left out"]
    for (p, q), raw in pairs.items():
        response[:, p, q] = _finite(raw, kept, key) * _size(raw, outputs[p], inputs[q])
        own = _coherence(raw, kept, key)
        deviated[:, p, q], remarks = _variance(raw, response[:, p, q], own, said, key)
        coherence[:, p, q] = np.nan if own is None else own
        notes += remarks
    return MeasuredResponses(
        name or path.name,
        frequency[kept],
        tuple(one.channel for one in inputs),
        tuple(one.channel for one in outputs),
        tuple(one.unit.text for one in inputs),
        tuple(one.unit.text for one in outputs),
        response,
        deviated,
        coherence,
        tuple(place_of(one.said) for one in inputs),
        tuple(notes),
        tuple(place_of(one.said) for one in outputs),
    )


def _raws(path: Path, said: ResponseChoices, outputs: list[str], inputs: list[str]) -> tuple[list[RawResponse], bool]:
    """The file's responses, and whether they are called by places, not by keys of the table."""
    existing(path)
    if path.suffix.lower() in UNIVERSAL:
        for name in ("pair", "phase_unit", "table"):
            if getattr(said, name):
                raise ValueError(f"ground.{name} is of use with tables only, and {path.name!r} is a universal file")
        return read_uff(path), True
    with path.open("rb") as file:
        touchstone = looks_touchstone(path, file.read(HEAD))
    for k, pair in enumerate(said.pair):
        for side, known in (("output", outputs), ("input", inputs)):
            if (stated := getattr(pair, side)) not in known:
                near = did_you_mean(stated, known)
                raise ValueError(f"ground.pair.{k}.{side} = {stated!r}: {near}must be one of {', '.join(known)}")
    read = read_touchstone if touchstone else read_response_table
    return read(path, said, outputs, inputs), False


def _pairs(
    raws: Sequence[RawResponse],
    by_place: bool,
    outputs: Sequence[Wanted],
    inputs: Sequence[Wanted],
    key: str,
    label: str,
) -> dict[tuple[int, int], RawResponse]:
    """Responses that are wanted, by number of output and input."""
    sides = [
        [one.said.component or one.component if by_place else one.component for one in s] for s in (outputs, inputs)
    ]
    found: dict[tuple[int, int], RawResponse] = {}
    for raw in raws:
        if raw.output in sides[0] and raw.input in sides[1]:
            at = sides[0].index(raw.output), sides[1].index(raw.input)
            if at in found:
                raise InputError(f"{key}.file = {label!r} holds {raw.told} twice; leave one of them out of it")
            found[at] = raw
    for number, side in enumerate((outputs, inputs)):
        for k, one in enumerate(side):
            if all(at[number] != k for at in found):
                held = ", ".join(dict.fromkeys(raw.told for raw in raws))
                raise InputError(
                    f"{one.key}: {label!r} holds no response of it {'over an input' if number == 0 else 'to it'} that "
                    f"is stated; it holds {held}"
                )
    return found


def _frequency(raws: Sequence[RawResponse], key: str, label: str) -> Array:
    first = raws[0].frequency
    for raw in raws:
        own = raw.frequency
        if not np.isfinite(own).all() or (np.diff(own) <= 0.0).any() or own[0] < 0.0:
            raise InputError(f"{key}.file = {label!r}: frequencies of {raw.told} must rise, from 0 Hz or more")
        if own.shape != first.shape or np.abs(own - first).max() > SAME * first[-1]:
            raise InputError(
                f"{key}.file = {label!r}: {raw.told} is at other frequencies than {raws[0].told}; make them two tests"
            )
    return first


def _finite(raw: RawResponse, kept: NDArray[np.bool_], key: str) -> ComplexArray:
    values = raw.values[kept]
    wrong = np.flatnonzero(~np.isfinite(values))
    if wrong.size:
        where = f"{raw.frequency[kept][wrong[0]]:g} Hz"
        raise InputError(f"{key}.file: {raw.told} holds {wrong.size} values that are not finite, the first at {where}")
    return values


def _size(raw: RawResponse, output: Wanted, driven: Wanted) -> float:
    """Factor from the file's numbers to ehamj's units of output over input."""
    users = [users_size(one.pick) for one in (output, driven)]
    scale = output.said.scale / driven.said.scale * driven.unit.size / output.unit.size
    if raw.unit is None:
        for one, size in zip((output, driven), users, strict=True):
            if size is None:
                raise InputError(
                    f"{one.key}.unit is missing: the file does not say what {raw.told} is in; state the units of "
                    "output and input, or unit = 'SI'"
                )
        return scale * float(users[0] or 1.0) / float(users[1] or 1.0)
    try:
        stated = powers(raw.unit)
    except ValueError as error:
        raise InputError(f"{output.key}: the unit of {raw.told}: {error}") from None
    above, below = (powers(plain_unit(one.unit.text)) for one in (output, driven))
    if any(a - b != c for a, b, c in zip(above[1:], below[1:], stated[1:], strict=True)):
        raise InputError(
            f"{output.key}: {raw.told} is in {raw.unit}, and {output.channel} over {driven.channel} is in "
            f"({output.unit.text})/({driven.unit.text}) or the like; name other channels"
        )
    for one, size in zip((output, driven), users, strict=True):
        if size is not None:
            raise InputError(
                f"{one.key}.unit = {one.said.unit!r}, but the file states {raw.unit} itself; leave unit out"
            )
    return scale * stated.size


def _coherence(raw: RawResponse, kept: NDArray[np.bool_], key: str) -> Array | None:
    if raw.coherence is None:
        return None
    own = raw.coherence[kept]
    if not ((own >= 0.0) & (own <= 1.0 + ABOVE)).all():
        worst = own[np.argmax(np.where(np.isfinite(own), np.abs(own - 0.5), np.inf))]
        raise InputError(f"{key}.file: the coherence of {raw.told} holds {worst:g}; γ² lies from 0 to 1")
    return np.minimum(own, 1.0)


def _variance(
    raw: RawResponse, values: ComplexArray, coherence: Array | None, said: ResponseChoices, key: str
) -> tuple[Array, list[str]]:
    """E|error|² of a response, and remarks."""
    if coherence is not None and said.averages is not None:
        found, raised = variance(values, coherence, said.averages)
        told = f"{raw.told}: {raised} of {found.size} deviations are raised to 0.1 %, as its coherence is nearly one"
        return found, [told] if raised else []
    if said.deviation is None:
        missing = "averages" if coherence is not None else "deviation"
        what = (
            "how many averages its coherence is of" if coherence is not None else "how well it is known: no coherence"
        )
        raise InputError(
            f"{key}.{missing} is missing: nothing says of {raw.told} {what}; state it, or deviation, the standard "
            "deviation of a value over the value"
        )
    return (said.deviation * np.abs(values)) ** 2, []
