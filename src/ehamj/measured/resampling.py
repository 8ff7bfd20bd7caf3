"""Samples of one clock on another, band-limited: a Kaiser-windowed sinc."""

from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.records.channel import USABLE

CROSSINGS: Final = 32
"""Zeros of the sinc on each side."""
BETA: Final = 7.857
"""Of the window, for 80 dB (Oppenheim and Schafer, Discrete-Time Signal Processing, 7.6)."""
CUTOFF: Final = 0.92
"""Of the lower Nyquist frequency, where half is left: all of it up to `USABLE`, within 1e-4, and nothing above one."""
CHUNK: Final = 2**22
"""Weights that are held at once."""


def resampled(samples: Array, rate: float, times: Array, to: float) -> Array:
    """Samples (n,) at k/``rate`` at other ``times`` [s], (m,), which follow each other at ``to`` [Hz].

    It is right up to `USABLE` times half the lower rate, and has nothing above half of it. At the ends, where the
    window reaches beyond what was sampled, what is there counts for all; a constant stays itself.
    """
    cut = CUTOFF * min(rate, to) / 2.0
    reach = CROSSINGS / (2.0 * cut) * rate
    beside = np.arange(-int(reach), int(reach) + 2)
    found = np.empty(times.size)
    for part in range(0, times.size, max(1, CHUNK // beside.size)):
        at = times[part : part + max(1, CHUNK // beside.size)] * rate
        index = np.floor(at).astype(np.int64)[:, None] + beside
        apart = at[:, None] - index
        inside = (index >= 0) & (index < samples.size) & (np.abs(apart) < reach)
        window = np.i0(BETA * np.sqrt(np.clip(1.0 - (apart / reach) ** 2, 0.0, None)))
        weights = np.where(inside, np.sinc(2.0 * cut / rate * apart) * window, 0.0)
        taken = samples[np.clip(index, 0, samples.size - 1)]
        found[part : part + at.size] = (weights * taken).sum(axis=1) / weights.sum(axis=1)
    return found


def usable_to(rate: float) -> float:
    """Frequency up to which what is sampled at ``rate`` is believed [Hz]."""
    return USABLE * rate / 2.0
