"""Hann-windowed periodogram of a whole record, and the RMS of a signal in frequency bands."""

from dataclasses import dataclass, field
from typing import Final, Self

import numpy as np
from scipy.signal import periodogram

from ehamj.arrays import Array
from ehamj.estimate.bands import Band

LEAST_BINS: Final = 4
"""Frequency lines that a band must hold for its RMS to be stated."""


@dataclass(frozen=True)
class PowerSpectrum:
    """Hann-windowed periodogram of a whole record, after subtraction of its mean and linear trend.

    ``power`` is the mean square per line, (lines, channels); lines lie ``resolution`` [Hz] apart, from 0 to half the
    ``rate`` [Hz].
    """

    power: Array = field(repr=False)
    resolution: float
    rate: float

    @classmethod
    def of(cls, signal: Array, rate: float) -> Self:
        """Spectrum of samples (n, channels) at ``rate`` [Hz]."""
        samples = np.asarray(signal, float)
        resolution = rate / samples.shape[0]
        _, density = periodogram(samples, rate, "hann", detrend="linear", axis=0)
        return cls(density * resolution, resolution, rate)

    def band_rms(self, chosen: tuple[Band, ...], order: int = 0, least_bins: float = LEAST_BINS) -> Array:
        """RMS in each band (bands, channels); bins that an edge divides count by their share.

        NaN where the record is too short or sampled too slowly for the band.

        Args:
            chosen: bands.
            order: of the time derivative whose level is wanted: 1 gives acceleration from velocity, −1 displacement.
            least_bins: lines that a band must hold; fewer give a rougher level for shorter records.
        """
        power = self.power
        if order:
            frequency = np.arange(power.shape[0]) * self.resolution
            frequency[0] = np.inf if order < 0 else 0.0
            power = power * ((2 * np.pi * frequency) ** (2 * order))[:, None]
        edges = (np.arange(power.shape[0] + 1) - 0.5) * self.resolution
        cumulated = np.concatenate([np.zeros_like(power[:1]), np.cumsum(power, axis=0)])
        levels = np.full((len(chosen), power.shape[1]), np.nan)
        for row, band in enumerate(chosen):
            low, high = band.edges
            if (high - low) / self.resolution < least_bins or high > 0.5 * self.rate:
                continue
            below, above = (_interpolate(edge, edges, cumulated) for edge in (low, high))
            levels[row] = np.sqrt(np.maximum(above - below, 0.0))
        return levels


def band_rms(signal: Array, rate: float, chosen: tuple[Band, ...], order: int = 0) -> Array:
    """RMS of a signal, or of its derivative or integral, in each band; see `PowerSpectrum.band_rms`.

    Args:
        signal: samples, (n,) or (n, channels).
        rate: sampling rate [Hz].
        chosen: bands.
        order: of the time derivative.

    Returns:
        (bands,) or (bands, channels), in the signal's unit (times 1/s to the power of ``order``).
    """
    samples = np.asarray(signal, float)
    levels = PowerSpectrum.of(samples.reshape(samples.shape[0], -1), rate).band_rms(chosen, order)
    return levels.reshape(len(chosen), *samples.shape[1:])


def _interpolate(at: float, edges: Array, cumulated: Array) -> Array:
    position = np.clip((at - edges[0]) / (edges[1] - edges[0]), 0, cumulated.shape[0] - 1)
    k = min(int(position), cumulated.shape[0] - 2)
    share = position - k
    return (1.0 - share) * cumulated[k] + share * cumulated[k + 1]
