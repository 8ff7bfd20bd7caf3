"""Third-octave bands of IEC 61260-1 (base ten, G = 10^0.3) and the RMS of a signal in each of them."""

from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.fft import rfft

Array = NDArray[np.float64]

G = 10.0**0.3
BAND_LOG_WIDTH = float(np.log(G) / 3)
"""ln of the ratio of a band's edges; a PSD of L²/(BAND_LOG_WIDTH·f) has the RMS L in every band."""

NOMINAL = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)
LEAST_BINS = 4
"""Frequency lines that a band must hold for its RMS to be stated."""


@dataclass(frozen=True)
class Band:
    """One band: exact centre f_m and edges f_m·G^(±1/6) [Hz]."""

    index: int

    @property
    def centre(self) -> float:
        """Exact mid-band frequency, 1000·G^(k/3) [Hz]."""
        return float(1000.0 * G ** (self.index / 3))

    @property
    def nominal(self) -> float:
        """Nominal centre frequency, as norms print their limits [Hz]."""
        return float(self.name)

    @property
    def edges(self) -> tuple[float, float]:
        """Lower and upper edge [Hz]."""
        return self.centre * G ** (-1 / 6), self.centre * G ** (1 / 6)

    @property
    def name(self) -> str:
        """Nominal centre frequency as people write it, in Hz: '31.5'."""
        decade, place = divmod(self.index, 10)
        value = NOMINAL[place] * 10.0 ** (decade + 3)
        return np.format_float_positional(value, precision=3, fractional=False, trim="-")


def bands(first: float, last: float) -> tuple[Band, ...]:
    """The bands whose nominal centres lie from ``first`` to ``last`` [Hz]."""
    low, high = (round(10.0 * np.log10(f / 1000.0)) for f in (first, last))
    return tuple(Band(k) for k in range(int(low), int(high) + 1))


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
        samples = np.ascontiguousarray(np.asarray(signal, float).T)
        n = samples.shape[1]
        line = np.linspace(-1.0, 1.0, n)
        samples = samples - samples.mean(axis=1, keepdims=True)
        samples -= np.outer((samples @ line) / (line @ line), line)
        window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n) / n)
        samples *= window
        spectrum = rfft(samples, axis=1)
        power = 2.0 * (spectrum.real**2 + spectrum.imag**2) / (n * (window**2).sum())
        return cls(power.T, rate / n, rate)

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
