"""A series later by a part of a sample, band-limited, and fewer samples of it."""

from typing import Final

import numpy as np

from ehamj.arrays import Array

HALF: Final = 24
"""Samples on each side that a value between samples is made of."""
SHAPE: Final = 8.0
"""Of the Kaiser window about them: 80 dB."""
EPSILON: Final = 1e-3
"""Part of a sample by which the derivative in the delay is differenced."""


def later(values: Array, samples: float) -> Array:
    """A series that comes ``samples`` later, (n,); within `HALF` and the delay of its ends it is not itself."""
    whole = int(np.floor(samples))
    part = samples - whole
    found = np.convolve(values, _kernel(part), mode="same") if part else values
    return np.roll(found, whole)


def later_slope(values: Array, samples: float) -> Array:
    """Derivative of `later` in the delay, per sample, (n,)."""
    whole = int(np.floor(samples))
    part = samples - whole
    kernel = (_kernel(part + EPSILON) - _kernel(part - EPSILON)) / (2.0 * EPSILON)
    return np.roll(np.convolve(values, kernel, mode="same"), whole)


def _kernel(part: float) -> Array:
    at = np.arange(-HALF, HALF + 1) - part
    inside = np.clip(1.0 - (at / (HALF + 1)) ** 2, 0.0, None)
    return np.asarray(np.sinc(at) * np.i0(SHAPE * np.sqrt(inside)) / np.i0(SHAPE))


def thinned(values: Array, factor: int) -> Array:
    """Each ``factor``-th sample, (m,), of what is let through below 0.8 of their highest frequency."""
    if factor == 1:
        return values
    from scipy.signal import firwin, upfirdn

    taps = firwin(2 * lost(factor) + 1, 0.9 / factor, window=("kaiser", SHAPE))
    whole = upfirdn(taps, values)
    return np.asarray(whole[lost(factor) : lost(factor) + values.size][::factor])


def lost(factor: int) -> int:
    """Samples at each end, before thinning, of which it makes nothing good."""
    return 0 if factor == 1 else 25 * factor
