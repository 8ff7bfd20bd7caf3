"""Frequency responses, coherence and confidence from spectra of inputs and outputs, one or several of each.

Notation and formulas of Bendat & Piersol, Random Data (4th ed., 2010), chapters 6, 7 and 9: G are one-sided spectral
densities, H1 = G_yx G_xx⁻¹, H2 = G_yy G_xy⁻¹ and Hv of Rocklin, Crowley & Vold (IMAC 1985), the total least squares.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Literal, Self

import numpy as np
from numpy.typing import NDArray
from scipy import signal
from scipy.stats import f as fisher

from ehamj.arrays import Array, ComplexArray
from ehamj.errors import InputError

Estimator = Literal["h1", "h2", "hv"]
ESTIMATORS: Final = ("h1", "h2", "hv")

OVERLAP: Final = 0.5
"""Share by which the segments of a Welch spectrum overlap; Hann's window then wastes little of the record."""

ILL_POSED: Final = 1e10
"""Condition number of the inputs' coherence matrix above which single inputs cannot be told apart."""


@dataclass(frozen=True)
class Spectra:
    """Averaged spectra of q inputs x and p outputs y at frequencies [Hz].

    ``xx`` (f, q, q) holds E[x xᴴ], ``yx`` (f, p, q) E[y xᴴ], ``yy`` (f, p, p) E[y yᴴ]; their common factor is free.
    """

    frequency: Array
    xx: ComplexArray
    yx: ComplexArray
    yy: ComplexArray
    averages: Array
    """Number of independent averages n_d at each frequency, (f,)."""

    @classmethod
    def of_lines(cls, frequency: Array, x: ComplexArray, y: ComplexArray) -> Self:
        """From the lines of periodic signals in several experiments: x (experiment, f, q), y (experiment, f, p)."""
        n = x.shape[0]
        xx, yx, yy = (np.einsum("nfi,nfj->fij", a, b.conj()) / n for a, b in ((x, x), (y, x), (y, y)))
        return cls(frequency, xx, yx, yy, np.full(frequency.size, float(n)))

    @classmethod
    def welch(cls, x: Array, y: Array, rate: float, segment: float) -> Self:
        """Welch's spectra of inputs x (time, q) and outputs y (time, p), see `segments`."""
        parts = segments(np.hstack([x, y]), rate, segment)
        q = x.shape[1]
        return cls.of_segments(parts, range(q), range(q, q + y.shape[1]))

    @classmethod
    def of_segments(cls, parts: "Segments", inputs: Sequence[int], outputs: Sequence[int]) -> Self:
        """Welch's spectra of some channels of a record."""
        x, y = (parts.lines[:, :, list(channels)] for channels in (inputs, outputs))
        found = cls.of_lines(parts.frequency, x, y)
        return replace(found, averages=np.full(found.frequency.size, parts.averages))

    def merged(self, per_octave: float) -> Self:
        """Neighbouring lines averaged in bins of 1/``per_octave`` octave, which trades resolution for confidence.

        For Welch's spectra with Hann's window, whose neighbouring lines share (2/3)² and next ones (1/6)² of their
        power.
        """
        number = np.round(per_octave * np.log2(self.frequency)).astype(int)
        starts = np.flatnonzero(np.diff(number, prepend=number[0] - 1))
        size = np.diff(np.append(starts, number.size)).astype(float)

        def mean(values: NDArray[Any]) -> NDArray[Any]:
            return np.asarray(np.add.reduceat(values, starts) / size.reshape(-1, *([1] * (values.ndim - 1))))

        shared = sum(np.maximum(size - lag, 0.0) / size * part for lag, part in ((1, 4 / 9), (2, 1 / 36)))
        averages = mean(self.averages) * size / (1.0 + 2.0 * shared)
        means = {name: mean(getattr(self, name)) for name in ("frequency", "xx", "yx", "yy")}
        return replace(self, **means, averages=averages)


@dataclass(frozen=True)
class Segments:
    """Spectral lines (segment, f, channel) of a record's overlapping segments, and how many averages they are worth."""

    frequency: Array
    lines: ComplexArray
    averages: float


def segments(record: Array, rate: float, segment: float) -> Segments:
    """Segments of a record (time, channel): Hann's window, half overlapping, each about its mean.

    Args:
        record: samples.
        rate: sampling rate [Hz].
        segment: length of a segment [s]; lines are 1/``segment`` apart, without the one at 0 Hz.

    Raises:
        InputError: if the record is shorter than two segments, or a segment than 16 samples.
    """
    n = 2 * round(0.5 * segment * rate)
    if n < 16 or record.shape[0] < 2 * n:
        raise InputError(
            f"segment = {segment:g} s: must be at least {16 / rate:g} s (16 samples) and at most half of the "
            f"record, {0.5 * record.shape[0] / rate:g} s"
        )
    window, step = signal.get_window("hann", n), n - int(OVERLAP * n)
    transform = signal.ShortTimeFFT(window, step, rate, fft_mode="onesided", scale_to="psd")
    whole = transform.lower_border_end[1], transform.upper_border_begin(record.shape[0])[1]
    lines = transform.stft_detrend(record.T, "constant", *whole)[:, 1:].transpose(2, 1, 0)
    return Segments(transform.f[1:], lines, independent_averages(window, step, lines.shape[0]))


def independent_averages(window: Array, step: int, count: int) -> float:
    """How many independent segments ``count`` overlapping ones are worth (Welch 1967, eq. 10)."""
    power = (window**2).sum()
    lags = range(1, min(count, -(-window.size // step)))
    shared = [(k, ((window[k * step :] * window[: window.size - k * step]).sum() / power) ** 2) for k in lags]
    return float(count / (1.0 + 2.0 * sum((count - k) / count * part for k, part in shared)))


@dataclass(frozen=True)
class Estimate:
    """Measured responses of p outputs to q inputs; NaN where the inputs do not excite."""

    frequency: Array
    response: ComplexArray
    """(f, p, q)."""
    radius: Array
    """Of the confidence circle about each response, (f, p, q)."""
    multiple: Array
    """Multiple coherence: share of each output's power that all inputs together explain, (f, p)."""
    ordinary: Array
    """Ordinary coherence between each output and each input alone, (f, p, q)."""
    confidence: float
    """Probability that a response lies in its circle, were the noise Gaussian."""


def estimate(spectra: Spectra, estimator: Estimator = "h1", confidence: float = 0.95) -> Estimate:
    """Responses, coherences and confidence circles.

    The circle's radius is r² = F₂,₂₍ₙ₋q₎ G_yy (1 − γ²) (G_xx⁻¹)_jj / (n − q) with n independent averages and q inputs,
    F the quantile of Fisher's distribution (Goodman 1957; Bendat & Piersol, sec. 9.2 give its form for many averages
    and one input, the random error √((1 − γ²)/(2 γ² n))).

    Args:
        spectra: averaged.
        estimator: h1 (noise on the outputs), h2 (noise on the inputs; needs as many outputs as inputs), hv (on both,
            in proportion to the signals).
        confidence: probability of the circle, in (0, 1).

    Raises:
        InputError: if there is no such estimator, or h2 meets a matrix that is not square.
    """
    p, q = spectra.yx.shape[1:]
    if estimator not in ESTIMATORS:
        raise InputError(f"estimator = {estimator!r}: must be one of {', '.join(ESTIMATORS)}")
    if estimator == "h2" and p != q:
        raise InputError(f"estimator = 'h2': needs as many outputs as inputs; these are {p} and {q}")
    xx, yx, yy = _normalised(spectra)
    usable = _usable(xx)
    identity = np.eye(q)
    inverse = np.linalg.inv(np.where(usable[:, None, None], xx, identity))
    h1 = yx @ inverse
    multiple = np.clip(np.einsum("fpq,fpq->fp", h1, yx.conj()).real, 0.0, 1.0)
    response = {"h1": lambda: h1, "h2": lambda: _h2(yx, yy), "hv": lambda: _hv(xx, yx)}[estimator]()
    n = spectra.averages
    free = np.where(n > q, n - q, np.nan)
    factor = fisher.ppf(confidence, 2, 2 * free) / free
    spread = np.einsum("fqq->fq", inverse).real
    radius = np.sqrt((factor[:, None] * (1.0 - multiple))[:, :, None] * spread[:, None, :])
    unknown = ~usable
    known_y = np.einsum("fpp->fp", spectra.yy).real > 0
    unit = _scale(spectra.yy)[:, :, None] / _scale(spectra.xx)[:, None, :]
    ordinary = np.abs(yx) ** 2
    for values in (response, radius, multiple, ordinary):
        values[unknown] = np.nan
    multiple[~known_y] = np.nan
    ordinary[~known_y] = np.nan
    return Estimate(spectra.frequency, response * unit, radius * unit, multiple, ordinary, confidence)


def _scale(power: ComplexArray) -> Array:
    """Amplitude of each channel, one where it rests, (f, channels)."""
    amplitude = np.sqrt(np.einsum("fpp->fp", power).real)
    return np.where(amplitude > 0, amplitude, 1.0)


def _normalised(spectra: Spectra) -> tuple[ComplexArray, ComplexArray, ComplexArray]:
    """The spectra with every channel of unit power, so that units play no part."""
    x, y = _scale(spectra.xx), _scale(spectra.yy)
    return (
        spectra.xx / (x[:, :, None] * x[:, None, :]),
        spectra.yx / (y[:, :, None] * x[:, None, :]),
        spectra.yy / (y[:, :, None] * y[:, None, :]),
    )


def _usable(xx: ComplexArray) -> NDArray[np.bool_]:
    """Where every input moves and no input is a combination of the others, (f,)."""
    values = np.linalg.eigvalsh(xx)
    return values[:, 0] * ILL_POSED > values[:, -1]


def _h2(yx: ComplexArray, yy: ComplexArray) -> ComplexArray:
    xy = yx.conj().transpose(0, 2, 1)
    regular = np.linalg.cond(xy) < np.sqrt(ILL_POSED)
    found = yy @ np.linalg.inv(np.where(regular[:, None, None], xy, np.eye(xy.shape[1])))
    found[~regular] = np.nan
    return found


def _hv(xx: ComplexArray, yx: ComplexArray) -> ComplexArray:
    """Of each output: the eigenvector of the smallest eigenvalue of the inputs' and the output's spectra together."""
    f, p, q = yx.shape
    found = np.empty((f, p, q), complex)
    for row in range(p):
        joint = np.ones((f, q + 1, q + 1), complex)
        joint[:, :q, :q] = xx
        joint[:, q, :q], joint[:, :q, q] = yx[:, row], yx[:, row].conj()
        vectors = np.linalg.eigh(joint)[1][:, :, 0]
        # The residual h·x − y is the combination whose power is least: vᴴ (x, y), v ∝ (hᴴ, −1).
        with np.errstate(divide="ignore", invalid="ignore"):
            found[:, row] = -(vectors[:, :q] / vectors[:, q:]).conj()
    return found
