"""Target spectra of floors: PSDs and third-octave levels, interpolated on log-log axes, and refused outside."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ehamj.estimate.bands import BAND_LOG_WIDTH, Band, G
from ehamj.records.units import ORDERS, Quantity
from ehamj.signals import Array

Axis = Literal["x", "y", "z"]


@dataclass(frozen=True)
class Spectrum:
    """A one-sided PSD of the velocity, known from ``low`` to ``high`` [Hz]."""

    shape: Callable[[Array], Array]
    """(m/s)²/Hz at frequencies in Hz between low and high."""
    low: float
    high: float

    def density(self, frequency: Array) -> Array:
        """PSD of the velocity [(m/s)²/Hz] at ``frequency`` [Hz], shape (n,).

        Raises:
            ValueError: at a frequency outside of the spectrum; nothing is held or extrapolated.
        """
        outside = frequency[(frequency < self.low) | (frequency > self.high)]
        if outside.size:
            raise ValueError(f"the spectrum is known from {self.low:g} to {self.high:g} Hz, not at {outside[0]:g} Hz")
        return self.shape(frequency)

    def scaled(self, factor: float) -> "Spectrum":
        """The spectrum of a motion ``factor`` times as large."""
        return Spectrum(lambda frequency: factor**2 * self.shape(frequency), self.low, self.high)

    def cut(self, first: float | None, last: float | None) -> "Spectrum":
        """The part from ``first`` to ``last`` [Hz], None: as far as it reaches.

        Raises:
            ValueError: naming ground.first or ground.last, where the spectrum does not reach so far.
        """
        for key, value in (("first", first), ("last", last)):
            if value is not None and not self.low <= value <= self.high:
                raise ValueError(
                    f"ground.{key} = {value:g} Hz must lie from {self.low:g} to {self.high:g} Hz, where "
                    "ground.target is known; nothing is extrapolated"
                )
        low, high = self.low if first is None else first, self.high if last is None else last
        if not low < high:
            raise ValueError(f"ground.first = {low:g} Hz must be below ground.last = {high:g} Hz")
        return Spectrum(self.shape, low, high)


def from_psd(frequencies: Array, density: Array, quantity: Quantity) -> Spectrum:
    """Spectrum through PSD values of ``quantity`` [(SI)²/Hz] at rising ``frequencies`` [Hz], straight on log-log axes.

    Between two points a straight line remains one in whatever quantity, since it is a power law.
    """
    order = ORDERS[quantity] - 1  # of the velocity
    log_f, log_s = np.log(frequencies), np.log(density)

    def shape(frequency: Array) -> Array:
        return np.exp(np.interp(np.log(frequency), log_f, log_s)) / (2 * np.pi * frequency) ** (2 * order)

    return Spectrum(shape, float(frequencies[0]), float(frequencies[-1]))


def from_third_octaves(numbers: Array, levels: Array, quantity: Quantity) -> Spectrum:
    """Spectrum of which every third octave has the stated RMS of ``quantity`` [SI].

    The PSD runs from band to band as a power law, and within each band it is scaled so that its integral is the level
    squared exactly. The spectrum reaches from the lower edge of the first band to the upper edge of the last.

    Args:
        numbers: rising band numbers k, whose centres are 1000·G^(k/3) Hz; bands between two of them are interpolated.
        levels: RMS in these bands [SI].
        quantity: what the levels are of.
    """
    order = ORDERS[quantity] - 1  # of the velocity
    index = np.arange(int(numbers[0]), int(numbers[-1]) + 1)
    log_level = np.interp(index, numbers, np.log(levels))
    # ln of the PSD at the centre is 2 ln L - ln f + const, so the PSD's slope α follows from the levels' slope.
    slope = 2.0 * np.diff(log_level) / BAND_LOG_WIDTH - 1.0
    below, above = np.concatenate([[-1.0], slope]), np.concatenate([slope, [-1.0]])
    half = BAND_LOG_WIDTH / 2
    centre_density = np.exp(2.0 * log_level) / np.array([Band(int(k)).centre for k in index])
    centre_density /= half * (_mean_growth(-(below + 1.0) * half) + _mean_growth((above + 1.0) * half))

    def shape(frequency: Array) -> Array:
        position = 3.0 * np.log(frequency / 1000.0) / np.log(G)
        row = np.clip(np.rint(position).astype(int) - index[0], 0, index.size - 1)
        away = (position - index[row]) * BAND_LOG_WIDTH
        density = centre_density[row] * np.exp(np.where(away < 0, below[row], above[row]) * away)
        return density / (2 * np.pi * frequency) ** (2 * order)

    return Spectrum(shape, Band(int(index[0])).edges[0], Band(int(index[-1])).edges[1])


def _mean_growth(exponent: Array) -> Array:
    """Mean of exp(u) for u from 0 to ``exponent``."""
    safe = np.where(np.abs(exponent) < 1e-9, 1.0, exponent)
    return np.where(np.abs(exponent) < 1e-9, 1.0, np.expm1(safe) / safe)
