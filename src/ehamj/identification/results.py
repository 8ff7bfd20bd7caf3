"""What a fit's end means: an `Identification`."""

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.file import IdentifyFile
from ehamj.identification.fit import Fitted, Told
from ehamj.identification.inertia import inertia_notes
from ehamj.identification.lateness import late_channels
from ehamj.identification.noise import Noise, noises
from ehamj.identification.outcome import ChannelFit, Combination, Identification, Identified, TestFit
from ehamj.identification.problem import Problem
from ehamj.identification.profiles import profile
from ehamj.identification.provenance import identified_machine
from ehamj.identification.residual import Compared, Failed, Residuals, fit_percent
from ehamj.identification.statistics import Statistics, statistics, words_of
from ehamj.identification.unknowns import Unknown
from ehamj.identification.whiteness import Whiteness, whiteness

NEAR: Final = 1e-3
"""Share of the distance of the bounds within which a value stands at one."""
LEAST: Final = 50
"""Samples in order that can tell whether they are white."""


def identification_of(
    file: IdentifyFile,
    problem: Problem,
    tests: Sequence[Residuals],
    fit: Fitted,
    told: Mapping[str, Any],
    say: Told = lambda words: None,
) -> Identification:
    """What was found.

    Args:
        file: that asked.
        problem: fitted tests and unknowns.
        tests: all, with those held out.
        fit: where it ended, its derivatives central.
        told: how it went.
        say: called with what is done.
    """
    count = len(problem.parameters)
    about = statistics(fit, problem.unknowns, count)
    values = problem.values(fit.point)
    each = [_identified(k, problem.unknowns, fit, about, values) for k in range(len(problem.unknowns))]
    found = {one.name: each[k] for k, one in enumerate(problem.parameters)}
    own = {one.name: each[k] for k, one in enumerate(problem.unknowns) if k >= count}
    kinds = {test.name: test.kind for test in file.test}
    fits = []
    for test in problem.tests:
        part = [k for k, name in enumerate(fit.at.tests) if name == test.name]
        channels = [_channel(fit.at.compared[k], fit.noise[k]) for k in part]
        nuisances = {one.name: own[one.name] for one in test.unknowns}
        fits.append(TestFit(test.name, kinds[test.name], tuple(channels), nuisances, test.found(values)))
    combinations = tuple(
        Combination(names, direction, words)
        for direction in about.untold
        for names, words in [words_of(direction, problem.parameters)]
    )
    profiles = {}
    for key in file.fit.profile:
        say(f"profile of {key}")
        number = [one.name for one in problem.parameters].index(key)
        profiles[key] = profile(problem, fit, about.covariance, number)
    held, failed = _validation([test for test in tests if test.held_out], kinds, values)
    machine = _scenario(file, found)
    odd = inertia_notes(file.machine, machine, file.parameters)
    return Identification(
        file, machine, found, _correlation(about, count), combinations, tuple(fits), held,
        fit.cost, sum(one.error.size for one in fit.at.compared), (*_notes(fit, about, found), *odd, *failed), told,
        profiles,
    )  # fmt: skip


def _identified(
    k: int, unknowns: Sequence[Unknown], fit: Fitted, about: Statistics, values: Mapping[str, float]
) -> Identified:
    """One unknown; a parameter that the data leave open has no number."""
    one, value = unknowns[k], values[unknowns[k].name]
    deviation = float(np.sqrt(about.covariance[k, k])) * one.slope(value)
    low, high = one.limits
    near = NEAR * (high - low) if np.isfinite(high - low) else 0.0
    at_bound: Any = "low" if fit.point[k] <= low + near else "high" if fit.point[k] >= high - near else ""
    given = (one.unit, one.start, (one.low, one.high))
    if k < len(about.no_number) and about.no_number[k]:
        with_it = [_with(direction, unknowns, k) for direction in about.untold]
        return Identified(None, None, *given, "", "unidentifiable", next((said for said in with_it if said), ""))
    if k < len(about.by_prior) and about.by_prior[k]:
        why = "what was known before says more of it than the data"
        return Identified(value, deviation, *given, at_bound, "prior", why)
    why = f"stands at its {at_bound} bound" if at_bound else ""
    return Identified(value, deviation, *given, at_bound, "identified", why)


def _with(direction: Array, unknowns: Sequence[Unknown], k: int) -> str:
    names, words = words_of(direction, unknowns)
    return words if unknowns[k].name in names else ""


def _channel(one: Compared, noise: Noise) -> ChannelFit:
    parts = one.error.size // len(one.at)
    deviation = np.sqrt((noise.deviation.reshape(parts, -1) ** 2).sum(axis=0))
    return ChannelFit(
        one.name, one.unit, one.axis, one.at, one.measured, one.predicted, deviation,
        fit_percent(one.measured, one.predicted), _whiteness(one, noise), one.coherence,
    )  # fmt: skip


def _whiteness(one: Compared, noise: Noise) -> Whiteness | None:
    error = noise.whitened(one.error)
    return whiteness(error, len(noise.regression)) if one.axis == "time" and error.size >= LEAST else None


def _validation(
    tests: Sequence[Residuals], kinds: Mapping[str, str], values: Mapping[str, float]
) -> tuple[tuple[TestFit, ...], list[str]]:
    """Tests that were held out, their own unknowns fitted to them, and what could not be compared."""
    found, failed = [], []
    for test in tests:
        own, at = _own_fitted(test, values)
        if isinstance(at, Failed):
            failed.append(f"test {test.name!r}, which was held out, cannot be compared: {at}")
            continue
        noise = noises(at, 0, coloured=False)
        channels = tuple(_channel(one, of) for one, of in zip(at, noise, strict=True))
        free = {one.name: _free(one, own[one.name]) for one in test.unknowns}
        found.append(TestFit(test.name, kinds[test.name], channels, free, test.found(own)))
    return tuple(found), failed


def _own_fitted(test: Residuals, values: Mapping[str, float]) -> tuple[dict[str, float], tuple[Compared, ...] | Failed]:
    """A test's own unknowns by a few Gauss-Newton steps, the machine as it was found."""
    own = {**values, **{one.name: one.start for one in test.unknowns}}
    (at,) = test.compared([own])
    closed = [one for one in test.unknowns if one.closed]
    for _ in range(5 if closed else 0):
        if isinstance(at, Failed):
            break
        for part in at:
            mine = [one for one in closed if one.name in part.slopes]
            if not mine:
                continue
            slopes = np.column_stack([part.slopes[one.name] for one in mine])
            steps = np.linalg.lstsq(slopes, part.error, rcond=None)[0]
            for one, step in zip(mine, steps, strict=True):
                own[one.name] = float(np.clip(own[one.name] + step, one.low, one.high))
        (at,) = test.compared([own])
    return own, at


def _free(one: Unknown, value: float) -> Identified:
    return Identified(value, None, one.unit, one.start, (one.low, one.high), "", "identified", "of a test held out")


def _correlation(about: Statistics, count: int) -> Array:
    size = np.sqrt(np.diag(about.covariance)[:count])
    found = about.covariance[:count, :count] / np.outer(size, size)
    lost = np.array(about.no_number)
    found[lost], found[:, lost] = np.nan, np.nan
    return np.asarray(found)


def _scenario(file: IdentifyFile, found: Mapping[str, Identified]) -> Any:
    """The machine with what was told of it."""
    return identified_machine(file.machine, found)


def _notes(fit: Fitted, about: Statistics, found: Mapping[str, Identified]) -> list[str]:
    """Warnings a reader must know."""
    notes = []
    if not fit.converged:
        notes.append(f"the fit did not converge in {fit.steps} steps: values and deviations are not the last word")
    if about.robust:
        notes.append(
            "errors are not as their noise model says (coloured, or not as large as stated): deviations follow the "
            "errors themselves"
        )
    for key, one in found.items():
        if one.at_bound:
            notes.append(f"{key} stands at its {one.at_bound} bound: its deviation says little; widen the bounds")
    notes += [
        f"test {test!r}, {name}: comes {1e3 * abs(delay):.2g} ± {1e3 * spread:.1g} ms too "
        f"{'late' if delay > 0.0 else 'early'} beside the others; let its delay be free"
        for test, name, delay, spread in late_channels(fit)
    ]
    return notes
