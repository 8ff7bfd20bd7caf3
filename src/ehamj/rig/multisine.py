"""Transmissibility measured with multisines in all directions at once.

The floor moves in its q degrees of freedom together, in q experiments whose phases make the inputs orthogonal at every
line (Dobrowiecki, Schoukens & Guillaume, IEEE Trans. Instrum. Meas. 55, 2006: phases of a Fourier matrix), and again
for each realisation of random phases. What differs between realisations is distortion and noise.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.arrays import Array, ComplexArray
from ehamj.errors import InputError
from ehamj.estimate.spectra import Estimator, Spectra, estimate
from ehamj.linear.loop import Loop, linear_under
from ehamj.linear.machine import LinearModel
from ehamj.linear.modes import modes
from ehamj.linear.response import TURNS, lever_scale, machine_channels, slab_pattern
from ehamj.plant.axes import DOFS
from ehamj.rig.measurement import Measurement, channel
from ehamj.run.many import observe_many
from ehamj.run.progress import Progress, counted, silent
from ehamj.run.simulate import Observed
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario

PERIOD: Final = 1.0
"""Period of the exciting multisines [s]; their lines are its multiples."""
REMAINS: Final = 1e-6
"""Share of the beginning's oscillations that may be left when the evaluation begins."""
LONGEST_SETTLING: Final = 30.0
"""Time after which a measurement begins in any case [s]; it is then refused instead."""
FADE_IN: Final = 0.5
"""Time over which the multisines begin, so that integrators of a controller start near their periodic motion [s]."""
SLOW: Final = 0.3 / PERIOD
"""Frequency of a mode below which it is hardly started by multisines that begin over `SLOW_FADE_IN`, and seen as drift
within a period, which is taken out: high-passes of instruments and laws [Hz]."""
SLOW_FADE_IN: Final = 5.0
"""[s]"""
PERIODS: Final = 2
"""Periods that are averaged; the drift between them is taken out."""
LEVEL: Final = 1e-6
"""RMS velocity of each line [m/s]; of a rotation, at the mounts' mean distance from their centre."""


def lines(first: float = 1.0, last: float = 300.0, count: int = 40) -> Array:
    """About ``count`` frequencies [Hz] between ``first`` and ``last``, spaced evenly in logarithm, on the line grid."""
    grid = np.unique(np.round(np.geomspace(first, last, count) * PERIOD))
    return grid[grid > 0] / PERIOD


def by_multisine(
    scenario: Scenario,
    outputs: Sequence[str] = machine_channels(),
    dofs: Sequence[str] = DOFS,
    frequency: ArrayLike | None = None,
    realisations: int = 2,
    velocity: float = LEVEL,
    estimator: Estimator = "h1",
    confidence: float = 0.95,
    progress: Progress = silent,
) -> Measurement:
    """Measure the answer to a rigid floor under the scenario's control, in ``len(dofs)·realisations`` runs.

    Args:
        scenario: what is excited; its ground is replaced.
        outputs: channels (`ehamj.control.channels`).
        dofs: of the floor, excited together.
        frequency: excited lines [Hz], multiples of 1/`PERIOD`; `lines` without.
        realisations: of the random phases, at least 2.
        velocity: RMS velocity of each line [m/s]; small, since the machine is nonlinear.
        estimator: h1, h2 or hv, see `estimate`.
        confidence: probability of the confidence circles.
        progress: hears which run begins.

    Raises:
        InputError: if an argument is not allowed, or the loop is unstable or hardly damped.
    """
    if realisations < 2:
        raise InputError(f"realisations = {realisations}: must be at least 2, whose differences tell the coherence")
    f = lines() if frequency is None else np.asarray(frequency, float)
    law = scenario.controller()
    model, loop = linear_under(scenario.plant, law), Loop.of(scenario, law)
    model.rows(outputs)  # says which channels there are
    slab_pattern(model.plant, dofs)  # says which degrees of freedom there are
    fade_in, settling = settling_time(model, loop)
    q, length = len(dofs), lever_scale(model.plant)
    levels = [velocity / length if dof in TURNS else velocity for dof in dofs]
    phases = np.concatenate([_phases(scenario.seed, k, q, f.size) for k in range(realisations)])
    duration = settling + PERIODS * PERIOD
    cases = (
        excited(scenario, {"ground": _ground(dofs, f, levels, phase, fade_in)}, f, duration)
        for phase in counted(list(phases), progress)
    )
    answers = np.array(observe_many(cases, lambda run: _answers(run, outputs, f, settling)))
    amplitude = np.sqrt(2.0) * np.outer(levels, 1.0 / (2 * np.pi * f))
    # A sine of phase φ has the spectral line −j·A·exp(jφ) at the beginning of its period, which whole periods follow.
    given = (-1j * amplitude * np.exp(1j * phases)).transpose(0, 2, 1)
    given = given * np.exp(2j * np.pi * f * settling)[:, None]
    found = estimate(Spectra.of_lines(f, given, answers), estimator, confidence)
    words = f"multisine of {f.size} lines, {realisations} × {q} experiments, {estimator.upper()}"
    return Measurement(tuple(outputs), tuple(dofs), found, words)


def settling_time(model: LinearModel, loop: Loop | None) -> tuple[float, float]:
    """Time over which multisines begin, and time in which every oscillation has then decayed to `REMAINS`.

    Slow modes (`SLOW`) need not decay; they make the beginning longer.

    Returns:
        Both [s], from the beginning of the run; multiples of 0.1 s.

    Raises:
        InputError: if an oscillation takes longer than `LONGEST_SETTLING`, or one grows.
    """
    found = modes(model, loop)
    counting = [mode for mode in found if mode.frequency >= SLOW or mode.damping_ratio <= 0.0]
    fade_in = FADE_IN if len(counting) == len(found) else SLOW_FADE_IN
    slowest = min(counting, key=lambda mode: mode.damping_ratio * mode.frequency)
    decay = 2 * np.pi * slowest.damping_ratio * slowest.frequency
    if decay * LONGEST_SETTLING < -math.log(REMAINS):
        raise InputError(
            f"control: the mode {slowest.name} at {slowest.frequency:.4g} Hz has a damping ratio of "
            f"{slowest.damping_ratio:.3g}; a measurement needs oscillations that decay within {LONGEST_SETTLING:g} s"
        )
    return fade_in, fade_in + math.ceil(10.0 * -math.log(REMAINS) / decay) / 10.0


def _phases(seed: int, realisation: int, inputs: int, lines: int) -> Array:
    """Phases [rad] of each experiment, input and line, (q, q, lines): random, and orthogonal between experiments."""
    random = np.random.default_rng([seed, realisation]).uniform(0, 2 * np.pi, (inputs, lines))
    turns = np.outer(np.arange(inputs), np.arange(inputs)) / inputs
    return np.asarray(random[None] + 2 * np.pi * turns[:, :, None])


def _ground(
    dofs: Sequence[str], frequency: Array, levels: Sequence[float], phases: Array, fade_in: float
) -> dict[str, Any]:
    parts = [
        {"kind": "multisine", "dof": dof, "frequencies": frequency.tolist(), "velocities": [level],
         "phases": phase.tolist(), "fade_in": fade_in}
        for dof, level, phase in zip(dofs, levels, phases, strict=True)
    ]  # fmt: skip
    return parts[0] if len(parts) == 1 else {"kind": "sum", "parts": parts}


def _answers(run: Observed, outputs: Sequence[str], frequency: Array, begin: float) -> ComplexArray:
    """Lines of each output over the last periods, (f, output)."""
    size = round(PERIOD * run.scenario.record_rate)
    first = round(begin * run.scenario.record_rate)
    part = run.dataset.isel(time=slice(first, first + PERIODS * size))
    index = np.round(frequency * PERIOD).astype(int)
    ramp = np.arange(size) / size - 0.5
    found = []
    for name in outputs:
        periods = channel(part, name).reshape(PERIODS, size)
        drift = (periods[-1] - periods[0]).mean() / (PERIODS - 1)
        found.append(line_amplitudes(periods.mean(axis=0) - drift * ramp, index))
    return np.array(found).T


def excited(scenario: Scenario, change: Mapping[str, Any], frequency: Array, duration: float) -> Scenario:
    """The scenario with tables of ``change`` replaced, for ``duration`` [s], recorded fast enough for ``frequency``.

    Raises:
        InputError: if a line is no multiple of 1/`PERIOD`.
    """
    if np.abs(frequency * PERIOD - np.round(frequency * PERIOD)).max() > 1e-9:
        raise InputError(f"frequency: lines must be multiples of {1 / PERIOD:g} Hz")
    rate = 1000.0 * float(np.ceil(max(1000.0, 4.0 * float(frequency.max())) / 1000.0))
    bare = {"compare": (), "fault": (), "slide": tuple(slide.standing for slide in scenario.slide)}
    return changed(scenario, {**change, **bare, "duration": duration, "record_rate": rate})


def line_amplitudes(signal: Array, index: NDArray[np.int64]) -> ComplexArray:
    """Complex amplitude of each line of a periodic signal, about its mean."""
    return 2.0 / signal.size * np.fft.rfft(signal - signal.mean())[index]
