"""How the page writes numbers, names and units."""

import cmath
import math
from collections.abc import Mapping
from typing import Any, Final

DASH: Final = "–"
MICRO: Final = 1e6
BAR: Final = 1e-5
LITRE_PER_MINUTE: Final = 6e4

ENGINEERING: Final = {
    "m": (1e6, "µm"),
    "m/s": (1e6, "µm/s"),
    "m/s^2": (1e3, "mm/s²"),
    "rad": (1e6, "µrad"),
    "rad/s": (1e6, "µrad/s"),
    "Pa": (1e-5, "bar"),
    "m^3": (1e6, "cm³"),
    "m^3/s": (6e4, "l/min"),
}
"""Factor and unit in which people read an SI unit."""

NEGLIGIBLE: Final = 1e-6
"""Values below this in engineering units are rounding; a channel of nothing else is left out."""

AXIS_NAMES: Final = {
    "z": "vertical, z",
    "x": "along x",
    "y": "along y",
    "rx": "roll, rx",
    "ry": "pitch, ry",
    "rz": "yaw, rz",
}
CRITERION_AXES: Final = ("z", "x", "y")
TURNS: Final = ("rx", "ry", "rz")

SUPERSCRIPTS: Final = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float | None, digits: int = 3) -> str:
    """A measured number with so many significant digits; a dash where there is none."""
    if value is None or math.isnan(value):
        return DASH
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0:
        return "0"
    mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
    exponent = int(power)
    if -4 < exponent < 6:
        text = f"{float(f'{mantissa}e{power}'):.{max(digits - 1 - exponent, 0)}f}"
    else:
        text = f"{mantissa} × 10{str(exponent).translate(SUPERSCRIPTS)}"
    return text.replace("-", "−")


def exact(value: float) -> str:
    """A number that someone wrote, as it was written."""
    if not math.isfinite(value):
        return number(value)
    text = f"{value:.9g}"
    if abs(value) >= 1e6 or 0 < abs(value) < 1e-3:
        mantissa, _, power = f"{value:.8e}".partition("e")
        mantissa = mantissa.rstrip("0").rstrip(".")
        text = f"{mantissa} × 10{str(int(power)).translate(SUPERSCRIPTS)}"
    return text.replace("-", "−")


def within(value: float, deviation: float, digits: int = 2) -> str:
    """A number with its standard deviation, both to so many significant digits of the latter: ``1.94 ± 0.012``, or
    ``(1.943 ± 0.012) × 10⁻⁶``; without a deviation as it was written."""
    if deviation == 0.0:
        return exact(value)
    if not (math.isfinite(value) and math.isfinite(deviation)):
        return f"{number(value)} ± {number(deviation)}"
    largest = max(abs(value), deviation)
    power = math.floor(math.log10(largest)) if largest >= 1e6 or largest < 1e-3 else 0
    first = math.floor(math.log10(float(f"{deviation:.{digits - 1}e}")))
    places = max(power - first + digits - 1, 0)
    one, other = (f"{part / 10.0**power:.{places}f}".replace("-", "−") for part in (value, deviation))
    both = f"{one} ± {other}"
    return f"({both}) × 10{str(power).translate(SUPERSCRIPTS)}" if power else both


def measured(value: float | None) -> str:
    """A number in engineering units, of which nobody reads less than a thousandth."""
    return "< 0.001" if value is not None and 0.0 < abs(value) < 1e-3 else number(value)


def decibel(value: float | None) -> str:
    """A level difference to a tenth of a decibel."""
    return DASH if value is None else f"{value:.1f}".replace("-0.0", "0.0").replace("-", "−")


def motion(parts: Mapping[str, complex], least: float, digits: str = ".2g", in_step: float = 1.0) -> str:
    """A complex motion in words, such as ``y 0.77, rx −1``.

    Args:
        parts: by name.
        least: share of the largest part below which a part is left out.
        digits: format of the sizes.
        in_step: phase below which parts count as in step, or against each other: they get a sign; others an angle
            [deg].
    """
    largest = max(map(abs, parts.values()))
    words = []
    for name, part in parts.items():
        if abs(part) > least * largest:
            size, angle = abs(part), math.degrees(cmath.phase(part))
            if abs(angle) > 180.0 - in_step:
                size, angle = -size, 0.0
            words.append(f"{name} {size:{digits}}" + (f"∠{angle:.0f}°" if abs(angle) > in_step else ""))
    return ", ".join(words).replace("-", "−")


def plain(value: Any) -> str:
    """A setting as text."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return exact(value)
    if isinstance(value, Mapping):
        return ", ".join(f"{key}: {plain(part)}" for key, part in value.items())
    if isinstance(value, tuple | list):
        if len(value) > 12:
            return f"{len(value)} values, {plain(value[0])} to {plain(value[-1])}"
        return ", ".join(f"({plain(part)})" if isinstance(part, tuple) else plain(part) for part in value) or DASH
    return DASH if value is None or value == "" else str(value)


def plain_within(value: Any, deviation: Any) -> str:
    """A setting as text, each number of it with its standard deviation; None: no number has one."""
    if deviation is None:
        return plain(value)
    if isinstance(value, tuple | list):
        return ", ".join(map(plain_within, value, deviation))
    return within(value, deviation)


def scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else factor * value
