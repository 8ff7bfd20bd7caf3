"""The fit: maximum likelihood with estimated noise, by least squares under a trust region, noise and values in turn."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.noise import Noise, noises
from ehamj.identification.problem import Linearised, Problem
from ehamj.identification.residual import Compared, Failed, fit_percent
from ehamj.identification.unknowns import Unknown

ROUNDS: Final = 24
"""Of noise and values in turn, at most."""
MUCH: Final = 0.3
"""Share of a round's cost at which it ends, since the noise is not what was believed."""
ABOUT: Final = 0.2
"""As `SETTLED`, from which on values are fitted to the last: before, their noise is too unlike."""
SETTLED: Final = 0.01
"""Change of all deviations of noise, over themselves, at which they count as found."""
NEARLY: Final = 1e-2
"""Fall of the cost, over itself, at which a round ends whose noise is not yet known."""
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
        self.moving = np.array([not one.level for one in problem.unknowns])
        self.known: dict[bytes, Linearised | Failed] = {}
        self.taken = 0
        self.failed = ""

    def at(self, point: Array) -> Linearised | Failed:
        """Whatever its offsets, which `levelled` finds."""
        key = point[self.moving].tobytes()
        if key not in self.known:
            self.taken += 1
            self.known = dict(list(self.known.items())[-3:])  # as large as the data times the unknowns
            self.known[key] = self.problem.linearised(point)
        return self.known[key]


def fitted(
    problem: Problem,
    point: Array,
    iterations: int,
    coloured: bool = True,
    told: Told = lambda words: None,
    roughly: bool = False,
) -> Fitted | Failed:
    """Fit from a point: values under the noise that is believed, noise from what they leave, until both stay.

    Args:
        problem: tests and unknowns.
        point: scaled unknowns at which it begins, (k,).
        iterations: steps of all rounds together, at most.
        coloured: whether errors of samples in time may go together.
        told: called with what is done.
        roughly: whether it ends where the noise is known about.
    """
    steps = _Steps(problem)
    at = steps.at(point)
    if isinstance(at, Failed):
        return at
    count, why = len(problem.unknowns), ""
    at = levelled(at, noises(at.compared, 0, False), problem.unknowns)
    noise, colour, known = noises(at.compared, 0, False, at_most_signal=True), False, False
    for _ in range(ROUNDS):
        to_the_last = known  # noise that is stated stays from the first round on, whose end is rough
        fall = ENOUGH / max(2.0 * _cost(at, noise, problem.unknowns), 1.0) if known else NEARLY
        at, ended = _round(steps, at, noise, max(iterations - steps.taken, 1) + 1, fall)
        told(f"{steps.taken} steps, {_words(at.compared)}")
        before, noise = noise, noises(at.compared, count, colour, noise, at_most_signal=not known)
        same, known = _same(before, noise, SETTLED), known or (ended and _same(before, noise, ABOUT))
        if steps.taken >= iterations or (roughly and known):
            break
        if not (to_the_last and ended and same):
            continue
        # What is left of a model that is not yet fitted is no noise, so that its colour is asked for now only.
        before, noise, colour = noise, noises(at.compared, count, coloured, noise), coloured
        if _same(before, noise, SETTLED):
            why = "values and noise stay"
            break
    if not why and steps.failed:
        return Fitted(at, tuple(noise), cost_of(at.compared, noise), steps.taken, "")
    return Fitted(at, tuple(noise), cost_of(at.compared, noise), steps.taken, why)


def _round(steps: _Steps, at: Linearised, noise: Sequence[Noise], most: int, fall: float) -> tuple[Linearised, bool]:
    """Values under a noise, and whether their fit ended by itself; it is broken off where so little is left that the
    noise is another one."""
    from scipy.optimize import OptimizeResult, least_squares

    unknowns = steps.problem.unknowns
    at, moving = levelled(at, noise, unknowns), steps.moving
    begun_with = _cost(at, noise, unknowns)

    def whole(own: Array) -> Array:
        point = at.point.copy()
        point[moving] = own
        return point

    def error(own: Array) -> Array:
        found = steps.at(whole(own))
        if isinstance(found, Failed):  # the trust region shrinks then
            steps.failed = str(found)
            return np.full(errors(at, noise, unknowns).size, np.inf)
        return errors(levelled(found, noise, unknowns), noise, unknowns)

    def slope(own: Array) -> Array:
        found = steps.at(whole(own))
        assert isinstance(found, Linearised)
        every = slopes(found, noise, unknowns)
        beside = every[:, ~moving] / np.maximum(np.linalg.norm(every[:, ~moving], axis=0), 1e-300)
        return np.asarray(every[:, moving] - beside @ (beside.T @ every[:, moving]))

    def taken(intermediate_result: OptimizeResult) -> None:
        if intermediate_result.cost < MUCH * begun_with:
            raise StopIteration

    low, high = (side[moving] for side in steps.problem.limits)
    inner = 1e-9 * np.where(np.isfinite(high - low), high - low, 0.0)
    begun = np.clip(at.point[moving], low + inner, high - inner)
    found = least_squares(
        error, begun, slope, (low, high), method="trf", x_scale=1.0, ftol=fall, xtol=1e-9, gtol=1e-12, max_nfev=most,
        callback=taken,
    )  # fmt: skip
    ended = steps.at(whole(found.x))
    return (at if isinstance(ended, Failed) else levelled(ended, noise, unknowns)), found.status > 0


def levelled(at: Linearised, noise: Sequence[Noise], unknowns: Sequence[Unknown]) -> Linearised:
    """The same with each channel's offset where it is best. Predictions are linear in it, so that it is found beside
    the others (variable projection, Golub and Pereyra 1973), whose steps it would else make short: a heavier machine
    whose offsets stay is far off, and one whose offsets follow is near.
    """
    free = [k for k, one in enumerate(unknowns) if one.level]
    point, compared = at.point.copy(), list(at.compared)
    for number, (of, one, slope) in enumerate(zip(noise, at.compared, at.slopes, strict=True)):
        for k in (k for k in free if slope[:, k].any()):
            own = of.whitened(slope[:, k])
            share = float(own @ of.whitened(compared[number].error)) / float(own @ own)
            point[k] += share
            compared[number] = replace(one, predicted=compared[number].predicted + share * slope[:, k])
    return replace(at, point=point, compared=tuple(compared))


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


def _same(before: Sequence[Noise], after: Sequence[Noise], within: float) -> bool:
    """Whether noise is what it was believed to be, within a share."""
    return all(
        len(one.regression) == len(other.regression)
        and abs(np.log(one.deviation[0] * one.innovation / (other.deviation[0] * other.innovation))) < within
        for one, other in zip(before, after, strict=True)
    )


def _words(compared: Sequence[Compared]) -> str:
    worst = min(fit_percent(one.measured, one.predicted) for one in compared)
    return f"worst channel fitted to {worst:.4g} %"
