"""How one signal goes with another that should be the same: gain, sign and delay, whatever noise is in them."""

from typing import NamedTuple

import numpy as np
import scipy

from ehamj.arrays import Array


class Likeness(NamedTuple):
    """What leads from one signal to another: other(t) ≈ gain · one(t − delay) + a constant."""

    gain: float
    """Negative where it is the other way round [-]."""
    delay: float
    """By which the other comes later [s]."""
    correlation: float
    """Size of the correlation at that delay, from 0 to 1 [-]."""
    undelayed: float
    """Correlation without delay, −1 to 1 [-]."""


def likeness(one: Array, other: Array, rate: float, within: float) -> Likeness:
    """Of two signals (n,) at ``rate`` [Hz], by their cross-correlation at delays up to ``within`` [s].

    The delay is found to a fraction of a sample (a parabola through the peak); of signals that repeat, such as a sine,
    it is known up to the period only. Where one of them never changes, all is 0.
    """
    a, b = one - one.mean(), other - other.mean()
    energy = float(a @ a), float(b @ b)
    if not min(energy) > 0.0:
        return Likeness(0.0, 0.0, 0.0, 0.0)
    size = scipy.fft.next_fast_len(2 * a.size, real=True)
    spectrum = scipy.fft.rfft(b, size) * scipy.fft.rfft(a, size).conj()
    reach = max(1, min(a.size - 2, round(within * rate)))
    lags = np.arange(-reach, reach + 1)
    # Of lags at which less overlaps no more is asked: each is over the energy of all.
    products = scipy.fft.irfft(spectrum, size)[lags]
    peak = int(np.argmax(np.abs(products)))
    at = float(lags[peak])
    height = float(products[peak])
    if 0 < peak < lags.size - 1:
        before, after = float(products[peak - 1]), float(products[peak + 1])
        bend = before - 2.0 * height + after
        if bend != 0.0:
            shift = 0.5 * (before - after) / bend
            at, height = at + shift, height - 0.25 * (before - after) * shift
    norm = float(np.sqrt(energy[0] * energy[1]))
    return Likeness(height / energy[0], at / rate, min(1.0, abs(height) / norm), float(products[reach]) / norm)
