"""Levels over time: third-octave filters of IEC 61260-1, class 1, and what is averaged behind them.

The filters are causal: Butterworth band-passes of third order, −3 dB at the band's edges, evaluated as the analogue
prototype's H(jω) on the spectrum of the padded record. No bilinear transform warps them, and low bands are as exact as
high ones at any rate. Noise that is white in a band reads 0.2 dB more behind them than between the band's edges (the
noise bandwidth is π/3 of it), which class 1 allows (0.4 dB).

Averages are the mean square of a sliding window of 1 s, or weighted exponentially: slow (1 s) and fast (0.125 s), as in
IEC 61672-1. A band narrower than 1 Hz has nothing to tell within 1 s: there the time is 1/bandwidth, and for fast at
least that.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import Final

import numpy as np
from scipy.signal import lfilter

from ehamj.arrays import Array, ComplexArray
from ehamj.columns import Samples, blocks
from ehamj.estimate.bands import Band
from ehamj.estimate.counted import LEAST_BINS, Counted, by_column, of_all
from ehamj.estimate.reading import Reading
from ehamj.estimate.spectrum import FILLING, HIGHEST, RINGING, Spectrum
from ehamj.estimate.statistics import BandStatistic

TIMES: Final[dict[BandStatistic, float]] = {
    "max_1s": 1.0,
    "slow": 1.0,
    "fast": 0.125,
    "l10": 1.0,
    "l50": 1.0,
    "l90": 1.0,
}
"""Averaging time of each statistic that is taken behind filters [s], in bands that are at least as wide as 1/time."""
EXCEEDED: Final[dict[BandStatistic, float]] = {"l10": 10.0, "l50": 50.0, "l90": 90.0}
"""Share of the time for which a level is exceeded [%]."""
LOWEST: Final = 1.0 / 16.0
"""Over a band's centre: frequency below which its filter passes less than 100 dB, and is taken to pass nothing."""
PER_TIME: Final = 64
"""Steps per averaging time to which squares are gathered, and windows of which percentiles are taken, where they are
finer."""


def averaging_time(band: Band, statistic: BandStatistic) -> float:
    """Averaging time of a statistic in a band [s]: its own, or 1/bandwidth where that is longer."""
    return max(TIMES[statistic], 1.0 / band.width)


def least_length(band: Band, statistic: BandStatistic) -> float:
    """How long a record must count for a statistic of a band's levels to be stated [s].

    Bandwidth times time `LEAST_BINS`; behind a filter an averaging time, and for percentiles before it the time in
    which the filter fills up.
    """
    least = LEAST_BINS / band.width
    if statistic == "rms":
        return least
    filling = FILLING / band.width if statistic in EXCEEDED else 0.0
    return max(least, averaging_time(band, statistic) + filling)


def response(band: Band, frequency: Array) -> ComplexArray:
    """H(jω) of the band's filter at frequencies [Hz], (f,)."""
    low, high = band.edges
    with np.errstate(divide="ignore"):
        s = 1j * (frequency / (high - low) - low * high / (frequency * (high - low)))
        return np.asarray(1.0 / ((s + 1.0) * (s * s + s + 1.0)))


@lru_cache(maxsize=256)
def _passing(band: Band, order: int, step: float, size: int) -> ComplexArray:
    """Response of the band's filter and of the derivative at the first bins [Hz] of a spectrum of ``size`` bins."""
    first = max(int(LOWEST * band.centre / step), 1)
    count = min(size, int(np.ceil(HIGHEST * band.centre / step)) + 1)
    found = np.zeros(max(first, count), complex)
    for some in blocks(found.size - first):  # a part at a time: of a long run all at once are many times what is kept
        frequency = np.asarray(step * np.arange(first + some.start, first + some.stop))
        found[first + some.start : first + some.stop] = response(band, frequency) * (2j * np.pi * frequency) ** order
    return found


class Behind:
    """A channel behind the filter of one band: mean squares over time."""

    def __init__(self, spectrum: Spectrum, band: Band, order: int = 0) -> None:
        """The channel's derivative of ``order``, as in `Reading.rms`."""
        counted = spectrum.counted
        passing = of_all(_passing, counted.n)(band, order, counted.rate / spectrum.size, spectrum.rest.size)
        square = spectrum.filtered(passing)
        np.square(square, out=square)  # of a long run each is large
        step = spectrum.size / counted.rate / square.size
        several = max(int(averaging_time(band, "fast") / PER_TIME / step), 1)
        self.band, self.counted, self.filling = band, counted, FILLING / band.width
        self.mean_square = spectrum.mean_square(passing)
        """Over the whole run."""
        self.step = several * step
        """Time over which squares are gathered [s]."""
        rows = int((counted.end + RINGING / band.width) / self.step)
        self.square = square[: rows * several].reshape(rows, several).mean(axis=1)
        """Mean over each step, until the filter has rung out."""
        self.energy = np.zeros(self.square.size + 1)
        np.cumsum(self.square, out=self.energy[1:])
        self.energy *= self.step
        """Integral of the square from time −step/2/several, at the steps' ends."""
        self.offset = 0.5 * step

    def sliding(self, ends: Array, seconds: float) -> Array:
        """Mean squares of windows that end at times [s]."""
        at = (np.array([ends, ends - seconds]) + self.offset) / self.step
        above, below = np.interp(at, np.arange(self.energy.size), self.energy)
        return np.asarray(np.maximum(above - below, 0.0) / seconds)

    def levels(self, wanted: Sequence[BandStatistic]) -> list[float]:
        """Statistics of the levels (RMS)."""
        begin, end = self.counted.begin, self.counted.end
        found: dict[BandStatistic, float] = {}
        percentiles: dict[BandStatistic, float] = {name: EXCEEDED[name] for name in EXCEEDED if name in wanted}
        if percentiles or "max_1s" in wanted:
            seconds = averaging_time(self.band, "max_1s")
            window, last = self._windows(seconds)
            if "max_1s" in wanted:
                found["max_1s"] = float(window[max(self._row(begin + seconds) - last, 0) :].max())
            if percentiles:
                every = max(int(seconds / PER_TIME / self.step), 1)
                counts = window[self._row(begin + self.filling + seconds) - last : self._row(end) - last + 1 : every]
                shares = [100.0 - share for share in percentiles.values()]
                found.update(zip(percentiles, np.percentile(counts, shares), strict=True))
        for name in wanted:
            if name in ("slow", "fast"):
                decay = np.exp(-self.step / averaging_time(self.band, name))
                weighted = lfilter([1.0 - decay], [1.0, -decay], self.square)
                found[name] = float(weighted[self._row(begin) :].max())
        return [float(np.sqrt(max(found[name], 0.0))) for name in wanted]

    def _windows(self, seconds: float) -> tuple[Array, int]:
        """Mean square of each window that ends with a step, and where in ``energy`` the first of them ends."""
        back = seconds / self.step
        q, size = int(back), self.energy.size
        # Its beginning lies between two steps.
        below = (1.0 - back + q) * self.energy[1 : size - q] + (back - q) * self.energy[: size - q - 1]
        return (self.energy[q + 1 :] - below) / seconds, q + 1

    def _row(self, time: float) -> int:
        """The first place in ``energy`` that is not before a time [s]."""
        return int(np.ceil((time + self.offset) / self.step - 1e-6))


def statistics(
    reading: Reading, chosen: Sequence[Band], wanted: Sequence[BandStatistic], order: int = 0
) -> tuple[Array, Array]:
    """Statistics of a channel's levels over time.

    Args:
        reading: the channel.
        chosen: bands.
        wanted: statistics.
        order: of the time derivative whose levels are wanted, as in `Reading.rms`.

    Returns:
        RMS levels (statistics, bands), and RMS of the whole run behind the same filters (bands,); NaN as there.
    """
    levels, means = np.full((len(wanted), len(chosen)), np.nan), np.full(len(chosen), np.nan)
    for row, band in enumerate(chosen):
        if band in reading.spectra:
            stated = [k for k, name in enumerate(wanted) if reading.counted.length >= least_length(band, name)]
            if reading.spectra[band].silent:
                means[row], levels[stated, row] = 0.0, 0.0
                continue
            behind = Behind(reading.spectra[band], band, order)
            means[row] = np.sqrt(behind.mean_square)
            levels[stated, row] = behind.levels([wanted[k] for k in stated])
    return levels, means


def levels_over_time(signal: Samples, rate: float, chosen: tuple[Band, ...], step: float = 0.25) -> tuple[Array, Array]:
    """Sliding 1 s RMS of a signal in each band on a grid of times, as a spectrogram shows it.

    Args:
        signal: samples from time 0 on, (n,) or (n, …).
        rate: sampling rate [Hz].
        chosen: bands.
        step: between the times [s].

    Returns:
        Times (t,) [s] from when the run has settled to its end, and RMS levels (bands, t, …) of the windows that end
        there (1 s, or 1/bandwidth where that is longer); NaN where a window is not wholly within what counts, or a band
        undecided.
    """
    counted = Counted(signal.shape[0], rate)
    times = np.arange(counted.begin, counted.end + 0.5 * step, step)

    def of_one(one: Array) -> Array:
        reading, found = Reading.of(one, counted, chosen), np.full((len(chosen), times.size), np.nan)
        for row, band in enumerate(chosen):
            if band in reading.spectra:
                seconds = averaging_time(band, "max_1s")
                whole = times >= counted.begin + seconds - 1e-9
                found[row, whole] = np.sqrt(Behind(reading.spectra[band], band).sliding(times[whole], seconds))
        return found

    return times, by_column(signal, of_one)
