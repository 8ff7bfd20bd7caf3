"""What physics would accept of a number, by its unit, and how many of them: beyond is a slip."""

import math
import re
from collections.abc import Iterable
from itertools import islice
from typing import Any, Final

BOUNDS: Final[dict[str, tuple[float, float]]] = {
    "-": (0.0, 1e9),
    "s": (1e-12, 1e9),
    "Hz": (1e-6, 1e7),
    "rad/s": (1e-5, 1e8),
    "bit": (1.0, 64.0),
    "rad": (0.0, 1e6),
    "deg": (0.0, 1e6),
    "m": (0.0, 1e5),
    "m/s": (0.0, 1e15),
    "m/s or rad/s": (0.0, 1e5),
    "m/s²": (0.0, 1e6),
    "m/s³": (1e-9, 1e9),
    "m²": (1e-9, 1e3),
    "m³": (1e-12, 1e6),
    "m³/s": (0.0, 1e3),
    "m³/s/mA": (1e-15, 1.0),
    "m³/s/Pa": (0.0, 1e-3),
    "kg": (1e-3, 1e9),
    "kg m": (0.0, 1e9),
    "kg m²": (1e-6, 1e14),
    "kg/m³": (1.0, 1e5),
    "N": (0.0, 1e10),
    "N/m": (1e-3, 1e14),
    "N s/m": (0.0, 1e11),
    "Pa": (1e-6, 1e12),
    "Pa s": (1e-9, 1e3),
    "V": (0.0, 1e15),
    "mA": (0.0, 1e15),
    "mA/V": (1e-6, 1e6),
    "mA/s": (0.0, 1e9),
    "mA/s²": (1e-3, 1e12),
    "rad s/m": (0.0, 1e9),
    "dB": (0.0, 1e3),
    "dB/octave": (0.0, 1e3),
    "unit": (1e-30, 1e30),
    "h": (1e-6, 1e6),
}
"""Least magnitude of what is not zero, and largest, per unit; none at least where a small rest of a sum may stand."""
OTHERS: Final = (
    "m/√Hz", "m/s/√Hz", "m/s²/√Hz", "Pa/√Hz", "mA/√Hz", "m/√s", "m/s/√s", "m/s²/√s", "Pa/√s", "mA/√s",
    "m/s/s", "m/s²/s", "Pa/s", "(SI of quantity)²/Hz", "SI of quantity", "unit",
)  # fmt: skip
"""Units of densities and drifts, and of what a file says."""
NOISE: Final = (1e-60, 1e12)
"""Bounds of those."""
INTEGER: Final = 2**63 - 1
"""Largest integer that TOML has."""


MOST_NUMBERS: Final = 10_000
"""In a list that stands in a scenario; a longer one is a record, and belongs into a file."""
MOST_TABLES: Final = 1000
"""In a list of tables, or in a table of names."""


def check_count(value: Any) -> Any:
    """A list or a table, as it is; called before what is in it is looked at.

    Raises:
        ValueError: if it holds more than anybody writes.
    """
    if isinstance(value, tuple | list | dict):
        most = MOST_NUMBERS if all(isinstance(one, int | float) for one in islice(value, MOST_TABLES)) else MOST_TABLES
        if len(value) > most:
            raise ValueError(f"has {len(value)} entries; at most {most} are allowed")
    return value


def unit_of(description: str | None) -> str | None:
    """The unit that a description of a number has in brackets, the last of them; None where it has none."""
    found = [one for one in re.findall(r"\[([^\[\]]+)\]", description or "") if one in BOUNDS or one in OTHERS]
    return found[-1] if found else None


def check_magnitude(value: Any, unit: str | None, endless: bool = False, signed: bool = False) -> Any:
    """A number, or numbers within lists and tables, as they are.

    Raises:
        ValueError: if one has a magnitude that nothing of its ``unit`` has. Infinity and zero pass, however much where
            infinity is usual, ``endless``, and however little where it may be the rest of a sum, ``signed``.
    """
    for number in (value,) if type(value) is float else _numbers(value):
        if isinstance(number, int) and abs(number) > INTEGER:
            raise ValueError("an integer must fit into 64 bits")
        least, largest = BOUNDS.get(unit, NOISE) if unit is not None else (0.0, math.inf)
        least = 0.0 if signed else least
        if number and math.isfinite(number) and not least <= abs(number) <= (math.inf if endless else largest):
            allowed = f"at most {largest:g}" if abs(number) > largest else f"at least {least:g}"
            raise ValueError(f"must be {allowed} {'' if unit == '-' else unit}".rstrip() + " in magnitude")
    return value


def _numbers(value: Any) -> Iterable[float]:
    if isinstance(value, bool):
        return
    if isinstance(value, int | float):
        yield value
    elif isinstance(value, tuple | list):
        for entry in value:
            yield from _numbers(entry)
    elif isinstance(value, dict):
        yield from _numbers(list(value.values()))
