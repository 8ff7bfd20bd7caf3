"""A series later by a part of a sample, band-limited, and fewer samples of it."""

from typing import Final

import numpy as np

from ehamj.arrays import Array

HALF: Final = 24
"""Samples on each side that a value between samples is made of."""
SHAPE: Final = 8.0
"""Of the Kaiser window about them: 80 dB."""
ROLL: Final = 0.25
"""Share of the highest frequency of thinned samples about it over which their filter goes from all to nothing."""
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
    """Each ``factor``-th sample, (m,), of what is let through up to 1 − `ROLL` of their highest frequency.

    What lies beyond, up to 1 + `ROLL` of it, folds, so that white noise stays white (a root of a Nyquist filter, as
    receivers of data have it): one that lets nothing fold takes from noise what lies there, and all that is measured
    would seem coloured. Measured and predicted fold alike.
    """
    if factor == 1:
        return values
    from scipy.signal import upfirdn

    whole = upfirdn(_root_of_nyquist(factor), values)
    return np.asarray(whole[lost(factor) : lost(factor) + values.size][::factor])


def _root_of_nyquist(factor: int) -> Array:
    """Taps of a root-raised cosine, of gain one (Proakis, Digital Communications, 9.2)."""
    at = np.arange(-lost(factor), lost(factor) + 1) / factor
    edge = np.isclose(np.abs(at), 1.0 / (4.0 * ROLL))
    inner = np.where(edge | (at == 0.0), 0.5, at)
    turn = np.pi * inner
    taps = np.sin(turn * (1.0 - ROLL)) + 4.0 * ROLL * inner * np.cos(turn * (1.0 + ROLL))
    taps /= turn * (1.0 - (4.0 * ROLL * inner) ** 2)
    taps[at == 0.0] = 1.0 - ROLL + 4.0 * ROLL / np.pi
    angle = np.pi / (4.0 * ROLL)
    taps[edge] = ROLL / np.sqrt(2.0) * ((1.0 + 2.0 / np.pi) * np.sin(angle) + (1.0 - 2.0 / np.pi) * np.cos(angle))
    return np.asarray(taps / taps.sum())


def lost(factor: int) -> int:
    """Samples at each end, before thinning, of which it makes nothing good."""
    return 0 if factor == 1 else 25 * factor
