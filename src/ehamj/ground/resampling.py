"""Where a record is resampled: on a finer grid, without a change below its Nyquist frequency."""

from math import ceil

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft

from ehamj.signals import Array

DENSITY = 4
"""Least ratio of resampled to recorded rate: keeps a quintic spline within 1e-3 up to the record's usable end."""


def resampled(spectrum: NDArray[np.complex128], size: int, rate: float, least: float) -> tuple[Array, float]:
    """Samples on a finer grid and their rate [Hz], `DENSITY` times ``rate`` or more, and at least ``least``.

    Args:
        spectrum: of ``size`` samples, from `scipy.fft.rfft`, shape (size // 2 + 1,).
        size: number of samples.
        rate: their rate [Hz].
        least: least rate of the result [Hz].
    """
    finer = max(DENSITY, ceil(least / rate))
    # On a finer grid the Nyquist bin splits into a positive and a negative frequency.
    split = np.append(spectrum[:-1], 0.5 * spectrum[-1]) if size % 2 == 0 else spectrum
    return irfft(split, finer * size) * finer, finer * rate
