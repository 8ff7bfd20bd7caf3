"""Generic vibration criteria: workshop, office, …, VC-A to VC-G (third-octave RMS velocity; IEST-RP-CC012).

Each curve is flat from 8 to 80 Hz and of constant acceleration from 4 to 8 Hz (twice the flat value at 4 Hz). By newer
practice VC-C and stricter are flat from 1 to 80 Hz. VC-F and VC-G follow Amick et al. 2005.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ehamj.criteria.third_octave import Band, bands

Array = NDArray[np.float64]

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
}
"""Flat level of each class [m/s RMS], coarsest first."""

FLAT_FROM_1_HZ = ("VC-C", "VC-D", "VC-E", "VC-F", "VC-G")


def limit(name: str, band: Band, flat_from_1_hz: bool = False) -> float | None:
    """Limit of a class in a band [m/s RMS], None where the class says nothing.

    Args:
        name: one of `CLASSES`.
        band: third-octave band.
        flat_from_1_hz: the newer practice for VC-C and stricter.
    """
    nominal = float(band.name)
    if nominal > 80.0:
        return None
    if flat_from_1_hz and name in FLAT_FROM_1_HZ:
        return CLASSES[name] if nominal >= 1.0 else None
    if nominal >= 8.0:
        return CLASSES[name]
    return CLASSES[name] * 8.0 / nominal if nominal >= 4.0 else None


@dataclass(frozen=True)
class Verdict:
    """The strictest class met (None: not even the coarsest), and the band that forbids the next one.

    ``margin_db`` is the distance to the limit of the class met in the deciding band.
    """

    met: str | None
    deciding_band: str | None
    margin_db: float | None
    undecided: tuple[str, ...]
    """Bands of the criterion in which the level is not known."""


def judge(levels: Array, measured: tuple[Band, ...], flat_from_1_hz: bool = False) -> Verdict:
    """The class that band levels meet.

    Args:
        levels: RMS velocity per band [m/s], NaN where unknown.
        measured: the bands.
        flat_from_1_hz: see `limit`.
    """
    known = {band: float(level) for band, level in zip(measured, levels, strict=True) if np.isfinite(level)}
    met, deciding, margin = None, None, None
    for name in CLASSES:
        limits = {band: limit(name, band, flat_from_1_hz) for band in known}
        shares = {band: known[band] / allowed for band, allowed in limits.items() if allowed is not None}
        if not shares:
            break
        worst = max(shares, key=lambda band: shares[band])
        deciding = worst.name
        if shares[worst] > 1.0:
            break
        met = name
        margin = float(-20 * np.log10(shares[worst])) if shares[worst] > 0 else None
    needed = bands(1.0 if flat_from_1_hz else 4.0, 80.0)
    return Verdict(met, deciding, margin, tuple(band.name for band in needed if band not in known))
