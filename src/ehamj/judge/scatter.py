"""How far chance alone may move the level of a band: the scatter of an estimate from one run."""

from typing import Final

import numpy as np

from ehamj.estimate.sliding import averaging_time
from ehamj.findings import finite
from ehamj.judge.levels import Levels
from ehamj.plant.axes import AXES

DEVIATIONS: Final = 2.0
"""Standard deviations that count as scatter: 95 of 100 estimates lie within."""
DECILES: Final = 2.563
"""Between the levels exceeded for 10 and for 90 % of the time, in standard deviations of a normal distribution."""
STATIONARY: Final = 2.0
"""Spread of the windows' mean squares, over that of white noise in the band, above which noise is not stationary."""


def scatter(levels: Levels, place: str, mount: int | None, axis: str, band: str | None) -> float | None:
    """By how much the RMS of a whole run may differ from that of a longer one, two standard deviations [dB].

    The run's mean square is the mean of those of its windows, T/τ of them that do not overlap (τ: 1 s, or 1/bandwidth
    where that is longer). Their spread is read from the levels exceeded for 10 and 90 % of the time, taken as those of
    a normal distribution: for stationary noise this gives 1/√(bandwidth · T) of the mean square, for a steady line 0.

    None where the levels over time are not known, and of peaks.
    """
    row = levels.row(band)
    if row is None:
        return None
    at = (row, *(() if mount is None else (mount,)), AXES.index(axis))
    rms, high, low = (float(levels.places[place]["velocity", name][at]) for name in ("rms", "l10", "l90"))
    if not rms > 0.0 or levels.seconds <= 0.0:
        return None
    spread = (high**2 - low**2) / DECILES / rms**2
    time = averaging_time(levels.bands[row], "max_1s")
    if not spread <= STATIONARY / np.sqrt(levels.bands[row].width * time):
        return None
    return finite(DEVIATIONS * 10.0 / np.log(10.0) * spread / np.sqrt(levels.seconds / time))
