"""The spectrum of all that counts of a run, and the RMS that it has in bands and behind filters."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Final, Self

import numpy as np
from scipy.fft import irfft, next_fast_len, rfft

from ehamj.arrays import Array, ComplexArray
from ehamj.columns import blocks
from ehamj.estimate.bands import Band
from ehamj.estimate.counted import LEAST_BINS, LONG, Counted, forget_plans
from ehamj.estimate.steady import Steady, Waves, fitted
from ehamj.signals import rise

RINGING: Final = 2.0
"""For how long a filter of unit bandwidth [Hz] still passes on what came in last [s]."""
FILLING: Final = 1.0
"""For how long it fills up [s]."""
HIGHEST: Final = 3.0
"""Over a band's centre: frequency beyond which its filter passes less than 60 dB, and is taken to pass nothing."""
FADE: Final = 2.0
"""Time in which what is steady fades behind the record's end, and comes again before its beginning [s]."""


@dataclass(frozen=True)
class Spectrum:
    """Lines of one channel that were taken out, and the spectrum of the weighted rest, padded with zeros."""

    counted: Counted
    steady: Steady
    size: int
    """Samples with the padding."""
    rest: ComplexArray = field(repr=False)
    """Spectrum of the weighted rest, as far as bands and their filters need it, (bins,)."""

    @classmethod
    def of(
        cls, samples: Array, lines: Array, base: Waves, counted: Counted, padded: tuple[int, int], order: int
    ) -> Self:
        """Of the samples (n,) of one channel, taken by its differences of an ``order``.

        Lines [Hz], with their waves as ``base``, are fitted and weights set in the differences, whose transform is
        then taken back. ``padded``: size of the padded record, and bins kept of its spectrum.
        """
        differences = np.diff(samples, order, prepend=np.full(order, samples[0])) if order else samples
        if order > 1:
            differences[:order] = 0.0
        amplitude, rest = fitted(differences, base, counted)
        size, bins = padded
        weighted = np.zeros(size)
        np.multiply(rest, counted.weight, out=weighted[: counted.n])
        del differences, rest  # of a long run each is large
        spectrum = rfft(weighted, overwrite_x=True)[:bins].copy()  # the others need not stay
        del weighted
        spectrum[0] = 0.0
        if counted.n <= LONG:
            spectrum[1:] *= _back(size, bins, order)
        else:  # a part at a time, which takes no memory
            for some in blocks(bins - 1) if order else ():
                own = slice(1 + some.start, 1 + some.stop)
                spectrum[own] *= _back_at(own, size, order)
        return cls(counted, Steady(lines, amplitude / _difference(lines / counted.rate, order)), size, spectrum)

    @cached_property
    def frequency(self) -> Array:
        """Of the spectrum [Hz]."""
        return np.asarray((self.counted.rate / self.size) * np.arange(self.rest.size))

    @cached_property
    def silent(self) -> bool:
        """Whether nothing moves."""
        return not (self.rest.any() or self.steady.frequency.size)

    @cached_property
    def power(self) -> Array:
        """Mean square of the rest in each bin of the spectrum."""
        factor = np.full(self.rest.size, 2.0)
        factor[0] = 1.0
        factor[self.size // 2 + self.size % 2 :] = 1.0
        return factor * np.abs(self.rest) ** 2 / (self.size * self.counted.seconds * self.counted.rate)

    @cached_property
    def whole(self) -> ComplexArray:
        """Spectrum of rest and lines, these going on steadily beyond both ends."""
        if not self.steady.frequency.size:
            return self.rest
        rate, n = self.counted.rate, self.counted.n
        since = np.arange(self.size - n) / rate  # the end
        until = (self.size - n - np.arange(self.size - n)) / rate  # the beginning, once round
        hold = (self.size - n) / rate - FADE
        after, before = hold * RINGING / (RINGING + FILLING), hold * FILLING / (RINGING + FILLING)
        fade_out = 1.0 - rise((since - after) / (0.5 * FADE)).value
        fade_in = 1.0 - rise((until - before) / (0.5 * FADE)).value
        beyond = fade_out * self.steady.at((n + np.arange(self.size - n)) / rate)
        beyond += fade_in * self.steady.at(-until)
        steady = np.empty(self.size)
        steady[n:] = beyond
        for rows in blocks(n):
            steady[rows] = self.steady.at(np.arange(rows.start, rows.stop) / rate)
        return np.asarray(self.rest + rfft(steady, overwrite_x=True)[: self.rest.size])

    def rms(self, chosen: Sequence[Band], order: int = 0, least_bins: float = LEAST_BINS) -> Array:
        """RMS of the whole run in each band, (bands,); bins and lines that an edge divides count by their share.

        NaN where the record is too short or sampled too slowly for the band.

        Args:
            chosen: bands.
            order: of the time derivative whose level is wanted: 1 gives acceleration from velocity, −1 displacement.
            least_bins: see `Counted.decides`; fewer give a rougher level for shorter records.
        """
        step = self.counted.rate / self.size
        edges = np.array([band.edges for band in chosen])
        first, last = (int(edge / step) for edge in (0.5 * edges.min(), edges.max()))
        power, lines = self.power[first : last + 2], self.steady.power
        if order:
            power = power * (2 * np.pi * self.frequency[first : last + 2]) ** (2 * order)
            lines = lines * (2 * np.pi * self.steady.frequency) ** (2 * order)
        cumulated = np.concatenate([[0.0], np.cumsum(power)])
        within = np.interp(edges / step - first + 0.5, np.arange(cumulated.size), cumulated)
        # A line is as wide as the record resolves.
        apart = (edges[:, :, None] - self.steady.frequency) * self.counted.length
        within += np.clip(apart + 0.5, 0.0, 1.0) @ lines
        levels = np.sqrt(np.maximum(within[:, 1] - within[:, 0], 0.0))
        return np.where([self.counted.decides(band, least_bins) for band in chosen], levels, np.nan)

    def filtered(self, response: ComplexArray) -> Array:
        """The channel behind a filter, as ``response`` (k,) begins its frequency response at the spectrum's bins.

        Beyond the k bins it passes nothing.

        Returns:
            (m,), evenly from time 0 over the padded record, at a rate that k bins need.
        """
        k = response.size
        m = self.size if k > self.size // 2 else next_fast_len(2 * k, real=True)
        passed = np.zeros(max(m // 2 + 1, k), complex)
        np.multiply(self.whole[:k], response, out=passed[:k])
        found = np.asarray(irfft(passed, m, overwrite_x=True))
        found *= m / self.size
        forget_plans(self.counted.n)
        return found

    def mean_square(self, response: ComplexArray) -> float:
        """Of the channel behind such a filter, over the whole run."""
        gain = response.real**2 + response.imag**2
        passed = float(self.power[: response.size] @ gain)
        of_lines = np.interp(self.steady.frequency, self.frequency[: response.size], gain, right=0.0)
        return passed + float(self.steady.power @ of_lines)


@lru_cache(maxsize=3)
def _back(size: int, bins: int, order: int) -> ComplexArray:
    """From the spectrum of differences to that of the signal, at the bins above 0 Hz."""
    return _back_at(slice(1, bins), size, order)


def _back_at(bins: slice, size: int, order: int) -> ComplexArray:
    return np.asarray(1.0 / _difference(np.arange(bins.start, bins.stop) / size, order))


def _difference(frequency: Array, order: int) -> ComplexArray:
    """Transform of differences of an order, at frequencies over the sampling rate."""
    return np.asarray((1.0 - np.exp(-2j * np.pi * frequency)) ** order)
