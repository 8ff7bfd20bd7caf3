"""Responses in tables of text: a column of frequencies, and two for each complex number."""

from pathlib import Path
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.measured.responses.raw import RawResponse
from ehamj.measured.responses.settings import ResponseChoices, ResponsePair
from ehamj.records.tables.header import words
from ehamj.records.tables.layout import Column
from ehamj.records.tables.table import Table, read_table
from ehamj.records.units import is_silent, kind_of, unit

PARTS: Final = {
    "real": frozenset(("re", "real", "realteil", "réel")),
    "imaginary": frozenset(("im", "imag", "imaginary", "imaginär", "imaginärteil")),
    "magnitude": frozenset(("mag", "magnitude", "abs", "amplitude", "amp", "gain", "betrag", "amplitudengang")),
    "phase": frozenset(("phase", "arg", "angle", "phasengang", "winkel")),
    "coherence": frozenset(("coh", "coherence", "γ²", "gamma2", "kohärenz")),
}
"""Words in the names of columns that say what they hold."""
FREQUENCY: Final = frozenset(("frequency", "frequencies", "freq", "f", "frequenz", "fréquence"))
DECIBEL: Final = frozenset(("db",))


def read_response_table(path: Path, said: ResponseChoices, outputs: list[str], inputs: list[str]) -> list[RawResponse]:
    """The responses of a table of text.

    Without ``pair`` the table must hold one response, of the one output over the one input, whose columns say by their
    names what they are: real and imaginary, or magnitude and phase, and coherence.

    Raises:
        ValueError: where the table cannot be read, or does not say what its columns are.
    """
    table = read_table(path, "ground.file", said.table)
    column = _frequency(table)
    frequency = _hertz(table, column)
    pairs = said.pair or (_only(table, outputs, inputs),)
    return [_response(table, frequency, pair, k, said) for k, pair in enumerate(pairs)]


def _frequency(table: Table) -> Column:
    """The column of frequencies: by its name or unit."""
    named = [one for one in table.columns if FREQUENCY & set(words(one.name))]
    found = named or [one for one in table.columns if one.unit is not None and kind_of(one.unit) == "frequency"]
    if len(found) != 1:
        held = ", ".join(repr(one.name) for one in table.columns)
        raise ValueError(
            f"{table.told}: {len(found)} columns hold frequencies, of {held}; call one 'frequency [Hz]', or state "
            f"{table.choices_key}.columns"
        )
    return found[0]


def _hertz(table: Table, column: Column) -> Array:
    values = table.numbers(column)
    if column.unit is None or is_silent(column.unit):
        return values
    kind = kind_of(column.unit)
    if kind not in ("frequency", "angular velocity"):
        raise ValueError(f"{table.told}: column {column.name!r} is in {column.unit!r}; frequencies are in Hz or rad/s")
    return values * unit(column.unit).size / (1.0 if kind == "frequency" else 2.0 * np.pi)


def _only(table: Table, outputs: list[str], inputs: list[str]) -> ResponsePair:
    """What the columns are by their names, of a table of one response."""
    if len(outputs) != 1 or len(inputs) != 1:
        raise ValueError(
            f"ground.pair is missing: {table.label!r} does not say which columns are of which of {len(outputs)} "
            f"outputs and {len(inputs)} inputs; state a [[test.pair]] for each"
        )
    held: dict[str, str] = {}
    for part, known in PARTS.items():
        found = [one for one in table.columns if known & set(words(one.name))]
        if len(found) > 1:
            several = ", ".join(repr(one.name) for one in found)
            raise ValueError(
                f"ground.pair is missing: {table.label!r} holds {several}; state a [[test.pair]] that names one"
            )
        if found:
            held[part] = str(found[0].place + 1)
    for first, second in (("real", "imaginary"), ("magnitude", "phase")):
        if first in held and second in held:
            kept = {part: held[part] for part in (first, second, "coherence") if part in held}
            return ResponsePair.model_validate({"output": outputs[0], "input": inputs[0], **kept})
    names = ", ".join(repr(one.name) for one in table.columns)
    raise ValueError(
        f"ground.pair is missing: {table.label!r} holds {names}, of which none are called real and imaginary, or "
        "magnitude and phase; state a [[test.pair]] that names them"
    )


def _response(table: Table, frequency: Array, pair: ResponsePair, number: int, said: ResponseChoices) -> RawResponse:
    key = f"ground.pair.{number}" if said.pair else "ground.pair"

    def column(part: str) -> Column:
        wanted = getattr(pair, part)
        if wanted is None:
            raise ValueError(f"{key}.real is missing: name its columns real and imaginary, or magnitude and phase")
        found = [one for one in table.columns if wanted == one.name] or [
            one for one in table.columns if wanted in (str(one.place + 1), f"column {one.place + 1}")
        ]
        if len(found) != 1:
            held = ", ".join(repr(one.name) for one in table.columns)
            raise ValueError(
                f"{key}.{part} = {wanted!r} names {len(found)} columns of {table.label!r}, which holds {held}"
            )
        return found[0]

    coherence = None if pair.coherence is None else table.numbers(column("coherence"))
    word = f"{pair.output} over {pair.input}"
    if pair.magnitude is not None:
        size, angle = column("magnitude"), column("phase")
        stated = None if size.unit is None or is_silent(size.unit) else size.unit
        magnitude = table.numbers(size)
        if DECIBEL & {*words(size.name), (stated or "").lower()}:
            magnitude, stated = 10.0 ** (magnitude / 20.0), None if (stated or "db").lower() == "db" else stated
        values = magnitude * np.exp(1j * _radians(table, angle, said))
        return RawResponse(pair.output, pair.input, frequency, values, stated, coherence, word)
    re, im = column("real"), column("imaginary")
    units = {one.unit for one in (re, im) if one.unit is not None and not is_silent(one.unit)}
    if len(units) > 1:
        raise ValueError(
            f"{key}: columns {re.name!r} and {im.name!r} are in {' and '.join(sorted(units))}; one must be right"
        )
    values = table.numbers(re) + 1j * table.numbers(im)
    return RawResponse(pair.output, pair.input, frequency, values, next(iter(units), None), coherence, word)


def _radians(table: Table, column: Column, said: ResponseChoices) -> Array:
    """Phases, in the unit that the column states by its head or name, or the user."""
    stated = column.unit if column.unit is not None and not is_silent(column.unit) else None
    inside = [one for one in words(column.name) if kind_of(one) == "angle"]
    text = stated or next(iter(inside), None)
    if text is None and said.phase_unit is None:
        raise ValueError(
            f"ground.phase_unit is missing: column {column.name!r} of {table.label!r} does not say whether its phases "
            "are in deg or rad"
        )
    text = text or str(said.phase_unit)
    if kind_of(text) != "angle":
        raise ValueError(f"{table.told}: column {column.name!r} is in {text!r}; phases are in deg or rad")
    if said.phase_unit is not None and not np.isclose(unit(text).size, unit(said.phase_unit).size):
        raise ValueError(
            f"ground.phase_unit = {said.phase_unit!r}, but column {column.name!r} says {text!r}; leave phase_unit out"
        )
    return table.numbers(column) * unit(text).size
