"""Multisines of low peak, and several of them at once that share no line.

A sum of n sines of given amplitudes has any crest factor from about 1.4 to √(2n), as its phases are. Those here come
from clipping: clip the signal, keep the phases of what is left, give the lines their amplitudes back, again and again
with ever less that is clipped (E. van der Ouderaa, J. Schoukens & J. Renneboog, IEEE Trans. Instrum. Meas. 37, 1988).
Schroeder's phases, one of the beginnings, have 1.7 to 1.9 for lines in a row, and much more for others.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.arrays import Array, ComplexArray
from ehamj.errors import InputError
from ehamj.signals import Multisine, schroeder_phases

Spacing = Literal["even", "logarithmic"]
"""How lines lie in their band."""

STARTS: Final = 4
"""Beginnings: Schroeder's phases and random ones."""
ROUNDS: Final = 1000
"""Clippings of each."""
FIRST_CLIP: Final = 0.8
"""Share of the peak at which the first clipping is; the last one is at the peak."""
PER_PERIOD: Final = 8
"""Samples per period of the highest line among which peaks are looked for: they are seen to 8 % of that line."""
FINE: Final = 64
"""The same where a crest factor is stated: to 0.12 %."""


@dataclass(frozen=True)
class LowPeak:
    """Sines at ``harmonics`` of 1/``period`` [Hz], of ``amplitudes`` and ``phases`` [rad], (n,) each."""

    period: float
    """[s]"""
    harmonics: NDArray[np.int64]
    amplitudes: Array
    phases: Array

    @property
    def frequencies(self) -> Array:
        """[Hz], (n,)."""
        return np.asarray(self.harmonics / self.period)

    @property
    def peak(self) -> float:
        """Largest magnitude of the sum, in the amplitudes' unit."""
        return float(np.abs(_sum(self.amplitudes, self.harmonics, self.phases, FINE)).max())

    @property
    def crest_factor(self) -> float:
        """Peak over RMS [-]."""
        return self.peak / float(np.sqrt(0.5 * (self.amplitudes**2).sum()))

    def scaled(self, factor: float) -> "LowPeak":
        """The same, so many times as large."""
        return LowPeak(self.period, self.harmonics, factor * self.amplitudes, self.phases)

    def signal(self) -> Multisine:
        """As a signal of time."""
        return Multisine.of(self.amplitudes, self.frequencies, self.phases)

    def command(self, mounts: Sequence[str]) -> dict[str, Any]:
        """As an entry of ``control.signals`` for lines of one amplitude, phases stated [V, Hz, rad]."""
        rounded = [round(float(phase), 6) for phase in np.mod(self.phases, 2.0 * np.pi)]
        return {
            "kind": "multisine",
            "frequencies": [float(f) for f in self.frequencies],
            "amplitude": float(self.amplitudes[0]),
            "phases": rounded,
            "mounts": list(mounts),
        }


def low_peak(period: float, harmonics: ArrayLike, amplitudes: ArrayLike = 1.0, seed: int = 0) -> LowPeak:
    """Phases of low peak for lines of given amplitudes.

    Args:
        period: of the lowest possible line [s].
        harmonics: multiples of 1/period that are excited, (n,), rising, above zero.
        amplitudes: of each, or one for all.
        seed: of the random beginnings.

    Raises:
        InputError: if there is no line, or one is none.
    """
    lines = np.atleast_1d(np.asarray(harmonics))
    if lines.size == 0 or lines[0] < 1 or (np.diff(lines) < 1).any():
        raise InputError(f"harmonics = {lines.tolist()}: must be whole numbers from 1 that rise, at least one")
    size = np.broadcast_to(np.asarray(amplitudes, float), lines.shape).copy()
    starts = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, (STARTS, lines.size))
    starts[0] = schroeder_phases(lines.size)
    phases = _clipped(size, lines, starts)
    peaks = np.abs(_sum(size, lines, phases, FINE)).max(axis=-1)
    return LowPeak(period, lines, size, phases[int(np.argmin(peaks))])


def zippered(
    first: float, last: float, period: float, lines: int, channels: int, spacing: Spacing = "even"
) -> list[NDArray[np.int64]]:
    """Harmonics of 1/``period`` from ``first`` to ``last`` [Hz], dealt to channels in turn.

    No line belongs to two channels, so that signals of whole periods are orthogonal, whatever their phases.

    Args:
        first, last: band [Hz].
        period: [s].
        lines: of each channel, at most.
        channels: how many signals there are at once.
        spacing: even, of the lowest peaks; or even in logarithm.

    Raises:
        InputError: if the band has not a line for each channel.
    """
    low, high = max(1, math.ceil(first * period - 1e-9)), math.floor(last * period + 1e-9)
    there = max(0, high - low + 1)
    if there < channels:
        raise InputError(
            f"band = [{first:g}, {last:g}] Hz: has {there} lines 1/{period:g} s apart, and {channels} signals need one "
            "each; make the band wider or the period longer"
        )
    wanted = min(lines * channels, there)
    if spacing == "even":
        step = max(1, math.ceil((high - low) / max(wanted - 1, 1)))
        step = step if (high - low) // step + 1 >= channels else 1
        grid = np.arange(low, high + 1, step)[:wanted]
    else:
        grid = np.unique(np.round(np.geomspace(low, high, wanted))).astype(np.int64)
        grid = grid if grid.size >= channels else low + np.arange(channels)
    return [grid[k::channels] for k in range(channels)]


def _sum(amplitudes: Array, harmonics: NDArray[np.int64], phases: Array, per_period: int) -> Array:
    """One period of the sums, (…, sample), of phases (…, n)."""
    size = _samples(harmonics, per_period)
    spectrum = np.zeros((*phases.shape[:-1], size // 2 + 1), complex)
    spectrum[..., harmonics] = -0.5j * size * amplitudes * np.exp(1j * phases)
    return np.asarray(np.fft.irfft(spectrum, size, axis=-1))


def _samples(harmonics: NDArray[np.int64], per_period: int) -> int:
    """Samples of a period, a power of two."""
    return int(2 ** np.ceil(np.log2(per_period * int(harmonics[-1]))))


def _clipped(amplitudes: Array, harmonics: NDArray[np.int64], phases: Array) -> Array:
    """Phases after all rounds, each beginning's best, (start, n)."""
    best, least = phases.copy(), np.full(len(phases), np.inf)
    for level in np.linspace(FIRST_CLIP, 1.0, ROUNDS):
        signal = _sum(amplitudes, harmonics, phases, PER_PERIOD)
        peak = np.abs(signal).max(axis=-1)
        better = peak < least
        best[better], least[better] = phases[better], peak[better]
        limit = (level * peak)[:, None]
        lines: ComplexArray = np.fft.rfft(np.clip(signal, -limit, limit), axis=-1)[:, harmonics]
        phases = np.angle(1j * lines)
    return best
