"""Where isolation begins on floors that ask for more voltage than there is.

Below c (7 Hz, `ehamj.control.inverse`) the command grows as 1/f, so that most of the voltage goes into the lowest
bands. A machine that follows the floor there, x = N(s)·x_g, needs W = 1 − N of it. No causal N can be one below and
zero just above; this one was chosen (differential evolution over six poles and four zeros) for a floor that is flat
from 1 to 80 Hz: least voltage for −27 dB from ``f`` = 5 Hz on, W ≤ 0.8 below 1 Hz, no band amplified. It needs
3.7 V RMS on a VC-A floor, where full isolation needs 5.9; an unlimited causal filter (Wiener) would need 3.4 V.
"""

import numpy as np
from numpy.typing import NDArray

from ehamj.control.blocks import Block, added

FROM: float = 5.0
"""Frequency that the roots below are for [Hz]; they scale with the one asked for."""

DC_GAIN = 0.3705
REAL_ZERO = 1.0 / 7.9947
POLES = ((0.7782, 0.0651), (0.347, 0.6255), (1.346, 1.1258))
ZEROS = ((0.9782, 0.0453), (1.4365, 0.4419))
"""Frequency over ``FROM`` and damping ratio of each pair."""


def yielding(frequency: float) -> Block:
    """N: motion of the machine over the floor's, for isolation that begins at ``frequency`` [Hz]."""
    unit = 2.0 * np.pi * frequency
    poles, zeros = _roots(POLES), np.append(_roots(ZEROS), -REAL_ZERO)
    gain = DC_GAIN * np.prod(poles) / np.prod(zeros) * (-1.0) ** (poles.size - zeros.size)
    return Block.filter(unit * zeros, unit * poles, float(gain.real) * unit ** (poles.size - zeros.size))


def isolating(frequency: float) -> Block:
    """W = 1 − N."""
    return added([Block.gain([[1.0]]), yielding(frequency).times(-1.0)])


def _roots(pairs: tuple[tuple[float, float], ...]) -> NDArray[np.complex128]:
    return np.concatenate([np.roots([1.0, 2.0 * damping * omega, omega**2]) for omega, damping in pairs])
