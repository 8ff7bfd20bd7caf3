"""How parameters and figures of merit are called on a page: short names, axes with round powers of ten, values."""

import math
from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array
from ehamj.pages.words import SUPERSCRIPTS, exact, number
from ehamj.plant.axes import AXES

PLACES: Final = ("cg", "inertia", "position", "size", "direction")
"""Vectors whose entries are called x, y and z."""
MODES: Final = ("heave", "yaw", "roll", "pitch", "warp", "rms", "peak", "mean", "drawn")
"""Motions and statistics: of what, stands before them."""
BANDED: Final = ("attenuation", "attenuation db")
"""What is told of third-octave bands: the words before the last number, which is the band's centre."""
PLAIN: Final = (1e-2, 1e5)
"""Magnitudes that an axis shows as they are."""
DIGITS: Final = 3


def short_names(keys: Iterable[str]) -> dict[str, str]:
    """A name for each dotted key: as many of its last words as tell it from all others, and say something alone.

    ``actuators.isolator.piston_area`` is "piston area"; of two actuators both are named.
    """
    parts = {key: _words(key) for key in keys}
    counts = {key: _telling(words) for key, words in parts.items()}
    while True:
        said = {key: tuple(words[-counts[key] :]) for key, words in parts.items()}
        alike = {key for key in said if list(said.values()).count(said[key]) > 1 and counts[key] < len(parts[key])}
        if not alike:
            return {key: " ".join(words) for key, words in said.items()}
        counts |= {key: counts[key] + 1 for key in alike}


def _words(key: str) -> list[str]:
    """The words of a key; an entry of a vector by its axis, a band with the point in its number."""
    words: list[str] = []
    for part in key.split("."):
        if words and words[-1] in PLACES and part in "012" and len(part) == 1:
            words[-1] += f" {AXES[int(part)]}"
        elif words and part.isdigit() and words[-1].isdigit():
            words[-1] += f".{part}"  # 31.5 Hz
        else:
            words.append(part.replace("_", " "))
    if any(word in BANDED for word in words) and words[-1].replace(".", "").isdigit():
        words[-1] += " Hz"
    return [word.removesuffix(" db") for word in words]


def _telling(words: list[str]) -> int:
    """How many of the last words say something: a number, an axis or a mode alone does not."""
    count = 1
    while count < len(words) and _needs_more(words[-count]):
        count += 1
    return count


def _needs_more(word: str) -> bool:
    return len(word) <= 2 or word.removesuffix(" Hz").replace(".", "").isdigit() or "-about-" in word or word in MODES


def unit_text(unit: str) -> str:
    """A unit as an axis has it."""
    return "-" if unit in ("", "1") else unit.replace("^2", "²").replace("^3", "³")


def axis_of(name: str, unit: str, values: ArrayLike) -> tuple[str, Array]:
    """An axis' name with its unit, and values of everyday size: a power of ten stands with the unit."""
    found = np.asarray(values, float)
    known = np.abs(found[np.isfinite(found)])
    largest = float(known.max(initial=0.0))
    if largest == 0.0 or PLAIN[0] <= largest < PLAIN[1]:
        return f"{name} [{unit_text(unit)}]", found
    power = 3 * math.floor(math.log10(largest) / 3)
    factor = f"10{str(power).translate(SUPERSCRIPTS)}"
    own = factor if unit_text(unit) == "-" else f"{factor} {unit_text(unit)}"
    return f"{name} [{own}]", found / 10.0**power


def worded(value: Any, unit: str, digits: int = DIGITS) -> str:
    """A value with its unit, as a sentence has it: so many significant digits, or as it was written (0)."""
    if isinstance(value, str | bool) or value is None:
        return str(value)
    if isinstance(value, list | tuple):
        return f"[{', '.join(worded(part, unit, digits) for part in value)}]"
    text = number(float(value), DIGITS) if digits else exact(float(value))
    return text if unit_text(unit) == "-" else f"{text} {unit_text(unit)}"
