"""Units as FMI has them: a name in Modelica's grammar, and exponents of the SI's base units."""

import re
from collections import Counter
from typing import Final, NamedTuple

_N: Final = {"kg": 1, "m": 1, "s": -2}
_PA: Final = {"kg": 1, "m": -1, "s": -2}
_V: Final = {"kg": 1, "m": 2, "s": -3, "A": -1}
KNOWN: Final[dict[str, tuple[float, dict[str, int]]]] = {
    **{name: (1.0, {name: 1}) for name in ("m", "s", "kg", "A", "K", "rad")},
    "mA": (1e-3, {"A": 1}),
    "Hz": (1.0, {"s": -1}),
    "N": (1.0, _N),
    "Pa": (1.0, _PA),
    "V": (1.0, _V),
    "J": (1.0, {**_N, "m": 2}),
    "h": (3600.0, {"s": 1}),
    "deg": (0.017453292519943295, {"rad": 1}),
}
"""Factor and exponents of base units."""
WORDS: Final = ("dB", "bit", "octave")
"""Units that have no dimension of the SI."""
SUPERSCRIPTS: Final = str.maketrans("²³⁴", "234")


class Unit(NamedTuple):
    """A unit."""

    name: str
    """In Modelica's grammar: ``m3/(s.mA)``."""
    factor: float
    """Of the base units."""
    exponents: dict[str, int] | None
    """Of base units; None of what is no unit of one dimension (``dB``)."""


NONE: Final = Unit("1", 1.0, {})
"""Of what has no unit in FMI."""


def unit(text: str) -> Unit:
    """What a unit as ehamj writes it, ``m³/s/mA``, is to FMI; "1" where there is none, or its grammar has no word for
    it (``m/√s``)."""
    over: list[str] = []
    under: list[str] = []
    factor, exponents, whole = 1.0, Counter[str](), True
    for number, part in enumerate(re.split(r"/", text)):
        for token in part.split():
            found = re.fullmatch(r"(\D+?)(\d?)", token.translate(SUPERSCRIPTS).replace("^", ""))
            name, power = (found[1], int(found[2] or 1)) if found else (token, 1)
            if name in ("-", "1"):
                continue
            if name not in KNOWN and name not in WORDS:
                return NONE
            (under if number else over).append(f"{name}{power if power > 1 else ''}")
            if name not in KNOWN:
                whole = False
                continue
            sign = power if number == 0 else -power
            factor *= KNOWN[name][0] ** sign
            exponents.update({base: sign * exponent for base, exponent in KNOWN[name][1].items()})
    below = f"({'.'.join(under)})" if len(under) > 1 else "".join(under)
    name = f"{'.'.join(over) or '1'}{'/' if below else ''}{below}"
    return Unit(name, factor, {base: n for base, n in exponents.items() if n} if whole else None)
