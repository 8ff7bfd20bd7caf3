"""What is believed of a channel's error: how large it is, and how its samples go together."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.residual import Compared, real
from ehamj.identification.whiteness import whiteness

ORDER: Final = 40
"""Of autoregressions at most."""
LEAST: Final = 1e-6
"""Of a channel's size, that its error has at least: simulated data may have none."""


@dataclass(frozen=True)
class Noise:
    """Of one channel as real numbers (`ehamj.identification.residual.real`): standard deviation of each (n,), and the
    autoregression a of errors over it, eₜ = a₁ eₜ₋₁ + … + wₜ; () where they are white."""

    deviation: Array
    regression: tuple[float, ...] = ()
    innovation: float = 1.0
    """Deviation of w over that of e."""

    def whitened(self, values: Array) -> Array:
        """Errors (n,), or derivatives of predictions (n, k), white and of unit variance; of an autoregression's first
        samples, which nothing goes before, none."""
        of = values / (self.deviation if values.ndim == 1 else self.deviation[:, None])
        if not self.regression:
            return np.asarray(of)
        from scipy.signal import lfilter

        filtered = lfilter([1.0, *(-share for share in self.regression)], [1.0], of, axis=0)
        return np.asarray(filtered[len(self.regression) :] / self.innovation)

    def cost(self, error: Array) -> float:
        """−2·log likelihood of errors (n,)."""
        white = self.whitened(error)
        scale = self.deviation[len(self.regression) :] * self.innovation
        return float(white @ white + 2.0 * np.log(scale).sum() + white.size * np.log(2.0 * np.pi))


def noises(
    compared: Sequence[Compared],
    unknowns: int,
    coloured: bool,
    before: Sequence[Noise] | None = None,
    at_most_signal: bool = False,
) -> list[Noise]:
    """Estimates from what is left of each channel; stated deviations stay.

    Args:
        compared: channels near the best fit.
        unknowns: that were fitted, whose share of the errors is missing.
        coloured: whether errors of samples in time may go together.
        before: what was believed; errors that went together still do.
        at_most_signal: whether noise is no larger than what was measured about its mean: far from the best fit, an
            offset or a level that is off would hide a channel behind noise that it has not.
    """
    total = sum(one.error.size for one in compared if np.isnan(one.deviation).any())
    lost = min(unknowns / total, 0.5) if total else 0.0
    return [
        _noise(one, lost, coloured, None if before is None else before[k], at_most_signal)
        for k, one in enumerate(compared)
    ]


def _noise(one: Compared, lost: float, coloured: bool, before: Noise | None, at_most_signal: bool) -> Noise:
    error = one.error
    parts = error.size // max(len(one.at), 1)
    stated = np.tile(np.asarray(one.deviation, float), parts) / np.sqrt(parts)
    size = float(np.sqrt(np.mean(error**2) / (1.0 - lost)))
    if at_most_signal:
        size = min(size, float(np.std(real(one.measured))) or size)
    size = max(size, LEAST * float(np.abs(one.measured).max(initial=1e-30)))
    deviation = np.where(np.isnan(stated), size, stated)
    if not coloured or one.axis != "time":
        return Noise(deviation)
    known = before is not None and before.regression
    if not known and whiteness(error / deviation).white:
        return Noise(deviation)
    return Noise(deviation, *autoregression(error / deviation))


def autoregression(errors: Array) -> tuple[tuple[float, ...], float]:
    """Coefficients, and the innovation's deviation, of the order that Schwarz's criterion has it (Levinson)."""
    n = errors.size
    most = min(ORDER, n // 20)
    covariance = correlation(errors, most)
    power, shares = covariance[0], np.zeros(0)
    best: tuple[float, Array, float] = (0.0, shares, power)
    for order in range(1, most + 1):
        reflected = (
            (covariance[order] - shares @ covariance[order - 1 : 0 : -1]) / power
            if order > 1
            else (covariance[1] / power)
        )
        shares = np.append(shares - reflected * shares[::-1], reflected)
        power *= 1.0 - reflected**2
        criterion = n * np.log(power / covariance[0]) + order * np.log(n)
        if criterion < best[0]:
            best = (criterion, shares, power)
    return tuple(best[1].tolist()), float(np.sqrt(best[2]))


def correlation(errors: Array, lags: int) -> Array:
    """Autocovariance at lags 0 … ``lags``, (lags + 1,), biased, about zero."""
    size = 1 << int(np.ceil(np.log2(2 * errors.size)))
    power = np.abs(np.fft.rfft(errors, size)) ** 2
    return np.asarray(np.fft.irfft(power, size)[: lags + 1] / errors.size)
