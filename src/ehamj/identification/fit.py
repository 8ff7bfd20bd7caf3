"""The fit: maximum likelihood with estimated noise, by least squares under a trust region, noise and values in turn."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.noise import Noise, noises
from ehamj.identification.problem import Linearised, Problem
from ehamj.identification.residual import Compared, Failed
from ehamj.identification.unknowns import Unknown

ROUNDS: Final = 8
"""Of noise and values in turn, at most."""
SETTLED: Final = 0.01
"""Change of all deviations of noise, over themselves, at which they count as found."""
NEARLY: Final = 1e-2
"""Fall of the cost, over itself, at which a first round ends, whose noise is not yet known."""
ENOUGH: Final = 2e-2
"""Fall of −2·log likelihood at which the last round ends: values then move by a tenth of their deviation at most."""

Told = Callable[[str], None]


@dataclass(frozen=True)
class Fitted:
    """Where a fit ended."""

    at: Linearised
    noise: tuple[Noise, ...]
    cost: float
    """−2·log likelihood, priors not counted."""
    steps: int
    converged: str
    """Why it ended, in words; empty if it did not converge."""

    @property
    def point(self) -> Array:
        """Scaled unknowns, (k,)."""
        return self.at.point


class _Steps:
    """Whitened errors and their derivatives, each point evaluated once: in lanes a derivative costs little more than an
    error, so both come together."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.known: dict[bytes, Linearised | Failed] = {}
        self.taken = 0
        self.failed = ""

    def at(self, point: Array) -> Linearised | Failed:
        key = point.tobytes()
        if key not in self.known:
            self.taken += 1
            self.known = dict(list(self.known.items())[-3:])  # as large as the data times the unknowns
            self.known[key] = self.problem.linearised(point)
        return self.known[key]


def fitted(
    problem: Problem, point: Array, iterations: int, coloured: bool = True, told: Told = lambda words: None
) -> Fitted | Failed:
    """Fit from a point: values under the noise that is believed, noise from what they leave, until both stay.

    Args:
        problem: tests and unknowns.
        point: scaled unknowns at which it begins, (k,).
        iterations: steps of all rounds together, at most.
        coloured: whether errors of samples in time may go together.
        told: called with what is done.
    """
    steps = _Steps(problem)
    at = steps.at(point)
    if isinstance(at, Failed):
        return at
    noise, why = noises(at.compared, 0, False), ""
    for number in range(ROUNDS):
        fall = NEARLY if number == 0 else ENOUGH / max(2.0 * _cost(at, noise, problem.unknowns), 1.0)
        at, ended = _round(steps, at, noise, max(iterations - steps.taken, 1), fall)
        told(f"{steps.taken} steps, {_words(at.compared)}")
        before, noise = noise, noises(at.compared, len(problem.unknowns), coloured and number > 0, noise)
        if steps.taken >= iterations:
            break
        if number > 0 and ended and _same(before, noise):
            why = "values and noise stay"
            break
    if not why and steps.failed:
        return Fitted(at, tuple(noise), cost_of(at.compared, noise), steps.taken, "")
    return Fitted(at, tuple(noise), cost_of(at.compared, noise), steps.taken, why)


def _round(steps: _Steps, at: Linearised, noise: Sequence[Noise], most: int, fall: float) -> tuple[Linearised, bool]:
    """Values under a noise, and whether their fit ended by itself."""
    from scipy.optimize import least_squares

    unknowns = steps.problem.unknowns

    def error(point: Array) -> Array:
        found = steps.at(point)
        if isinstance(found, Failed):  # the trust region shrinks then
            steps.failed = str(found)
            return np.full(errors(at, noise, unknowns).size, np.inf)
        return errors(found, noise, unknowns)

    def slope(point: Array) -> Array:
        found = steps.at(point)
        assert isinstance(found, Linearised)
        return slopes(found, noise, unknowns)

    low, high = steps.problem.limits
    inner = 1e-9 * np.where(np.isfinite(high - low), high - low, 0.0)
    begun = np.clip(at.point, low + inner, high - inner)
    found = least_squares(
        error, begun, slope, (low, high), method="trf", x_scale=1.0, ftol=fall, xtol=1e-9, gtol=1e-12, max_nfev=most
    )
    ended = steps.at(found.x)
    return (at if isinstance(ended, Failed) else ended), found.status > 0


def errors(at: Linearised, noise: Sequence[Noise], unknowns: Sequence[Unknown]) -> Array:
    """Whitened errors of all channels, then those of what was known before."""
    own = [one.whitened(channel.error) for one, channel in zip(noise, at.compared, strict=True)]
    before = [
        (one.prior.mean - one.value(float(z))) / one.prior.deviation
        for one, z in zip(unknowns, at.point, strict=True)
        if one.prior is not None
    ]
    return np.concatenate([*own, np.array(before)])


def slopes(at: Linearised, noise: Sequence[Noise], unknowns: Sequence[Unknown]) -> Array:
    """Their derivatives in the scaled unknowns, (n, k)."""
    own = [-one.whitened(slope) for one, slope in zip(noise, at.slopes, strict=True)]
    before = [
        np.eye(len(unknowns))[k] * -one.slope(one.value(float(at.point[k]))) / one.prior.deviation
        for k, one in enumerate(unknowns)
        if one.prior is not None
    ]
    return np.concatenate([*own, np.array(before).reshape(-1, len(unknowns))])


def cost_of(compared: Sequence[Compared], noise: Sequence[Noise]) -> float:
    """−2·log likelihood of all channels."""
    return sum(one.cost(channel.error) for one, channel in zip(noise, compared, strict=True))


def _cost(at: Linearised, noise: Sequence[Noise], unknowns: Sequence[Unknown]) -> float:
    found = errors(at, noise, unknowns)
    return 0.5 * float(found @ found)


def _same(before: Sequence[Noise], after: Sequence[Noise]) -> bool:
    """Whether noise is what it was believed to be."""
    return all(
        len(one.regression) == len(other.regression)
        and abs(np.log(one.deviation[0] * one.innovation / (other.deviation[0] * other.innovation))) < SETTLED
        for one, other in zip(before, after, strict=True)
    )


def _words(compared: Sequence[Compared]) -> str:
    from ehamj.identification.outcome import fit_percent

    worst = min(fit_percent(one.measured, one.predicted) for one in compared)
    return f"worst channel fitted to {worst:.4g} %"
