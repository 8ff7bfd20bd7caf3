"""The one table of units: what files and users write, whatever its spelling, and its SI value.

A unit is read by a small grammar, so that spellings need no table of their own: ``m/s^2``, ``M/S**2``, ``M/SEC/SEC``,
``(mm/s²)``, ``m s-2`` and ``m·s⁻²`` are products of powers of the names below; names may have a prefix.
"""

import math
import re
import unicodedata
from fractions import Fraction
from functools import lru_cache
from typing import Final, Literal, NamedTuple

from ehamj.records.powers import (
    ACCELERATION,
    HERTZ,
    METRE,
    NEWTON,
    ONE,
    PASCAL,
    RADIAN,
    SECOND,
    SPEED,
    Power,
    of,
)

Quantity = Literal["displacement", "velocity", "acceleration"]
Kind = Literal[
    "displacement",
    "velocity",
    "acceleration",
    "angle",
    "angular velocity",
    "angular acceleration",
    "force",
    "pressure",
    "current",
    "voltage",
    "time",
    "frequency",
    "counts",
]

ORDERS: dict[Quantity, int] = {"displacement": 0, "velocity": 1, "acceleration": 2}
"""How often the displacement is differentiated to get the quantity."""

GRAVITY = 9.80665
"""Standard acceleration of gravity [m/s²] (ISO 80000-3)."""

INCH = 0.0254
"""[m]"""

POUND_FORCE = 4.4482216152605
"""[N] (NIST SP 811)"""


class Unit(NamedTuple):
    """A unit: its SI value, and what it is of."""

    size: float
    kind: Kind


PREFIXES: Final = {"p": 1e-12, "n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "d": 1e-1, "k": 1e3}
"""By letter, in either case: no floor is measured in mega or peta; `MEGA` has what is."""

LONG_PREFIXES: Final = {"pico": "p", "nano": "n", "micro": "u", "milli": "m", "centi": "c", "deci": "d", "kilo": "k"}

_SCALED: dict[str, tuple[Power, str]] = {
    **dict.fromkeys(("m", "meter", "metre", "meters", "metres"), (METRE, "pnumcdk")),
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), (SECOND, "num")),
    **dict.fromkeys(("g", "gn"), (of(GRAVITY, ACCELERATION), "num")),
    **dict.fromkeys(("gal", "gals"), (of(1e-2, ACCELERATION), "num")),
    **dict.fromkeys(("in", "inch", "inches"), (of(INCH, METRE), "um")),
    **dict.fromkeys(("hz", "hertz"), (HERTZ, "k")),
    **dict.fromkeys(("v", "volt", "volts"), (Power(1.0, volt=Fraction(1)), "num")),
    **dict.fromkeys(("a", "amp", "amps", "ampere", "amperes"), (Power(1.0, ampere=Fraction(1)), "num")),
    **dict.fromkeys(("n", "newton", "newtons"), (NEWTON, "umdk")),
    **dict.fromkeys(("pa", "pascal", "pascals"), (PASCAL, "umk")),
    "bar": (of(1e5, PASCAL), "um"),
    **dict.fromkeys(("rad", "radian", "radians"), (RADIAN, "num")),
}
"""What a name stands for, and the prefixes that it may have."""

_WHOLE: dict[str, Power] = {
    **dict.fromkeys(("lbf", "lbsf"), of(POUND_FORCE, NEWTON)),
    **dict.fromkeys(("kgf", "kp"), of(GRAVITY, NEWTON)),
    **dict.fromkeys(("psi", "psia"), of(POUND_FORCE / INCH**2, PASCAL)),
    "hpa": of(100.0, PASCAL),
    **dict.fromkeys(("deg", "degs", "degree", "degrees"), of(math.pi / 180.0, RADIAN)),
    "rpm": of(2.0 * math.pi / 60.0, RADIAN.times(SECOND, Fraction(-1))),
    **dict.fromkeys(("micron", "microns"), of(1e-6, METRE)),
    **dict.fromkeys(("mil", "mils", "thou"), of(1e-3 * INCH, METRE)),
    **dict.fromkeys(("ft", "foot", "feet"), of(0.3048, METRE)),
    "ips": of(INCH, SPEED),
    "kine": of(1e-2, SPEED),
    "sps": HERTZ,
    **dict.fromkeys(("min", "mins", "minute", "minutes"), of(60.0, SECOND)),
    **dict.fromkeys(("h", "hr", "hrs", "hour", "hours"), of(3600.0, SECOND)),
    **dict.fromkeys(("d", "day", "days"), of(86400.0, SECOND)),
    **dict.fromkeys(("count", "counts", "cts", "adu", "lsb", "digit", "digits"), Power(1.0, counts=Fraction(1))),
}
"""Names that take no prefix."""

_KINDS: dict[tuple[Fraction, ...], Kind] = {
    METRE[1:]: "displacement",
    SPEED[1:]: "velocity",
    ACCELERATION[1:]: "acceleration",
    SECOND[1:]: "time",
    HERTZ[1:]: "frequency",
    _WHOLE["counts"][1:]: "counts",
    _SCALED["v"][0][1:]: "voltage",
    _SCALED["a"][0][1:]: "current",
    NEWTON[1:]: "force",
    PASCAL[1:]: "pressure",
    RADIAN[1:]: "angle",
    RADIAN.times(SECOND, Fraction(-1))[1:]: "angular velocity",
    RADIAN.times(SECOND, Fraction(-2))[1:]: "angular acceleration",
}

MEGA: Final = frozenset(("pa", "pascal", "pascals", "n", "newton", "newtons"))
"""Names before which a capital M is mega, as in MPa."""

CAPITAL: Final = frozenset("an")
"""Names that stand alone in capitals only: a and n are names of columns, of normal or acceleration."""

SAID: Final[dict[Kind, str]] = {
    "displacement": "m, mm, µm, in, ft, mil",
    "velocity": "m/s, mm/s, in/s",
    "acceleration": "m/s^2, g, Gal",
    "angle": "rad, mrad, deg",
    "angular velocity": "rad/s, deg/s, rpm",
    "angular acceleration": "rad/s^2, deg/s^2",
    "force": "N, kN, lbf, kgf",
    "pressure": "Pa, kPa, MPa, bar, mbar, psi",
    "current": "A, mA",
    "voltage": "V, mV",
}
"""Units of what is measured, as messages list them; each may have its usual prefixes."""

KNOWN: Final = "m, m/s, m/s^2 (with k, c, m, u, n before m; also in, ft, mil), g, Gal"
"""Units of motion, as messages list them."""

LONGEST: Final = 100
"""Characters of a unit."""

SILENT: Final = frozenset({"", "none", "-", "--", "n/a", "na", "unknown", "unitless", "null", "?"})
"""What files write where they state no unit."""

_SUPERSCRIPT: Final = "⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹"
_EXPONENT: Final = re.compile(r"(?:\^\s*)?([+-]?\d+)|\^\s*\(\s*([+-]?\d+)\s*\)")


def is_silent(text: str | None) -> bool:
    """Whether a text that stands for a unit states none."""
    return text is None or bare(text).lower() in SILENT


def bare(text: str) -> str:
    """A unit without the brackets and quotes around it."""
    plain = text.strip().strip("\"'").strip()
    while len(plain) > 1 and (plain[0], plain[-1]) in (("[", "]"), ("{", "}"), ("<", ">")):
        plain = plain[1:-1].strip()
    return plain


def unit(text: str) -> Unit:
    """The unit that a text states.

    Raises:
        ValueError: if it is none that is known.
    """
    power = powers(text)
    kind = _KINDS.get(power[1:])
    if kind is None:
        raise ValueError(f"{text.strip()!r} is not a unit of motion; known are {KNOWN}")
    return Unit(power.size, kind)


@lru_cache(1000)
def kind_of(text: str) -> Kind | None:
    """What a unit is of, None where it is none that is known."""
    try:
        return unit(text).kind
    except ValueError:
        return None


def motion_unit(text: str) -> tuple[Quantity, float]:
    """Quantity and SI value of a unit of motion.

    Raises:
        ValueError: if it is none; of counts and volts it says what to do.
    """
    found = unit(text)
    if found.kind in ("displacement", "velocity", "acceleration"):
        return found.kind, found.size
    told = {
        "counts": "counts of a converter: say what one is with ground.unit and ground.scale, or give its response",
        "voltage": "a sensor's voltage: say what 1 V stands for with ground.unit and ground.scale",
    }
    raise ValueError(f"{text.strip()!r} is of {told.get(found.kind, found.kind)}; known are {KNOWN}")


def is_motion(text: str) -> bool:
    """Whether a text states a unit of motion."""
    return kind_of(text) in ORDERS


def time_unit(text: str) -> float:
    """SI value of a unit of time [s].

    Raises:
        ValueError: if it is none.
    """
    found = unit(text)
    if found.kind != "time":
        raise ValueError(f"{text.strip()!r} is of {found.kind}; known are s, ms, us, ns, min, h")
    return found.size


def density_unit(text: str) -> tuple[Quantity, float, bool]:
    """Of a unit of spectral density, (U)^2/Hz or U/sqrt(Hz): quantity and SI value of U, and whether it is the root.

    Raises:
        ValueError: if it is none.
    """
    power = powers(text)
    for root in (False, True):
        squared = ONE.times(power, Fraction(2)) if root else power
        whole = squared.times(HERTZ, Fraction(1))  # per Hz taken off
        kind = _KINDS.get(ONE.times(whole, Fraction(1, 2))[1:])
        if kind in ("displacement", "velocity", "acceleration"):
            return kind, power.size if root else power.size**0.5, root
    raise ValueError(f"{text.strip()!r} is not (U)^2/Hz or U/sqrt(Hz), known are for U {KNOWN}")


def powers(text: str) -> Power:
    """SI value and powers of the unit that a text states.

    Raises:
        ValueError: if there is a name that is not known, or no sense in it.
    """
    if len(text) > LONGEST:  # brackets nest no deeper than Python does
        raise ValueError(f"{text[:LONGEST].strip()!r}… is not a unit that is known; known are {KNOWN}")
    parser = _Parser(_plain(text))
    try:
        found = parser.product()
        if parser.rest:
            raise ValueError(f"{parser.rest!r} is left over")
    except (ValueError, OverflowError) as error:
        raise ValueError(f"{text.strip()!r} is not a unit that is known ({error}); known are {KNOWN}") from None
    return found


def _plain(text: str) -> str:
    """A unit in ASCII, its powers as ^, its products as *."""
    raised = re.sub(f"[{_SUPERSCRIPT}]+", lambda found: "^" + unicodedata.normalize("NFKC", found[0]), bare(text))
    plain = unicodedata.normalize("NFKC", raised).translate(
        {0x3BC: "u", 0x2212: "-", 0x22C5: "*", 0xB7: "*", 0xD7: "*"}
    )
    plain = plain.replace("√", "sqrt ").replace("°", "deg").replace("**", "^")
    plain = re.sub(r"(?<=[a-z])\.(?=[\^)/*\s]|$)", "", plain, flags=re.IGNORECASE)  # sec.
    return re.sub(r"\s+per\s+", "/", plain, flags=re.IGNORECASE).strip()


class _Parser:
    """Recursive descent: a product of powers of names and of parentheses."""

    def __init__(self, text: str) -> None:
        self.rest = text
        self.parted = False
        """Whether blanks stood between what was taken last and the rest."""

    def product(self) -> Power:
        found, divided = self.factor(False), False
        while self.rest and self.rest[0] != ")":
            mark = self.taken(r"[/*.]|(?=[a-z(])")
            if mark != "/" and divided:
                raise ValueError("a product after a / can be read in two ways; use brackets")
            divided = divided or mark == "/"
            found = found.times(self.factor(mark == "/"), Fraction(-1 if mark == "/" else 1))
        return found

    def factor(self, below: bool) -> Power:
        """A name or brackets, with their power; ``below`` a fraction's line no power may be negative."""
        if self.rest.startswith("("):
            self.taken(r"\(")
            found, name = self.product(), ""
            self.taken(r"\)")
        else:
            name = self.taken(r"[a-z]+")
            if name.lower() == "sqrt":
                return ONE.times(self.factor(below), Fraction(1, 2))
            found = ONE
        match = None if self.parted else _EXPONENT.match(self.rest)
        power = int(match[1] or match[2]) if match else 1
        self.rest = self.rest[match.end() :].lstrip() if match else self.rest
        if abs(power) > 9 or power == 0 or (below and power < 0):
            raise ValueError(f"the power {power} makes no sense")
        length = _named(name[:-1]) if power < 0 and name[-1:] in ("s", "S") else None
        if length is not None and length[1:] == METRE[1:]:  # ms-2 is m s^-2, which nobody means as milliseconds
            return length.times(SECOND, Fraction(power))
        named = _named(name) if name else found
        if named is None:
            raise ValueError(f"{name!r} is unknown")
        return ONE.times(named, Fraction(power))

    def taken(self, pattern: str) -> str:
        match = re.match(pattern, self.rest, flags=re.IGNORECASE)
        if match is None:
            raise ValueError(f"{self.rest!r} makes no sense here" if self.rest else "it breaks off")
        after = self.rest[match.end() :]
        self.rest = after.lstrip()
        self.parted = len(self.rest) < len(after) and not self.rest.startswith("^")
        return match[0]


def _named(name: str) -> Power | None:
    """What a name stands for, prefix included; None if it is not known."""
    if name == "Nm":  # a torque, not a length
        return None
    low = name.lower()
    if low in _WHOLE:
        return _WHOLE[low]
    if name in CAPITAL:
        return None
    if low in _SCALED:
        return _SCALED[low][0]
    for long, letter in LONG_PREFIXES.items():
        if low.startswith(long):
            low = letter + low.removeprefix(long)
    power, allowed = _SCALED.get(low[1:], (ONE, ""))
    if name[:1] == "M" and low[1:] in MEGA:
        return power._replace(size=1e6 * power.size)
    return power._replace(size=PREFIXES[low[0]] * power.size) if low[:1] and low[0] in allowed else None
