"""The grid of a sum of lines, which the signal passes through: whole where it is short, else a block at a time.

A block is a window of the grid, got by gridding (the transform of points that are not on a uniform grid): the lines,
which are closer to each other than what a window resolves, are spread to the frequencies of a window's own FFT with a
Kaiser-Bessel kernel, and the kernel's transform is divided out of what the FFT gives (Jackson et al., *Selection of a
convolution function for Fourier inversion using gridding*, IEEE Trans. Med. Imaging 10 (1991), 473-478). With an FFT
`AMPLE` times as long as the window and a kernel `WIDTH` wide it agrees with the FFT over the whole grid to 1e-13 of the
RMS. Memory is that of the blocks; time is that of spreading all lines for each of them.
"""

from functools import lru_cache
from itertools import count
from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.series.held import BLOCK, Held, OnDisk, Recent, is_whole

LINE_SAMPLES: Final = 8
"""Samples per period of the highest line; a quintic between them is then within 5e-6 of that line."""

AMPLE: Final = 3
"""Length of a block's FFT over its window: so ample that the kernel's transform is flat within it, and dividing by that
makes no rounding larger."""

WIDTH: Final = 14
"""Width of the kernel in frequencies of that FFT: what it leaves of a window's images is exp(−π·WIDTH·√(1 − 1/AMPLE)).
"""

BETA: Final = np.pi * WIDTH * (1.0 - 0.5 / AMPLE)
"""Its shape for such a window."""

TOGETHER: Final = 1024
"""Groups of lines that are spread at once, at most; and"""

LINES: Final = 32768
"""lines."""


def grid_size(lines: int) -> int:
    """Samples of the grid of so many lines, the mean among them, over a period."""
    return int(scipy.fft.next_fast_len(LINE_SAMPLES * max(lines - 1, 1), real=True))


MOST_LINES: Final = 2e7
"""Of a random signal: eleven hours up to 500 Hz, which take a minute to draw."""


def check_lines(count: float, what: str) -> None:
    """Raise InputError where a signal, by its name in words, has more lines than `MOST_LINES`."""
    if count > MOST_LINES:
        raise InputError(
            f"{what} has {count:.2g} lines; {MOST_LINES:.0e} is the most: lower its highest frequency, or duration"
        )


def room(lines: int) -> Held[np.complex128]:
    """Room for the amplitudes of so many lines, zero until they are written.

    Raises:
        InputError: if they need a temporary file, and there is no room for it.
    """
    return np.zeros(lines, complex) if is_whole(grid_size(lines)) else OnDisk(lines, np.complex128)


class Grid:
    """Value, slope and curvature of Re Σ ``lines``[k]·exp(2πi k n/size) at n = 0, 1, … in units of a grid step."""

    def __init__(self, lines: Held[np.complex128]) -> None:
        self._lines, self.size = lines, grid_size(lines.size)
        self._fold = 1 if is_whole(self.size) else next(q for q in count(self.size // (AMPLE * BLOCK)) if self._fits(q))
        self._length = self.size // self._fold
        self._span = self.size if self._fold == 1 else self._length // AMPLE
        self._recent = Recent(lambda number: self._whole() if self._fold == 1 else self._block(number * self._span))

    def _fits(self, fold: int) -> bool:
        return fold > 0 and self.size % fold == 0 and self.size <= AMPLE * BLOCK * fold

    def ends(self, at: NDArray[np.int64]) -> tuple[Array, Array]:
        """The three at the samples ``at``, 0 ≤ at < size, and at the next ones, (3, n) each."""
        blocks = at // self._span
        if blocks.size and blocks.min() == blocks.max():
            return self._in_block(int(blocks[0]), at)
        first, second = np.empty((2, 3, at.size))
        for number in np.unique(blocks):
            here = blocks == number
            first[:, here], second[:, here] = self._in_block(int(number), at[here])
        return first, second

    def _in_block(self, number: int, at: NDArray[np.int64]) -> tuple[Array, Array]:
        block = self._recent[number]
        at = at - number * self._span
        return block[:, at], block[:, at + 1]

    def _whole(self) -> Array:
        lines = self._lines[:]
        turn = 2j * np.pi * np.arange(lines.size) / self.size
        half = lines * (0.5 * self.size)
        half[0] = 2.0 * half[0].real
        grid = np.empty((3, self.size + 1))
        for k, part in enumerate((half, turn * half, turn * turn * half)):  # one by one: a long floor's grid is large
            grid[k, :-1] = scipy.fft.irfft(part, self.size)
        grid[:, -1] = grid[:, 0]
        return grid

    def _block(self, begin: int) -> Array:
        """Samples from ``begin`` up to and with the first of the next block, (3, span + 1)."""
        length, middle = self._length, begin + self._span // 2
        gain = _gain(self._span, length)
        block = np.empty((3, gain.size))
        for own, spectrum in zip(block, self._spread(middle), strict=True):
            # The FFT repeats after its length, so that it gives the window wherever that is.
            around = scipy.fft.irfft(spectrum * (0.5 * length), length)
            np.divide(np.take(around, np.arange(begin, begin + gain.size), mode="wrap"), gain, out=own)
        return block

    def _spread(self, middle: int) -> NDArray[np.complex128]:
        """Spectrum of a window around the sample ``middle`` for its FFT, of value, slope and curvature.

        A line k = g·fold + r lies r/fold beyond the frequency g: what it gives to the frequencies around g does not
        depend on g but for its own amplitude, so that all lines are spread by one product of matrices.
        """
        fold, length = self._fold, self._length
        groups = -(-self._lines.size // fold)
        beyond, near = np.arange(fold) / fold, np.arange(1 - WIDTH // 2, WIDTH // 2 + 1)
        turns = np.arange(fold) * middle % self.size / self.size
        turns = turns[:, None] - near * middle % length / length
        weights = _kernel(near - beyond[:, None]) * np.exp(2j * np.pi * turns)
        # Frequency in units of the FFT's is g + r/fold, of which the derivatives take the first and second power.
        weights = np.vstack([weights.T * beyond**order for order in range(3)])
        spread = np.zeros((3, groups + 2 * WIDTH), complex)
        together = max(1, min(TOGETHER, LINES // fold))
        for first in range(0, groups, together):
            last = min(first + together, groups)
            lines = np.zeros((last - first) * fold, complex)
            given = self._lines[first * fold : last * fold]
            lines[: given.size] = given
            zeroth, once, twice = (weights @ lines.reshape(-1, fold).T).reshape(3, WIDTH, -1)
            group = np.arange(first, last)
            powers = zeroth, group * zeroth + once, group * (group * zeroth + 2.0 * once) + twice
            for order, power in enumerate(powers):
                for offset, own in zip(near, power, strict=True):
                    spread[order, WIDTH + first + offset : WIDTH + last + offset] += own
        spread *= (2j * np.pi / length) ** np.arange(3)[:, None]
        spectrum = spread[:, WIDTH:]
        spectrum[:, 1:WIDTH] += spread[:, WIDTH - 1 : 0 : -1].conj()  # of a real signal, what lies below zero
        spectrum[:, 0] *= 2.0
        return spectrum


def _kernel(frequency: Array) -> Array:
    """The Kaiser-Bessel kernel at ``frequency`` in units of the FFT's, zero from ±WIDTH/2."""
    inside = 1.0 - (2.0 * frequency / WIDTH) ** 2
    return np.where(inside >= 0.0, np.i0(BETA * np.sqrt(np.maximum(inside, 0.0))), 0.0) / np.i0(BETA)


@lru_cache(2)
def _gain(span: int, length: int) -> Array:
    """Its transform in a window of ``span`` samples and the next one, about the window's middle."""
    turn = (np.pi * WIDTH / length * (np.arange(span + 1) - span // 2)) ** 2
    root = np.sqrt(BETA**2 - turn)
    # WIDTH·sinh(root)/(root·I₀(BETA)), of which sinh would be rounded by as many units as its argument has.
    grown = np.exp(BETA) / np.i0(BETA) * np.exp(-turn / (root + BETA))
    return np.asarray(-0.5 * WIDTH * grown * np.expm1(-2.0 * root) / root)
