"""What is measured of a floor: quantities, and the units that files and users give them in."""

import re
from typing import Literal

Quantity = Literal["displacement", "velocity", "acceleration"]

ORDERS: dict[Quantity, int] = {"displacement": 0, "velocity": 1, "acceleration": 2}
"""How often the displacement is differentiated to get the quantity."""

GRAVITY = 9.80665
"""Standard acceleration of gravity [m/s²]."""

UNITS: dict[str, tuple[Quantity, float]] = {
    "m": ("displacement", 1.0),
    "mm": ("displacement", 1e-3),
    "um": ("displacement", 1e-6),
    "nm": ("displacement", 1e-9),
    "m/s": ("velocity", 1.0),
    "mm/s": ("velocity", 1e-3),
    "um/s": ("velocity", 1e-6),
    "nm/s": ("velocity", 1e-9),
    "m/s^2": ("acceleration", 1.0),
    "mm/s^2": ("acceleration", 1e-3),
    "um/s^2": ("acceleration", 1e-6),
    "g": ("acceleration", GRAVITY),
}
"""Units of samples: what they are of, and the SI value. Other spellings: see `spelled`."""


def spelled(unit: str) -> str:
    """A unit as `UNITS` spells it: µ as u, ² and ** 2 as ^2, s2 as s^2, no spaces."""
    plain = re.sub(r"[µμ]", "u", unit.replace(" ", "").replace("²", "^2").replace("**2", "^2"))
    return re.sub(r"/s2\b", "/s^2", plain)
