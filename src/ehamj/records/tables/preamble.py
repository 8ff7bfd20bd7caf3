"""What lines above the rows say of all of them: the sampling rate or interval, and units."""

import re
from collections.abc import Sequence
from typing import NamedTuple

from ehamj.records.tables.cells import Dialect
from ehamj.records.tables.header import PREFIX, bare_unit, header_cells, kind_of
from ehamj.records.units import unit

RATE = re.compile(
    r"(?:sampl(?:e|ing)|scan|data|acquisition|acq|logging|output data|abtast)[ -]?(?:rate|freq(?:uency)?|frequenz)"
    r"|rate(?: hz)?|fs|f s|sps|odr|samples(?: per |/)s(?:ec(?:ond)?)?|sample rate hz|fréquence d.échantillonnage",
)
"""What a sampling rate is called, in lower case."""

INTERVAL = re.compile(
    r"dt|delta ?t|time ?step|time (?:interval|increment)|(?:sampl(?:e|ing)|scan|logging) (?:interval|period|step)"
    r"|abtast(?:intervall|zeit|periode)"
)
"""What a sampling interval is called."""

UNITS = re.compile(r"(?:channel |column )?(?:units?|einheit(?:en)?)")
LONGEST = 300
"""Characters of a line that states something."""
LEADING = re.compile(r"^(?:nominal|actual|effective|channel|the) ")
RATE_WORDS = re.compile(r"(?:samples?|scans|s)\s*(?:/|per)\s*s(?:ec(?:ond)?)?|sps|(?:1\s*)?/\s*s(?:ec)?", re.IGNORECASE)
"""Spellings of Hz that are no unit's."""

STATEMENT = re.compile(r"\s*([^\d:=,;\t][^:=,;\t]*?)\s*(?:[:=,;\t]\s*|\s+(?=[-+.\d]))(.*?)[\s,;]*")
VALUE = re.compile(r"([-+]?[\d.,' ]*\d(?:[eE][-+]?\d+)?)\s*[,;\t]?\s*[\[(]?(.*?)[\])]?")


class Stated(NamedTuple):
    """A sampling rate [Hz] that a line states."""

    rate: float
    line: int


class Facts(NamedTuple):
    """What the lines say: sampling rates, units of all columns in order, or one unit for those that state none."""

    rates: tuple[Stated, ...] = ()
    units: tuple[str | None, ...] | None = None
    unit: str | None = None
    unit_line: int = 0
    fault: str | None = None
    """What is wrong with the first rate that could not be read: said where there is no other clock."""


def facts(lines: Sequence[tuple[int, str]], dialect: Dialect, width: int, empty: bool, told: str, key: str) -> Facts:
    """What numbered lines above the rows of ``width`` columns state; the last one is ``empty`` after a separator."""
    rates: list[Stated] = []
    units, common, at, fault = None, None, 0, None
    for number, line in lines:
        statement = _statement(line)
        if statement is None:
            continue
        name, stated_unit, value = statement
        where = f"{told}, line {number}"
        if RATE.fullmatch(name) or INTERVAL.fullmatch(name):
            try:
                rates.append(Stated(_rate(name, stated_unit, value, dialect, where, key), number))
            except ValueError as error:
                fault = fault or str(error)
        elif UNITS.fullmatch(name):
            ways = [header_cells(value, dialect, count, loose=True) for count in (width, width - empty)]
            cells = next(filter(None, ways), None)
            if cells is not None and len(cells) > 1:
                units, at = (*map(bare_unit, cells), *[None] * (width - len(cells))), number
            elif kind_of(value) in ("displacement", "velocity", "acceleration"):
                common, at = value, number
    return Facts(tuple(rates), units, common, at, fault)


def states(line: str) -> bool:
    """Whether a line states a rate, an interval or units."""
    statement = _statement(line)
    return statement is not None and any(form.fullmatch(statement[0]) for form in (RATE, INTERVAL, UNITS))


def _statement(line: str) -> tuple[str, str, str] | None:
    """Name in lower case, unit within the name, and value of a line such as ``# Sample rate (Hz): 500``."""
    match = None if len(line) > LONGEST else STATEMENT.fullmatch(PREFIX.sub("", line.replace('"', ""), count=1))
    if match is None or not match[2]:
        return None
    name, _, rest = re.sub(r"[\[(]", "(", match[1]).partition("(")
    plain = re.sub(r"[\s_]+", " ", name.strip().lower())
    return LEADING.sub("", plain), rest.rstrip("])").strip(), match[2]


def _rate(name: str, in_name: str, text: str, dialect: Dialect, where: str, key: str) -> float:
    """The rate [Hz] that a statement gives."""
    said = f"{where}: {name} = {text[:40]}"
    match = VALUE.fullmatch(text)
    value = None if match is None else _number(match[1].strip(), dialect, said, key)
    if match is None or value is None or not 0.0 < value < float("inf"):
        raise ValueError(f"{said} must be a positive number; state {key}.rate [Hz], or correct the line")
    written = match[2].strip() or in_name
    if not written and RATE.fullmatch(name):
        return value
    if not written and name == "dt":
        return 1.0 / value
    if not written:
        raise ValueError(f"{said} has no unit; state {key}.rate [Hz]")
    if RATE_WORDS.fullmatch(written):
        return value
    try:
        size, kind, *_ = unit(written)
    except ValueError as error:
        raise ValueError(f"{said}: {error}; state {key}.rate [Hz]") from error
    if kind not in ("frequency", "time"):
        raise ValueError(f"{said} is neither a frequency nor a time; state {key}.rate [Hz]")
    return value * size if kind == "frequency" else 1.0 / (value * size)


def _number(text: str, dialect: Dialect, said: str, key: str) -> float | None:
    """A number with either decimal mark; raises ValueError where the mark may part thousands."""
    found = dialect.number(text)
    if found is not None:
        return found
    other = Dialect(dialect.delimiter, {".": ",", ",": "."}[dialect.decimal])
    if re.search(r"[1-9]\d{0,2}(?:[.,]\d{3})+$", text) or ("." in text and "," in text):
        raise ValueError(f"{said}: {text!r} may have marks of thousands; state {key}.rate [Hz]")
    return other.number(text)
