"""Response spectra: what oscillators of one degree of freedom make of a motion of their base.

The view of ISO/TS 10811-1 on floors below sensitive equipment: not how much the floor moves, but how strongly it drives
a part of the equipment that has its resonance there. The document's own damping, frequencies and classes were not at
hand, so these are settings, and no class is stated.

Each oscillator is a recursive filter that is exact for an acceleration that runs straight from sample to sample: the
ramp-invariant method of Smallwood (1981), which ISO 18431-4 has too. Straight lines flatten what oscillates between the
samples by sinc²: a line at a tenth of the sampling rate, the highest natural frequency taken, comes out 3 % low.
"""

from typing import NamedTuple

import numpy as np
import scipy

from ehamj.arrays import Array

HIGHEST_SHARE = 0.1
"""Highest natural frequency over the sampling rate."""


class ResponseSpectrum(NamedTuple):
    """Peak responses of oscillators, (frequencies, channels) each."""

    velocity: Array
    """Pseudo-velocity: 2πf times the peak displacement relative to the base [m/s]."""
    acceleration: Array
    """Peak absolute acceleration [m/s²]."""


def frequencies(first: float, last: float, per_octave: int) -> Array:
    """Natural frequencies from ``first`` to ``last`` [Hz], ``per_octave`` in each of IEC 61260's octaves (10^0.3)."""
    steps = 10.0 * per_octave / 3.0
    k = np.arange(np.ceil(steps * np.log10(first) - 1e-9), np.floor(steps * np.log10(last) + 1e-9) + 1)
    return np.asarray(10.0 ** (k / steps))


def oscillator(frequency: float, damping: float, rate: float) -> tuple[Array, Array]:
    """Ramp-invariant filters of an oscillator, as one second-order section each (b0, b1, b2, 1, a1, a2).

    Args:
        frequency: natural frequency of the undamped oscillator [Hz].
        damping: damping ratio [-].
        rate: sampling rate [Hz].

    Returns:
        From the base's acceleration to the displacement relative to the base [m per m/s²], and to the absolute
        acceleration [-].
    """
    omega = 2.0 * np.pi * frequency
    denominator = [1.0, 2.0 * damping * omega, omega**2]
    sections = []
    for numerator in ([-1.0], [2.0 * damping * omega, omega**2]):
        b, a, _ = scipy.signal.cont2discrete((numerator, denominator), 1.0 / rate, method="foh")
        sections.append(np.concatenate([np.ravel(b), np.ravel(a)]))
    return sections[0], sections[1]


def response_spectrum(
    acceleration: Array, rate: float, natural: Array, damping: float, begin: int = 0
) -> ResponseSpectrum:
    """Peak responses to a motion of the base, from rest.

    Args:
        acceleration: of the base, (n, channels) [m/s²].
        rate: sampling rate [Hz].
        natural: natural frequencies, up to `HIGHEST_SHARE` of the rate [Hz].
        damping: damping ratio of the oscillators [-].
        begin: first sample whose response counts; the oscillators move before.

    Raises:
        ValueError: if a natural frequency is too high for the sampling rate.
    """
    if natural.size and natural.max() > HIGHEST_SHARE * rate * (1 + 1e-9):
        raise ValueError(f"natural = {natural.max():g} Hz must be at most {HIGHEST_SHARE * rate:g} Hz, rate/10")
    base = np.ascontiguousarray(np.asarray(acceleration, float).T)
    moving = base.any(axis=1)  # what rests needs no filtering
    base = base[moving]
    velocity, absolute = np.zeros((2, natural.size, moving.size))
    for row, frequency in enumerate(natural):
        to_displacement, to_acceleration = oscillator(float(frequency), damping, rate)
        moved = scipy.signal.sosfilt(to_displacement[None], base, axis=1)[:, begin:]
        velocity[row, moving] = 2.0 * np.pi * frequency * np.abs(moved).max(axis=1)
        absolute[row, moving] = np.abs(scipy.signal.sosfilt(to_acceleration[None], base, axis=1)[:, begin:]).max(axis=1)
    return ResponseSpectrum(velocity, absolute)
