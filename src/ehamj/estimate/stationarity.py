"""How large the largest sliding mean square of stationary Gaussian noise is by chance, behind a filter.

The mean square of a window is a quadratic form of Gaussian values: Σ λ_i χ²₂/2 with the eigenvalues λ_i of the
noise's own autocorrelation over the window, their sum one (Kac and Siegert 1947; Rice 1945). Its far tail is
the saddlepoint's (Lugannani and Rice 1980; Kuonen 1999 for quadratic forms). As the window slides, its mean square u
changes by what comes in less what goes out, each exponentially distributed about u, so that it crosses u upwards
u f(u)/(2τ) times a second (Rice's formula), f the density. What it is held against is the run's own mean square, the
window included; the rest of the run is gamma distributed with the degrees of freedom left.

Held against simulated noise the probability comes out right within a factor of 2 to 3, on the large side, from one to
a hundred degrees of freedom, which is 0.3 dB in the level.
"""

from typing import Final

import numpy as np
from scipy.fft import ifft, next_fast_len
from scipy.linalg import toeplitz
from scipy.optimize import brentq
from scipy.stats import gamma, norm

from ehamj.arrays import Array
from ehamj.estimate.bands import Band
from ehamj.estimate.sliding import averaging_time, response
from ehamj.estimate.spectrum import Spectrum

LAGS: Final = 96
"""Steps into which a window is cut for the eigenvalues of its autocorrelation, at most."""
MANY: Final = 24.0
"""Degrees of freedom (pairs) from which eigenvalues count as equal."""
QUANTILES: Final = 24
"""Of the rest of the run's mean square, over which is averaged."""
BISECTIONS: Final = 50
"""To the saddlepoint: to 2⁻⁵⁰ of where it may lie."""


def shares(spectrum: Spectrum, band: Band) -> Array:
    """Eigenvalues λ_i of a window's mean square behind a band's filter, largest first, their sum one.

    By the spectrum that the run itself has there, so that noise narrower than the band counts by its own width. Only
    what is correlated within the window counts; where many are alike they are taken as equal.
    """
    step = spectrum.frequency[1]
    low, high = (max(int(edge / step), 1) for edge in (0.5 * band.edges[0], 2.0 * band.edges[1]))
    frequency = spectrum.frequency[low : high + 1]
    power = spectrum.power[low : high + 1].copy()
    for f, p in zip(spectrum.steady.frequency, spectrum.steady.power, strict=True):
        if frequency[0] <= f <= frequency[-1]:
            power[round((f - frequency[0]) / step)] += p
    power *= np.abs(response(band, frequency)) ** 2
    seconds = averaging_time(band, "max_1s")
    size = next_fast_len(4 * power.size)
    lag = 1.0 / (size * step)
    stride = max(int(np.ceil(seconds / LAGS / lag)), 1)
    correlation = ifft(power, size)[: int(seconds / lag) + 1]
    correlation = correlation / correlation[0]
    u = np.arange(correlation.size) / correlation.size
    spread = float((np.abs(correlation) ** 2 * (1.0 - u)).mean() * 2.0)
    if spread * MANY < 1.0:
        return np.full(round(1.0 / spread), 1.0 / round(1.0 / spread))
    found = np.maximum(np.linalg.eigvalsh(toeplitz(correlation[::stride])), 0.0)[::-1]
    return np.asarray(found / found.sum())


def white(band: Band) -> Array:
    """The same of noise that is white over the band: there are 1.05 · bandwidth · time degrees of freedom, alike."""
    count = max(round(np.pi / 3.0 * band.width * averaging_time(band, "max_1s")), 1)
    return np.full(count, 1.0 / count)


def chance(ratio: float, eigenvalues: Array, windows: float) -> float:
    """Probability that the largest sliding mean square is at least ``ratio`` times the run's mean square.

    Args:
        ratio: of mean squares.
        eigenvalues: λ_i of a window, see `shares`.
        windows: length of the run over that of a window, above 1.
    """
    if ratio <= 1.0:
        return 1.0
    if ratio >= windows:
        return 0.0
    freedom = (windows - 1.0) / float((eigenvalues**2).sum())
    rest = gamma.ppf((np.arange(QUANTILES) + 0.5) / QUANTILES, freedom) / freedom
    against = ratio * (windows - 1.0) / (windows - ratio)
    beyond, density = _tail(against * rest, eigenvalues)
    crossings = (windows - 1.0) * 0.5 * against * rest * density
    return float(np.minimum(beyond + crossings, 1.0).mean())


def largest_by_chance(probability: float, eigenvalues: Array, windows: float) -> float:
    """The ratio of mean squares that stationary Gaussian noise exceeds with a probability; see `chance`."""

    def over(ratio: float) -> float:
        return float(np.log(max(chance(ratio, eigenvalues, windows), 1e-300) / probability))

    return float(brentq(over, 1.0 + 1e-9, windows * (1.0 - 1e-9), xtol=1e-4))


def _tail(u: Array, eigenvalues: Array) -> tuple[Array, Array]:
    """Probability that Σ λ_i χ²₂/2 exceeds u, and its density there, by the saddlepoint (u,)."""
    lam = eigenvalues[eigenvalues > 1e-6 * eigenvalues[0]]
    if np.ptp(lam) == 0.0:
        alike = gamma(lam.size, scale=lam[0])
        return alike.sf(u), alike.pdf(u)
    u = np.asarray(u)[:, None]
    low, high = np.full_like(u, -lam.size / u.min()), np.full_like(u, 1.0 / lam[0])
    for _ in range(BISECTIONS):
        s = 0.5 * (low + high)
        above = (lam / (1.0 - s * lam)).sum(axis=1, keepdims=True) > u
        low, high = np.where(above, low, s), np.where(above, s, high)
    s = low
    cumulant, curvature = -np.log1p(-s * lam).sum(axis=1), ((lam / (1.0 - s * lam)) ** 2).sum(axis=1)
    s, u = s[:, 0], u[:, 0]
    density = np.exp(cumulant - s * u) / np.sqrt(2 * np.pi * curvature)
    w, v = np.sign(s) * np.sqrt(np.maximum(2.0 * (s * u - cumulant), 0.0)), s * np.sqrt(curvature)
    regular = np.abs(w) > 1e-3  # at the mean both terms grow beyond bounds and cancel
    between = np.where(regular, 1.0 / np.where(regular, v, 1.0) - 1.0 / np.where(regular, w, 1.0), 0.0)
    return np.clip(norm.sf(w) + norm.pdf(w) * between, 0.0, 1.0), density
