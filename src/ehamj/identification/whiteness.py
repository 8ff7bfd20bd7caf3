"""Whether errors are white: autocorrelation, and the statistic of Ljung and Box (1978)."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.arrays import Array

LAGS: Final = 40
"""That are looked at."""
LIKELY: Final = 1e-3
"""Probability of so large a statistic below which errors count as not white: a test has dozens of channels, none of
which should be called so by chance."""
WITHIN: Final = 2.576
"""Deviations within which 99 % stay."""


@dataclass(frozen=True)
class Whiteness:
    """Of one channel's errors."""

    correlation: Array
    """Autocorrelation at lags 0, 1, …, (lag,)."""
    limit: float
    """Magnitude below which 99 % of them stay if the errors are white."""
    probability: float
    """Of so large a statistic of Ljung and Box if they are white."""
    white: bool


def whiteness(errors: Array, fitted: int = 0) -> Whiteness:
    """Of errors in order, (n,), of which an autoregression took ``fitted`` coefficients."""
    from scipy.stats import chi2

    n = errors.size
    lags = min(max(LAGS, 2 * fitted), n // 5)
    size = 1 << int(np.ceil(np.log2(2 * n)))
    about = errors - errors.mean()
    power = np.abs(np.fft.rfft(about, size)) ** 2
    covariance = np.fft.irfft(power, size)[: lags + 1]
    found = covariance / covariance[0] if covariance[0] > 0.0 else np.r_[1.0, np.zeros(lags)]
    statistic = n * (n + 2) * float(np.sum(found[1:] ** 2 / (n - np.arange(1, lags + 1))))
    probability = float(chi2.sf(statistic, max(lags - fitted, 1)))
    return Whiteness(found, WITHIN / np.sqrt(n), probability, probability >= LIKELY)
