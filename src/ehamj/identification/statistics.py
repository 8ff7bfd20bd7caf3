"""What a fit is worth: deviations, correlations, and which combinations of values the data cannot tell.

All unknowns are scaled (logarithms where positive). A test's own unknowns are taken out of the information first (Schur
complement), so that what they leave open is open. Directions are judged beside what was known before: a value without
prior counts as known as a uniform one within its bounds is, one with a prior as that says. A direction whose deviation
by the data is larger than that is one they cannot tell.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.fit import Fitted
from ehamj.identification.noise import Noise
from ehamj.identification.problem import Linearised
from ehamj.identification.unknowns import Unknown
from ehamj.identification.whiteness import whiteness

UNTOLD: Final = 0.5
"""Information in a direction, over what was known before, below which the data do not tell it."""
MOSTLY: Final = 0.5
"""Share of a value's variance in such directions from which it has no number."""
MATTERS: Final = 0.05
"""Its deviation, over that within the bounds, from which this counts."""
TIES: Final = 0.15
"""Share in a direction, over the largest, from which a parameter is named with it."""
OFF: Final = 1.5
"""Mean square of whitened errors, or its inverse, beyond which stated deviations are not believed."""


@dataclass(frozen=True)
class Statistics:
    """Of the parameters, in the problem's order, without the tests' own unknowns."""

    covariance: Array
    """Of all scaled unknowns, the parameters first, (k, k); directions that nothing tells have the spread that their
    bounds leave."""
    untold: Array
    """Directions that the data cannot tell, over the scaled parameters, (direction, parameter), of unit length."""
    no_number: tuple[bool, ...]
    """Of each parameter, whether the data leave it open."""
    by_prior: tuple[bool, ...]
    """Of each, whether what was known before says more of it than the data."""
    robust: bool
    """Whether errors were not as the noise says, so that the covariance follows the errors themselves (sandwich)."""


def known_before(unknowns: Sequence[Unknown], point: Array) -> Array:
    """Standard deviation of each scaled unknown by what was known before, (k,): its prior's, or that of a uniform one
    within the bounds; infinite where there are none."""
    found = []
    for one, z in zip(unknowns, point, strict=True):
        low, high = one.limits
        spread = (high - low) / np.sqrt(12.0)
        if one.prior is not None:
            spread = min(spread, one.prior.deviation / one.slope(one.value(float(z))))
        found.append(spread)
    return np.array(found)


def cleared(at: Linearised, noise: Sequence[Noise], unknowns: Sequence[Unknown]) -> tuple[list[Array], Array]:
    """Whitened slopes of each channel, (n, k), clear of its own offset and the like, and the way back.

    A stroke's level goes with the mass as strongly as with its offset, its motion a million times less: sums of squares
    of both would have no digit left of the motion. With C the slopes of what is a channel's own and linear, o, and S
    those of the others, θ, it counts as o + Bθ with S − CB what is left; (θ, o) is T (θ, o + Bθ), with T (k, k).
    """
    white = [one.whitened(slope) for one, slope in zip(noise, at.slopes, strict=True)]
    moves = np.array([slope.any(axis=0) for slope in white])
    single = np.array([one.level for one in unknowns]) & (moves.sum(axis=0) == 1)
    back = np.eye(len(unknowns))
    for slope, moved in zip(white, moves, strict=True):
        own, others = np.flatnonzero(single & moved), np.flatnonzero(~single & moved)
        if own.size and others.size:
            shares = np.linalg.lstsq(slope[:, own], slope[:, others], rcond=None)[0]
            slope[:, others] -= slope[:, own] @ shares
            back[np.ix_(own, others)] = -shares
    return white, back


def information(at: Linearised, noise: Sequence[Noise], unknowns: Sequence[Unknown]) -> Array:
    """Fisher information of the data on the scaled unknowns, (k, k), priors not among them; offsets and the like count
    from where the others put them (`cleared`)."""
    return np.asarray(sum(one.T @ one for one in cleared(at, noise, unknowns)[0]))


def statistics(fit: Fitted, unknowns: Sequence[Unknown], parameters: int) -> Statistics:
    """What a fit's end is worth; its derivatives should be central.

    Args:
        fit: where it ended.
        unknowns: all, the parameters first.
        parameters: how many they are.
    """
    before = known_before(unknowns, fit.point)
    scale = np.where(np.isfinite(before), before, 1.0)
    slopes, back = cleared(fit.at, fit.noise, unknowns)
    slopes = [one * scale for one in slopes]
    data = np.asarray(sum(one.T @ one for one in slopes))
    told = np.diag([float(one.prior is not None) for one in unknowns])
    posterior = data + told
    marginal = _without_last(posterior, parameters)
    power, directions = np.linalg.eigh(marginal)
    open_ = directions[:, power < UNTOLD]
    held = posterior.copy()
    held[:parameters, :parameters] += open_ @ open_.T
    inverse = np.linalg.pinv(held, rcond=1e-13, hermitian=True)
    meat, robust = _meat(fit, slopes)
    covariance = inverse
    if robust:
        covariance = inverse @ (meat + held - data) @ inverse
    covariance = back @ (covariance * np.outer(scale, scale)) @ back.T
    variance = np.diag(covariance)[:parameters] / scale[:parameters] ** 2
    inside = open_ / np.sqrt(1.0 + np.maximum(power[power < UNTOLD], 0.0))
    share = (inside**2).sum(axis=1) / variance
    matters = np.sqrt(variance) > MATTERS
    has_prior = np.diag(told)[:parameters] > 0.0
    lost = (share > MOSTLY) & matters & ~has_prior
    return Statistics(
        covariance,
        (open_ * scale[:parameters, None]).T / np.linalg.norm(open_ * scale[:parameters, None], axis=0)[:, None],
        tuple(lost.tolist()),
        tuple((has_prior & (variance > 0.5)).tolist()),
        robust,
    )


def _without_last(matrix: Array, first: int) -> Array:
    """Information on the first unknowns when nothing is known of the others (Schur complement)."""
    own, between, others = matrix[:first, :first], matrix[:first, first:], matrix[first:, first:]
    if others.size == 0:
        return own
    found = own - between @ np.linalg.pinv(others, rcond=1e-13, hermitian=True) @ between.T
    return np.asarray(0.5 * (found + found.T))


def _meat(fit: Fitted, slopes: Sequence[Array]) -> tuple[Array, bool]:
    """Covariance of the log likelihood's slopes by the errors themselves (Newey, West 1987), and whether it is needed:
    errors are neither white nor as large as stated. ``slopes`` of the channels' predictions are whitened."""
    total, needed = np.zeros((slopes[0].shape[1],) * 2), False
    for channel, noise, own in zip(fit.at.compared, fit.noise, slopes, strict=True):
        error = noise.whitened(channel.error)
        size = float(np.mean(error**2))
        in_order = channel.axis == "time" and error.size >= 50
        coloured = in_order and not whiteness(error, len(noise.regression)).white
        if not coloured and (1.0 / OFF < size < OFF or error.size < 20):
            total += own.T @ own
            continue
        needed = True
        score = own * error[:, None]
        total += score.T @ score
        lags = round(4.0 * (error.size / 100.0) ** (2.0 / 9.0)) if in_order else 0
        for lag in range(1, lags + 1):
            part = (1.0 - lag / (lags + 1.0)) * score[lag:].T @ score[:-lag]
            total += part + part.T
    return total, needed


def words_of(direction: Array, unknowns: Sequence[Unknown]) -> tuple[tuple[str, ...], str]:
    """Parameters of a direction that the data cannot tell, by their share, and what that means.

    Args:
        direction: over the scaled parameters, (parameter,).
        unknowns: the parameters.
    """
    size = np.abs(direction) / np.abs(direction).max()
    taking = [int(k) for k in np.argsort(-size) if size[k] >= TIES]
    names = tuple(unknowns[k].name for k in taking)
    if len(names) == 1:
        return names, f"{names[0]}: nothing in the data depends on it enough"
    logs = all(unknowns[k].log for k in taking)
    if len(names) == 2 and logs:
        ratio = float(direction[taking[0]] / direction[taking[1]])
        if abs(abs(ratio) - 1.0) < 0.1:
            return names, f"{names[0]} and {names[1]} only as their {'ratio' if ratio > 0 else 'product'}"
    changes = ", ".join(
        f"{names[0] if j == 0 else unknowns[k].name} by {100.0 * direction[k] / np.abs(direction).max():+.2g} %"
        if unknowns[k].log
        else f"{unknowns[k].name} by {0.01 * unknowns[k].scale * direction[k] / np.abs(direction).max():+.2g} "
        f"{unknowns[k].unit}"
        for j, k in enumerate(taking)
    )
    return names, f"{' and '.join(names)} only together: the data look the same with {changes}"
