"""NIST-A: 0.025 µm RMS from 1 to 20 Hz, then 3.12 µm/s RMS to 100 Hz, per third-octave band and axis.

Developed for the advanced measurement laboratory in Gaithersburg (Amick, Gendreau, Busch and Gordon 2005, "Evolving
criteria for research facilities: vibration"). The numbers are those that the field quotes from there; the paper itself
was not at hand to check them. Up to 20 Hz the limit is one of displacement: a line anywhere in a band counts by its own
displacement, not by that of the band's centre. The two limits meet at 19.9 Hz.
"""

from ehamj.criteria.curves import Limit, Norm
from ehamj.estimate.bands import Band

DISPLACEMENT = 0.025e-6
"""Limit from 1 to 20 Hz [m RMS]."""

VELOCITY = 3.12e-6
"""Limit from 25 to 100 Hz [m/s RMS]."""


def _rule(name: str, axis: str, band: Band) -> Limit | None:
    if 1.0 <= band.nominal <= 20.0:
        return Limit(DISPLACEMENT, "displacement")
    return Limit(VELOCITY) if 20.0 < band.nominal <= 100.0 else None


NIST_A = Norm(
    "NIST-A",
    ("NIST-A",),
    _rule,
    note="Up to 20 Hz the limit is one of displacement, 0.025 µm: levels there are displacements, drawn as the "
    "velocity that they have at the band's centre.",
)
