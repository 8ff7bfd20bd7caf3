"""What lines above the rows say of all of them: the sampling rate or interval, and units."""

import re
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

from ehamj.records.tables.cells import Dialect
from ehamj.records.tables.header import PREFIX, bare_unit, header_cells
from ehamj.records.tables.stamps import is_stamp
from ehamj.records.units import is_motion, unit

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
FACTORS = re.compile(
    r"(?:\S+ )?(?:scale|scaling|sensitivity|calibration|gain|multiplier|skalierung|empfindlichkeit|verstärkung|factor"
    r"|faktor|(?:skalierungs|kalibrier|umrechnungs)faktor)(?: (?:factor|constant|coefficient|value))?"
)
"""What numbers are called that samples may have to be multiplied with."""

LONGEST = 300
"""Characters of a line that states something."""
LEADING = re.compile(r"^(?:nominal|actual|effective|channel|the) ")
RATE_WORDS = re.compile(r"(?:samples?|scans|s)\s*(?:/|per)\s*s(?:ec(?:ond)?)?|sps|(?:1\s*)?/\s*s(?:ec)?", re.IGNORECASE)
"""Spellings of Hz that are no unit's."""

STATEMENT = re.compile(r"\s*([^\d:=,;\t][^:=,;\t]*?)\s*(?:[:=,;\t]\s*|\s+(?=[-+.\d]))(.*?)[\s,;]*")
VALUE = re.compile(r"([-+]?[\d.,'’ ]*\d(?:[eE][-+]?\d+)?)\s*[,;\t]?\s*[\[(]?(.*?)[\])]?")


class Stated(NamedTuple):
    """A sampling rate [Hz] that a line states."""

    rate: float
    line: int
    guess: str = ""
    """What was taken for granted."""


class Facts(NamedTuple):
    """What the lines say: sampling rates, units of all columns in order, or one unit for those that state none."""

    rates: tuple[Stated, ...] = ()
    units: tuple[str | None, ...] | None = None
    unit: str | None = None
    unit_line: int = 0
    factors: tuple[str, ...] = ()
    """Lines that state a factor or a sensitivity, which nothing applies."""
    fault: str | None = None
    """What is wrong with the first rate that could not be read: said where there is no other clock."""


def facts(
    lines: Sequence[tuple[int, str]], dialect: Dialect, width: int, empty: bool, told: str, key: str, sure: bool
) -> Facts:
    """What numbered lines above the rows of ``width`` columns state; the last one is ``empty`` after a separator.

    Unless it is ``sure`` which mark is the decimal one, 51.200 is no number.
    """
    rates: list[Stated] = []
    factors: list[str] = []
    units, common, at, fault = None, None, 0, None
    for number, line in lines:
        statement = _statement(line)
        if statement is None:
            continue
        name, stated_unit, value = statement
        where = f"{told}, line {number}"
        if RATE.fullmatch(name) or INTERVAL.fullmatch(name):
            try:
                rate, guess = _rate(
                    name, stated_unit, value, partial(_number, dialect=dialect, sure=sure, key=key), where, key
                )
                rates.append(Stated(rate, number, guess))
            except ValueError as error:
                fault = fault or str(error)
        elif FACTORS.fullmatch(name) and _is_factor(value):
            said = f"{name} [{stated_unit}]" if stated_unit else name
            factors.append(f"line {number} states '{said}: {value[:40]}'")
        elif UNITS.fullmatch(name):
            ways = [header_cells(value, dialect, count, loose=True) for count in (width, width - empty)]
            cells = next(filter(None, ways), None)
            if cells is not None and len(cells) > 1:
                units, at = (*map(bare_unit, cells), *[None] * (width - len(cells))), number
            elif is_motion(value):
                common, at = value, number
    return Facts(tuple(rates), units, common, at, tuple(factors), fault)


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


def _is_factor(value: str) -> bool:
    """Whether a value holds numbers other than one, and is no date."""
    numbers = re.findall(r"(?<![\w.])[-+]?[\d.]+(?:[eE][-+]?\d+)?", value)
    return not is_stamp(value) and any(re.fullmatch(r"\+?1(?:\.0*)?", number) is None for number in numbers)


def _rate(
    name: str, in_name: str, text: str, number: Callable[..., float | None], where: str, key: str
) -> tuple[float, str]:
    """The rate [Hz] that a statement gives, and what was taken for granted."""
    said = f"{where}: {name} = {text[:40]}"
    match = VALUE.fullmatch(text)
    value = None if match is None else number(match[1].strip(), said=said)
    if match is None or value is None or not 0.0 < value < float("inf"):
        raise ValueError(f"{said} must be a positive number; state {key}.rate [Hz], or correct the line")
    written = match[2].strip() or in_name
    if not written and RATE.fullmatch(name):
        return value, ""
    if not written and name == "dt":
        return 1.0 / value, f"dt = {text[:40]} states no unit and is taken as {value:g} s"
    if not written:
        raise ValueError(f"{said} has no unit; state {key}.rate [Hz]")
    if RATE_WORDS.fullmatch(written):
        return value, ""
    try:
        size, kind, *_ = unit(written)
    except ValueError as error:
        raise ValueError(f"{said}: {error}; state {key}.rate [Hz]") from error
    if kind not in ("frequency", "time"):
        raise ValueError(f"{said} is neither a frequency nor a time; state {key}.rate [Hz]")
    return (value * size if kind == "frequency" else 1.0 / (value * size)), ""


def _number(text: str, dialect: Dialect, sure: bool, said: str, key: str) -> float | None:
    """A number with either decimal mark; raises ValueError where the mark may part thousands."""
    grouped = re.fullmatch(r"[-+]?[1-9]\d{0,2}(?:[.,]\d{3})+", text) is not None
    found = None if grouped and not sure else dialect.number(text)
    if found is not None:
        return found
    other = Dialect(dialect.delimiter, {".": ",", ",": "."}[dialect.decimal])
    if grouped or ("." in text and "," in text):
        raise ValueError(f"{said}: {text!r} may have marks of thousands; state {key}.rate [Hz]")
    return other.number(text)
