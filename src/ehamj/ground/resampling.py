"""Where a record is resampled: on a finer grid, or on a coarser one, without a change in the band that is kept."""

from math import ceil

import numpy as np
import scipy
from numpy.typing import NDArray

from ehamj.records.channel import USABLE
from ehamj.signals import Array

DENSITY = 4
"""Least ratio of resampled to recorded rate: keeps a quintic spline within 1e-3 up to the record's usable end."""

MARGIN = 64
"""Zeros behind what is decimated, in samples of the result: the filter rings for about ten."""


def band_gain(frequency: Array, band: tuple[float, float, float, float]) -> Array:
    """Cosine flanks between the first two and the last two corners of ``band`` [Hz], shape (n,)."""
    low, rising, falling, high = band
    up = np.where(frequency >= rising, 1.0, np.clip((frequency - low) / max(rising - low, 1e-300), 0.0, 1.0))
    down = np.where(frequency <= falling, 1.0, np.clip((high - frequency) / max(high - falling, 1e-300), 0.0, 1.0))
    return np.sin(0.5 * np.pi * up) ** 2 * np.sin(0.5 * np.pi * down) ** 2


def decimated(samples: Array, factor: int) -> Array:
    """Every ``factor``-th of ``samples`` (n,), shape (ceil(n / factor),), after a filter without phase.

    The filter is one up to `USABLE` of the result's Nyquist frequency and exactly zero from that on; between them the
    flank is a cosine. Samples should begin and end near zero: they are taken to be zero outside.
    """
    if factor == 1:
        return samples
    kept = ceil(samples.size / factor)
    size = scipy.fft.next_fast_len(kept + MARGIN, real=True)
    spectrum = scipy.fft.rfft(samples, factor * size)[: size // 2 + 1]
    frequency = np.arange(spectrum.size) / (0.5 * size)  # the result's Nyquist frequency is one
    return scipy.fft.irfft(spectrum * band_gain(frequency, (0.0, 0.0, USABLE, 1.0)), size)[:kept] / factor


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
    samples = scipy.fft.irfft(split, finer * size)
    samples *= finer
    return samples, finer * rate
