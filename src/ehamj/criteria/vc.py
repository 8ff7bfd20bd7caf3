"""Generic vibration criteria: workshop, office, …, VC-A to VC-M (third-octave RMS velocity; IEST-RP-CC012).

Each curve is flat from 8 to 80 Hz and of constant acceleration from 4 to 8 Hz (twice the flat value at 4 Hz): the
classic practice. By newer practice VC-C and stricter are flat from 1 to 80 Hz. VC-F and VC-G follow Amick et al. 2005.
All three axes have the same limits.

VC-H to VC-M are extensions that the field uses to describe very quiet places, not to specify them: each is half of the
one above ("VC-H to VC-M were introduced for evaluation purposes", Controlled Environments 2018). No print of their
limits was at hand; the numbers are the halves of 0.78 µm/s, cut as the field writes the ones before.
"""

from typing import Literal

from ehamj.criteria.curves import Limit, Norm, rounded
from ehamj.estimate.bands import Band

LowFrequency = Literal["classic", "flat"]

CLASSES: dict[str, float] = {
    "workshop": 800e-6,
    "office": 400e-6,
    "residential": 200e-6,
    "operating theatre": 100e-6,
    "VC-A": 50e-6,
    "VC-B": 25e-6,
    "VC-C": 12.5e-6,
    "VC-D": 6.25e-6,
    "VC-E": 3.12e-6,
    "VC-F": 1.56e-6,
    "VC-G": 0.78e-6,
    "VC-H": 0.39e-6,
    "VC-I": 0.195e-6,
    "VC-J": 0.097e-6,
    "VC-K": 0.048e-6,
    "VC-L": 0.024e-6,
    "VC-M": 0.012e-6,
}
"""Flat level of each class [m/s RMS], coarsest first."""

EXTENDED = (
    "VC-H to VC-M are no published curves but halvings of VC-G, 0.78 µm/s, and of each other, by which very quiet "
    "places are described, not specified."
)
"""What to know of the strictest classes."""

FLAT_FROM_1_HZ = tuple(CLASSES)[tuple(CLASSES).index("VC-C") :]


def limit(name: str, band: Band, flat_from_1_hz: bool = False) -> float | None:
    """Limit of a class in a band [m/s RMS], None where the class says nothing.

    Args:
        name: one of `CLASSES`.
        band: third-octave band.
        flat_from_1_hz: the newer practice for VC-C and stricter.
    """
    nominal = band.nominal
    if nominal > 80.0:
        return None
    if flat_from_1_hz and name in FLAT_FROM_1_HZ:
        return CLASSES[name] if nominal >= 1.0 else None
    if nominal >= 8.0:
        return CLASSES[name]
    return rounded(CLASSES[name] * 8.0 / nominal) if nominal >= 4.0 else None


def _norm(practice: LowFrequency, below: str, practices: dict[str, Norm]) -> Norm:
    def rule(name: str, axis: str, band: Band) -> Limit | None:
        value = limit(name, band, practice == "flat")
        return None if value is None else Limit(value)

    return Norm(f"VC curves, {below}", tuple(CLASSES), rule, practices=practices)


FLAT = _norm("flat", "VC-C and stricter from 1 Hz", {})
"""By newer practice."""
CLASSIC = _norm("classic", "constant acceleration from 4 to 8 Hz", {"flat": FLAT})
"""By the classic practice."""
