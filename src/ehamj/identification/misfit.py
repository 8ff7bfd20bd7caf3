"""Where the model does not go with the data: channels of which far more is left than their own noise, or what has an
order, and which of the values that were held fixed would explain it.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.file import IdentifyFile
from ehamj.identification.fit import Fitted, Told
from ehamj.identification.held import following, held_values
from ehamj.identification.machine import with_values
from ehamj.identification.outcome import TestFit
from ehamj.identification.problem import Problem
from ehamj.identification.residual import Compared, Failed, real

FAR: Final = 3.0
"""Times its own noise that is left of a channel, from which the model does not go with it."""
EXPLAINS: Final = 0.3
"""Share of what is left that a value must explain to be named."""
AS_WELL: Final = 0.9
"""Of what the best explains, from which another is named beside it."""
TRIED: Final = (-0.45, -0.15, 0.15, 0.45)
"""Changes of a scaled value that are tried."""
BESIDE: Final = 3.0
"""Times that for one which is not looked for by its logarithm, of which one is a quarter of its bounds."""
MOST: Final = 3
"""Values that are named."""
BAND: Final = (0.1, 0.75)
"""Part of the frequencies, over the highest, in which a channel's noise is looked for: above, thinning leaves none."""
QUIET: Final = 0.05
"""Share of these frequencies at which noise is all there is, at least."""
LEAST: Final = 200
"""Samples that tell a channel's noise."""


def misfits(
    file: IdentifyFile, measured: Mapping[str, Any], threads: int | None, problem: Problem, fit: Fitted,
    tests: Sequence[TestFit], say: Told,
) -> Iterator[str]:  # fmt: skip
    """Notes on channels with which the model does not go.

    Args:
        file: that asked.
        measured: measurements in memory.
        threads: that step runs.
        problem: fitted tests and unknowns.
        fit: where it ended.
        tests: what it means, the fitted ones in the problem's order.
        say: called with what is done.
    """
    channels = [channel for test in tests for channel in test.channels]
    sizes = [times_noise(one) for one in fit.at.compared]
    far = [k for k, size in enumerate(sizes) if size > FAR]
    if far:
        say("which of the values that are held would explain what is left")
    for k, (name, channel) in enumerate(zip(fit.at.tests, channels, strict=True)):
        place, white = f"test {name!r}, {channel.name}", channel.whiteness is None or channel.whiteness.white
        if k in far:
            yield f"{place}: what is left is {sizes[k]:.2g} times its own noise; the model does not go with it"
        elif not white:
            yield f"{place}: what is left is not white; the model misses a part"
    if far:
        yield _suspects(file, measured, threads, problem, fit, far)


def times_noise(one: Compared) -> float:
    """RMS of what is left of a channel over its own noise, as that was stated or as its quietest frequencies show it;
    0 where neither is known."""
    if np.isfinite(one.deviation).all() and (one.deviation > 0.0).all():
        return float(np.sqrt(np.mean(np.abs(one.measured - one.predicted) ** 2 / one.deviation**2)))
    floor = noise_floor(np.asarray(one.measured.real)) if one.axis == "time" and len(one.at) >= LEAST else 0.0
    return float(np.sqrt(np.mean(one.error**2))) / floor if floor > 0.0 else 0.0


def noise_floor(samples: Array) -> float:
    """RMS that a channel's white noise has at most, of samples (n,): as its quietest frequencies have it."""
    from scipy.signal import welch

    hertz, density = welch(samples, 1.0, nperseg=min(256, samples.size // 8))
    inside = (hertz > 0.5 * BAND[0]) & (hertz < 0.5 * BAND[1])
    return float(np.sqrt(0.5 * np.quantile(density[inside], QUIET)))


def _suspects(
    file: IdentifyFile, measured: Mapping[str, Any], threads: int | None, problem: Problem, fit: Fitted,
    far: Sequence[int],
) -> str:  # fmt: skip
    """Which of the values that are held would explain what is left of some channels, in words."""
    values = problem.values(fit.point)
    keys = [*(one.name for one in problem.parameters), *problem.held]
    machine = with_values(file.machine, {key: values[key] for key in keys})
    held = held_values(file, machine, keys)
    tests = following(file, machine, (*keys, *(one.name for one in held)), measured, threads)
    larger = Problem(tests, (*problem.parameters, *held), held=problem.held)
    start = {**{one.name: one.start for one in held}, **values}
    base = np.array([one.scaled(start[one.name]) for one in larger.unknowns])
    first = len(problem.parameters)
    moved = [
        (one.name, _moved(base, first + j, step if one.log else BESIDE * step))
        for j, one in enumerate(held)
        for step in TRIED
    ]
    ran = larger.compared([point for _, point in moved])
    tried = [(name, at) for (name, _), at in zip(moved, ran, strict=True) if not isinstance(at, Failed)]
    return _said(fit, far, tried)


def _moved(point: Array, k: int, step: float) -> Array:
    found = point.copy()
    found[k] += step
    return found


def _said(fit: Fitted, far: Sequence[int], tried: Sequence[tuple[str, tuple[Compared, ...]]]) -> str:
    """What a change of a value would explain as far as it goes that way, all that was fitted free to follow; channels
    count alike."""
    over = [1.0 / float(np.linalg.norm(fit.at.compared[k].error)) for k in far]
    error = np.concatenate([size * fit.at.compared[k].error for k, size in zip(far, over, strict=True)])
    slopes = np.concatenate([size * fit.at.slopes[k] for k, size in zip(far, over, strict=True)])
    sizes = np.linalg.norm(slopes, axis=0)
    basis = np.linalg.qr(slopes[:, sizes > 0.0] / sizes[sizes > 0.0])[0]
    shares = dict.fromkeys((name for name, _ in tried), 0.0)
    for name, at in tried:
        parts = (at[k].predicted - fit.at.compared[k].predicted for k in far)
        change = np.concatenate([size * real(part) for part, size in zip(parts, over, strict=True)])
        change = change - basis @ (basis.T @ change)
        power = float(change @ change)
        if power > 0.0 and (along := float(change @ error)) > 0.0:
            shares[name] = max(shares[name], along**2 / power / float(error @ error))
    best = max(shares.values(), default=0.0)
    if best < EXPLAINS:
        return (
            "no change of a single value that is held fixed explains what is left: one is far off, several are, or the "
            "model has not what does it"
        )
    names = sorted((name for name in shares if shares[name] >= AS_WELL * best), key=lambda name: -shares[name])
    told = " or ".join(names[:MOST])
    return f"{told}, held fixed, would explain {100.0 * best:.2g} % of what is left of these: look for it as well"
