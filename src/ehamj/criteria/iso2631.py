"""Base curves of human perception, as ISO 2631-2:1989 and BS 6472:1992 had them and ISO 10137 still uses them.

RMS acceleration per third-octave band. Vertical: 10 mm/s² at 1 Hz falling with √f to 5 mm/s² at 4 Hz, constant to 8 Hz,
then rising with f (constant velocity, 0.0995 mm/s). Horizontal: 3.6 mm/s² from 1 to 2 Hz, then rising with f
(0.286 mm/s). A class is a multiple of the base curve. The edition of 2003 replaced the curves by a weighted level and
states no limits.

The norms themselves were not at hand: curves and factors are those that textbooks print. One check is possible: above
8 Hz the vertical curves times 1, 2, 4 and 8 are the coarse classes of the VC curves (100, 200, 400, 800 µm/s) to 1 %.
"""

from ehamj.criteria.curves import Limit, Norm, rounded
from ehamj.estimate.bands import Band

FACTORS: dict[str, float] = {
    "workshop": 8.0,
    "office": 4.0,
    "residential by day": 2.0,
    "residential by night": 1.4,
    "critical working area": 1.0,
}
"""Multiple of the base curve of each class, coarsest first (continuous vibration; by day 2 to 4, here the stricter)."""

BASE = "critical working area"


def base_curve(axis: str, band: Band) -> float | None:
    """The base curve [m/s² RMS] along an axis (x, y, z) in a band, None outside 1 to 80 Hz."""
    f = band.nominal
    if not 1.0 <= f <= 80.0:
        return None
    if axis == "z":
        return rounded(5e-3 * max((4.0 / f) ** 0.5, 1.0, f / 8.0))
    return rounded(3.6e-3 * max(1.0, f / 2.0))


def _rule(name: str, axis: str, band: Band) -> Limit | None:
    base = base_curve(axis, band)
    return None if base is None else Limit(rounded(FACTORS[name] * base), "acceleration")


MARKS = {name: f"×\u202f{factor:g}" for name, factor in FACTORS.items()}

ISO_2631_2 = Norm(
    "ISO 2631-2 (1989) base curves",
    tuple(FACTORS),
    _rule,
    base=BASE,
    note="Accelerations, drawn as the velocity that they have at the band's centre. Multiples of the base curve: "
    f"{', '.join(f'{mark} {name}' for name, mark in MARKS.items())}.",
    marks=MARKS,
)
