"""Third-octave bands of IEC 61260-1 (base ten, G = 10^0.3) and the RMS of a signal in each of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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


def band_rms(signal: Array, rate: float, chosen: tuple[Band, ...]) -> Array:
    """RMS of a signal in each band; NaN where the record is too short or sampled too slowly for the band.

    The spectrum is one Hann-windowed periodogram of the whole record, after subtraction of the mean and linear trend;
    bins that an edge divides count by their share.

    Args:
        signal: samples, (n,) or (n, channels).
        rate: sampling rate [Hz].
        chosen: bands.

    Returns:
        (bands,) or (bands, channels), in the signal's unit.
    """
    samples = np.asarray(signal, float)
    n = samples.shape[0]
    line = np.linspace(-1.0, 1.0, n)[(...,) + (None,) * (samples.ndim - 1)]
    samples = samples - samples.mean(axis=0)
    samples = samples - line * ((line * samples).sum(axis=0) / (line * line).sum())
    window = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(n) / n)
    spectrum = np.fft.rfft(samples * window[(...,) + (None,) * (samples.ndim - 1)], axis=0)
    power = 2.0 * np.abs(spectrum) ** 2 / (n * (window**2).sum())
    resolution = rate / n
    edges = (np.arange(power.shape[0] + 1) - 0.5) * resolution
    cumulated = np.concatenate([np.zeros_like(power[:1]), np.cumsum(power, axis=0)])
    levels = np.full((len(chosen), *power.shape[1:]), np.nan)
    for row, band in enumerate(chosen):
        low, high = band.edges
        if (high - low) / resolution < LEAST_BINS or high > 0.5 * rate:
            continue
        below, above = (_interpolate(edge, edges, cumulated) for edge in (low, high))
        levels[row] = np.sqrt(np.maximum(above - below, 0.0))
    return levels


def _interpolate(at: float, edges: Array, cumulated: Array) -> Array:
    position = np.clip((at - edges[0]) / (edges[1] - edges[0]), 0, cumulated.shape[0] - 1)
    k = min(int(position), cumulated.shape[0] - 2)
    share = position - k
    return (1.0 - share) * cumulated[k] + share * cumulated[k + 1]
