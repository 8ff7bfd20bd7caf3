"""The steady part of a record: lines, fitted and taken out before anything is windowed.

A line leaks past every window's edges; one that is fitted and taken out does not. Its power is then added where it
belongs: the reshaping of lines of Thomson, Proc. IEEE 70 (1982), section XIII, here by least squares.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Final, Self

import numpy as np
from scipy.fft import prev_fast_len
from scipy.signal.windows import general_cosine

from ehamj.arrays import Array, ComplexArray
from ehamj.columns import blocks
from ehamj.estimate.counted import Counted, of_all

MOST: Final = 12
"""Lines that are taken out at most."""
TRIES: Final = 18
"""Peaks of the spectrum that are looked at."""
REACH: Final = 4
"""Half the main lobe of the window of Blackman and Harris, in frequency lines; its sidelobes are below −92 dB."""
LEFT: Final = 0.01
"""Share of the energy around that may be left where a line was: 20 dB are taken out, or it was none."""
FAINTEST: Final = 1e-10
"""Power of a line over the strongest, below which it need not be taken out: it leaks nowhere."""
WHOLE: Final = 2**22
"""Numbers of waves that are kept for the next order: 32 MiB."""
COSINES: Final = (0.35875, -0.48829, 0.14128, -0.01168)
"""Of that window (Harris, Proc. IEEE 66, 1978)."""


@dataclass(frozen=True)
class Steady:
    """Lines a·cos(2πft + φ) of one channel."""

    frequency: Array
    """[Hz], (k,)."""
    amplitude: ComplexArray
    """a·e^{jφ} at time 0, (k,)."""

    def at(self, time: Array) -> Array:
        """Sum of the lines at times [s]."""
        total = np.zeros(time.size)
        for rows in blocks(time.size):
            for f, a in zip(self.frequency, self.amplitude, strict=True):
                phase = (2 * np.pi * f) * time[rows]
                total[rows] += a.real * np.cos(phase) - a.imag * np.sin(phase)
        return total

    @property
    def power(self) -> Array:
        """Mean square of each, (k,)."""
        return np.asarray(0.5 * np.abs(self.amplitude) ** 2)


def lines_of(samples: Array, counted: Counted) -> Array:
    """Frequencies of the lines of a channel (n,) [Hz], (k,).

    Only what stands 20 dB above all around is a line, so that noise and transients stay as they are. Frequencies are
    fitted locally to the spectrum through Blackman and Harris' window, one line after the other, of second
    differences, which have no offset and no drift.
    """
    part = np.diff(samples, 2)[max(counted.first - 2, 0) :]
    part = part[-prev_fast_len(part.size, real=True) :]  # the window is next to nothing where it begins
    return np.array(_Search.of(part).run()) * counted.rate / part.size


@dataclass(frozen=True)
class Waves:
    """Cosines and sines of frequencies [Hz] (k,) over what counts, a block of samples at a time."""

    frequency: Array
    counted: Counted

    def __iter__(self) -> Iterator[tuple[slice, Array]]:
        """Which samples, and theirs, (2k, …)."""
        if 2 * self.frequency.size * (self.counted.n - self.counted.first) <= WHOLE:
            yield slice(self.counted.first, self.counted.n), self._whole
            return
        for rows in blocks(self.counted.n - self.counted.first):
            own = slice(self.counted.first + rows.start, self.counted.first + rows.stop)
            yield own, self._of(own)

    @cached_property
    def _whole(self) -> Array:
        return self._of(slice(self.counted.first, self.counted.n))

    def _of(self, rows: slice) -> Array:
        phase = 2 * np.pi * np.outer(self.frequency, np.arange(rows.start, rows.stop) / self.counted.rate)
        return np.concatenate([np.cos(phase), np.sin(phase)])


def fitted(samples: Array, base: Waves, counted: Counted) -> tuple[ComplexArray, Array]:
    """Amplitudes a·e^{jφ} at time 0 of lines in a channel (n,), (k,), and the channel without them, (n,).

    All together by least squares with the squared weights of what counts, by which lines and rest are orthogonal, and
    their energies add.

    Args:
        samples: the channel.
        base: of the lines' frequencies.
        counted: what counts of it.
    """
    if not base.frequency.size:
        return np.zeros(0, complex), samples
    size = 2 * base.frequency.size
    system, right = np.zeros((size, size)), np.zeros(size)
    for rows, own in base:
        weighted = own * counted.weight[rows] ** 2
        system += weighted @ own.T
        right += weighted @ samples[rows]
    cosines, sines = (found := np.linalg.solve(system, right)).reshape(2, -1)
    rest = samples.copy()
    for rows, own in base:
        rest[rows] -= found @ own
    return cosines - 1j * sines, rest


@dataclass
class _Search:
    """What is left of a record while one line after the other is taken out."""

    left: Array
    window: Array
    spectrum: ComplexArray

    @classmethod
    def of(cls, part: Array) -> Self:
        """Of a record as it is."""
        window = of_all(_window, part.size)(part.size)
        return cls(part, window, np.fft.rfft(part * window))

    def run(self) -> list[float]:
        """Frequencies of the lines, in lines of the spectrum; the highest peaks are looked at, as first differences."""
        m = self.left.size
        found: list[float] = []
        back = np.maximum(np.arange(self.spectrum.size), 1.0) ** -2.0
        power = np.abs(self.spectrum) ** 2 * back
        least = FAINTEST * power.max(initial=0.0)
        untried = np.ones(power.size, bool)
        untried[: REACH // 2 + 1] = untried[-REACH:] = False
        for _ in range(TRIES):
            peak = int(np.argmax(power * untried))
            if len(found) == MOST or not power[peak] * untried[peak] > least:
                break
            untried[max(peak - REACH, 0) : peak + REACH + 1] = False
            if _stands_out(power, peak) and (nu := self._take(peak, m)) is not None:
                found.append(nu)
                power = np.abs(self.spectrum) ** 2 * back
        return found

    def _take(self, peak: int, m: int) -> float | None:
        """Take a line out if it is one."""
        nu, amplitude = _fit(self.spectrum, peak, m)
        if abs(nu - peak) > 1.0:
            return None
        left = self.left.copy()
        for rows in blocks(m):
            phase = np.arange(rows.start, rows.stop) * (2 * np.pi * nu / m)
            left[rows] -= amplitude.real * np.cos(phase) - amplitude.imag * np.sin(phase)
        spectrum = np.fft.rfft(left * self.window)
        if _energy(spectrum, nu) > LEFT * _energy(self.spectrum, nu):
            return None
        self.left, self.spectrum = left, spectrum
        return nu


@lru_cache(maxsize=2)
def _window(size: int) -> Array:
    return np.asarray(general_cosine(size, np.abs(COSINES), sym=False))


def _energy(spectrum: ComplexArray, nu: float) -> float:
    """Within the main lobe about a frequency."""
    k = round(nu)
    return float((np.abs(spectrum[max(k - REACH, 0) : k + REACH + 1]) ** 2).sum())


def _stands_out(power: Array, peak: int) -> bool:
    """Whether it may be a line: what lies beside its lobe is, line by line, 20 dB below its mean there."""
    lobe = power[max(peak - REACH, 0) : peak + REACH + 1]
    beside = np.concatenate(
        [power[max(peak - 3 * REACH, 0) : max(peak - REACH, 0)], power[peak + REACH + 1 : peak + 3 * REACH + 1]]
    )
    return bool(beside.size) and float(np.median(beside)) <= LEFT * float(lobe.mean())


def _fit(spectrum: ComplexArray, peak: int, m: int) -> tuple[float, complex]:
    """Frequency [lines] and amplitude a·e^{jφ} of the line about a peak, by Gauss and Newton on its main lobe."""
    k = np.arange(max(peak - REACH, 0), min(peak + REACH + 1, spectrum.size))
    seen, nu, amplitude = spectrum[k], float(peak), 0j
    known = np.concatenate([seen.real, seen.imag])

    def columns(at: float) -> Array:
        one, other = (0.5 * _window_at(np.asarray(k + shift, float), m) for shift in (-at, at))
        pair = np.array([one + other, 1j * (one - other)]).T
        return np.concatenate([pair.real, pair.imag])

    for _ in range(8):
        here, slope = columns(nu), (columns(nu + 1e-4) - columns(nu - 1e-4)) / 2e-4
        re, im = np.linalg.lstsq(here, known, rcond=None)[0]
        amplitude = complex(re, im)
        system = np.column_stack([here, slope @ [re, im]])
        step = float(np.linalg.lstsq(system, known - here @ [re, im], rcond=None)[0][2])
        nu += float(np.clip(step, -0.5, 0.5))
        if abs(step) < 1e-12 * m:
            break
    re, im = np.linalg.lstsq(columns(nu), known, rcond=None)[0]
    amplitude = complex(re, im)
    return nu, amplitude


def _window_at(x: Array, m: int) -> ComplexArray:
    """Transform of the window, ``x`` lines away from a frequency."""
    total = np.zeros(x.shape, complex)
    for j, c in enumerate(COSINES):
        for shift in (j, -j) if j else (0,):
            total += (c if j == 0 else 0.5 * c) * _rectangle(x + shift, m)
    return total


def _rectangle(x: Array, m: int) -> ComplexArray:
    """Σ e^{−2πjxn/m} over n = 0 … m − 1."""
    small = np.abs(np.sin(np.pi * x / m)) < 1e-14
    ratio = np.sin(np.pi * x) / np.where(small, 1.0, np.sin(np.pi * x / m))
    return np.asarray(np.exp(-1j * np.pi * x * (m - 1) / m) * np.where(small, m, ratio))
