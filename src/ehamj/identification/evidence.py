"""How much better one model explains the data than another, and what a small change of a model could explain.

Both models are given noise of the same form, so that they are compared on the same samples: where these follow each
other in time an autoregression of one order, else white noise; its size is each model's own (maximum likelihood).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.problem import Linearised
from ehamj.identification.residual import Compared, real

ORDER: Final = 8
"""Of the autoregression."""
SAMPLES_PER_ORDER: Final = 50
FEWEST: Final = 1e-30
"""Share of a channel's own size below which an error counts as none."""


def gain_of(smaller: Sequence[Compared], larger: Sequence[Compared]) -> float:
    """Fall of −2·log likelihood from the channels of one model to the same ones of another."""
    return float(sum(_gain(one, other) for one, other in zip(smaller, larger, strict=True)))


def samples_of(compared: Sequence[Compared]) -> int:
    """Real numbers that were measured."""
    return sum(one.error.size for one in compared)


def bic(samples: int, more: int) -> float:
    """What BIC asks of ``more`` parameters (Schwarz 1978)."""
    return more * float(np.log(samples))


def aicc(samples: int, known: int, more: int) -> float:
    """What AICc asks of ``more`` parameters beside ``known`` ones (Hurvich & Tsai 1989)."""

    def of(k: int) -> float:
        return 2.0 * k + 2.0 * k * (k + 1) / max(samples - k - 1, 1)

    return of(known + more) - of(known)


def _gain(one: Compared, other: Compared) -> float:
    if _stated(one):
        return float(np.sum(_over(one.error, one) ** 2) - np.sum(_over(other.error, one) ** 2))
    order = min(ORDER, len(one.at) // SAMPLES_PER_ORDER) if one.axis == "time" else 0
    before, after = (max(_innovation(e.error, order), FEWEST * float(np.var(real(e.measured)))) for e in (one, other))
    return (one.error.size - order) * float(np.log(before / after)) if before > 0.0 else 0.0


def _innovation(error: Array, order: int) -> float:
    """Mean square of errors after the best autoregression of an order."""
    n = error.size - order
    if order == 0:
        return float(np.mean(error**2))
    past = np.column_stack([error[order - lag : order - lag + n] for lag in range(1, order + 1)])
    shares, *_ = np.linalg.lstsq(past, error[order:], rcond=None)
    return float(np.mean((error[order:] - past @ shares) ** 2))


def _stated(one: Compared) -> bool:
    """Whether the noise of a channel is known beforehand."""
    return bool(np.isfinite(one.deviation).all())


def _over(values: Array, one: Compared) -> Array:
    """Errors, (n,), or derivatives, (n, k), over the noise of a channel; of complex ones each part has half of it."""
    if _stated(one):
        parts = np.concatenate([one.deviation, one.deviation]) / np.sqrt(2) if np.iscomplexobj(one.measured) else None
        size = one.deviation if parts is None else parts
    else:
        size = np.full(one.error.size, max(float(np.sqrt(np.mean(one.error**2))), 1e-300))
    return values / (size if values.ndim == 1 else size[:, None])


@dataclass(frozen=True)
class Effect:
    """What a change of some size would explain, to first order and with all other unknowns free to follow."""

    size: float
    """Of the change."""
    best: float
    """Size that explains most, in the direction of ``size``."""
    gain: float
    """Fall of −2·log likelihood there."""
    deviation: float
    """Standard deviation with which the data tell the size."""


def effect_of(at: Linearised, moved: Sequence[Compared], size: float) -> Effect:
    """Of a change of a model, from its channels with a change of ``size`` and from those without, at its best fit."""
    channels = list(zip(at.compared, moved, at.slopes, strict=True))
    error = np.concatenate([_over(one.error, one) for one, _, _ in channels])
    change = np.concatenate([_over(real(new.predicted - one.predicted), one) for one, new, _ in channels])
    slopes = np.concatenate([_over(slope, one) for one, _, slope in channels])
    basis = _basis(slopes)
    error, change = (values - basis @ (basis.T @ values) for values in (error, change))
    power = float(change @ change)
    if power == 0.0:
        return Effect(size, size, 0.0, float("inf"))
    share = max(float(change @ error) / power, 0.0)
    gain, begin = 0.0, 0
    for one, _, _ in channels:
        own = slice(begin, begin + one.error.size)
        before, after = float(np.sum(error[own] ** 2)), float(np.sum((error[own] - share * change[own]) ** 2))
        gain += before - after if _stated(one) else one.error.size * float(np.log(before / after)) if before else 0.0
        begin += one.error.size
    return Effect(size, share * size, max(gain, 0.0), abs(size) / float(np.sqrt(power)))


def deviation_of(at: Linearised, k: int) -> float:
    """Standard deviation of the k-th scaled unknown, all others free; infinite where the data do not tell it."""
    slopes = np.concatenate([_over(slope, one) for one, slope in zip(at.compared, at.slopes, strict=True)])
    basis = _basis(np.delete(slopes, k, axis=1))
    own = slopes[:, k] - basis @ (basis.T @ slopes[:, k])
    left = float(np.linalg.norm(own))
    return 1.0 / left if left > 1e-9 * float(np.linalg.norm(slopes[:, k])) and left > 0.0 else float("inf")


def _basis(slopes: Array) -> Array:
    """Orthonormal basis of what columns span, (n, rank)."""
    size = np.linalg.norm(slopes, axis=0)
    left, values, _ = np.linalg.svd(slopes[:, size > 0.0] / size[size > 0.0], full_matrices=False)
    return np.asarray(left[:, values > 1e-10 * values.max(initial=0.0)])
