"""Transmissibility measured from nonlinear simulations: with multisines in all directions at once, or from a run.

Multisine: the floor moves in its q degrees of freedom together, in q experiments whose phases make the inputs
orthogonal at every line (Dobrowiecki, Schoukens & Guillaume, IEEE Trans. Instrum. Meas. 55, 2006: phases of a Fourier
matrix), and again for each realisation of random phases. What differs between realisations is distortion and noise.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.control import LinearController
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.errors import InputError
from ehamj.estimate.spectra import Estimate, Estimator, Spectra, estimate, segments
from ehamj.judge import settled
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.modes import modes
from ehamj.linear.response import TURNS, lever_scale, machine_channels, slab_pattern
from ehamj.plant.axes import DOFS
from ehamj.result import Result
from ehamj.rig.lines import PERIOD, channel, excited, line_amplitudes, lines
from ehamj.run.simulate import simulate_many
from ehamj.scenario.model import Scenario

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

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
SEGMENTS: Final = 16
"""Segments, before overlapping, that a run is divided into where no segment is given, unless they would be longer than
`LONGEST_SEGMENT`."""
LONGEST_SEGMENT: Final = 4.0
"""[s]"""
FAINT: Final = 1e-3
"""Amplitude of an input in a line, over the floor's strongest, below which it counts as at rest: there it shows leakage
and rounding alone. Rotations count as motion at the mounts' mean distance."""


@dataclass(frozen=True)
class Measurement:
    """A measured transmissibility: its estimate, outputs (channels) and inputs (degrees of freedom of the floor)."""

    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    estimate: Estimate
    method: str
    """How it was measured, in words."""

    def within(self, first: float, last: float) -> "Measurement":
        """The part of it from ``first`` to ``last`` [Hz]."""
        e = self.estimate
        kept = (e.frequency >= first) & (e.frequency <= last)
        arrays = {name: getattr(e, name)[kept] for name in ("frequency", "response", "radius", "multiple", "ordinary")}
        return replace(self, estimate=replace(e, **arrays))


def by_multisine(
    scenario: Scenario,
    outputs: Sequence[str] = machine_channels(),
    dofs: Sequence[str] = DOFS,
    frequency: ArrayLike | None = None,
    realisations: int = 2,
    velocity: float = LEVEL,
    estimator: Estimator = "h1",
    confidence: float = 0.95,
) -> Measurement:
    """Measure the answer to a rigid floor under the scenario's control, in ``len(dofs)·realisations`` runs.

    Args:
        scenario: what is excited; its ground is replaced.
        outputs: channels of displacement.
        dofs: of the floor, excited together.
        frequency: excited lines [Hz], multiples of 1/`PERIOD`; `lines` without.
        realisations: of the random phases, at least 2.
        velocity: RMS velocity of each line [m/s]; small, since the machine is nonlinear.
        estimator: h1, h2 or hv, see `estimate`.
        confidence: probability of the confidence circles.

    Raises:
        InputError: if an argument is not allowed, or the loop is unstable or hardly damped.
    """
    if realisations < 2:
        raise InputError(f"realisations = {realisations}: must be at least 2, whose differences tell the coherence")
    f = lines() if frequency is None else np.asarray(frequency, float)
    model, controller = linear_model(scenario), scenario.controller()
    slab_pattern(model.plant, dofs)  # says which degrees of freedom there are
    fade_in, settling = settling_time(model, controller, scenario.sensors)
    q, length = len(dofs), lever_scale(model.plant)
    levels = [velocity / length if dof in TURNS else velocity for dof in dofs]
    phases = np.concatenate([_phases(scenario.seed, k, q, f.size) for k in range(realisations)])
    duration = settling + PERIODS * PERIOD
    runs = simulate_many(
        excited(scenario, {"ground": _ground(dofs, f, levels, phase, fade_in)}, f, duration) for phase in phases
    )
    amplitude = np.sqrt(2.0) * np.outer(levels, 1.0 / (2 * np.pi * f))
    # A sine of phase φ has the spectral line −j·A·exp(jφ) at the beginning of its period, which whole periods follow.
    given = (-1j * amplitude * np.exp(1j * phases)).transpose(0, 2, 1)
    given = given * np.exp(2j * np.pi * f * settling)[:, None]
    answers = np.array([_answers(run, outputs, f, settling) for run in runs])
    found = estimate(Spectra.of_lines(f, given, answers), estimator, confidence)
    words = f"multisine of {f.size} lines, {realisations} × {q} experiments, {estimator.upper()}"
    return Measurement(tuple(outputs), tuple(dofs), found, words)


def settling_time(
    model: LinearModel, controller: LinearController | None = None, sensors: Sensors = IDEAL
) -> tuple[float, float]:
    """Time over which multisines begin, and time in which every oscillation has then decayed to `REMAINS`.

    Slow modes (`SLOW`) need not decay; they make the beginning longer.

    Returns:
        Both [s], from the beginning of the run; multiples of 0.1 s.

    Raises:
        InputError: if an oscillation takes longer than `LONGEST_SETTLING`, or one grows.
    """
    found = modes(model, controller, sensors=sensors)
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


def _answers(run: Result, outputs: Sequence[str], frequency: Array, begin: float) -> ComplexArray:
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


def by_welch(
    result: Result,
    pairs: Sequence[tuple[Sequence[str], Sequence[str]]],
    segment: float | None = None,
    per_octave: float = 24.0,
    estimator: Estimator = "h1",
    confidence: float = 0.95,
) -> list[Measurement]:
    """Measure from a stored run, whatever moved its floor; a rigid slab is fitted to the mounts' motion.

    Args:
        result: of a simulation.
        pairs: outputs (channels of displacement) and inputs (degrees of freedom of the floor), each estimated by
            itself: several inputs are told apart only where they move independently.
        segment: length of the Welch segments [s]; without, a `SEGMENTS`-th of the run, at most `LONGEST_SEGMENT`.
        per_octave: bins per octave in which neighbouring lines are averaged.
        estimator: see `estimate`.
        confidence: see `estimate`.

    Raises:
        InputError: if the run is too short for the segment, or an argument is not allowed.
    """
    if result.dataset.time.size < 2:
        raise InputError("result: nothing was recorded, so that there is nothing to measure")
    rate, duration = result.scenario.record_rate, float(result.dataset.time[-1])
    part = result.dataset.sel(time=slice(settled(duration) - 1e-9, None))
    length = part.time.size / rate
    if segment is None:
        segment = min(LONGEST_SEGMENT, length / SEGMENTS)
    pattern = slab_pattern(result.scenario.plant)
    # Velocities: their spectra are flatter than those of displacements, and leak less; the ratio is the same.
    slab = part["ground_velocity"].values.reshape(part.time.size, -1) @ np.linalg.pinv(pattern).T
    channels = list(dict.fromkeys(name for outputs, _ in pairs for name in outputs))
    answers = np.array([channel(part, name.replace("_displacement ", "_velocity ")) for name in channels]).T
    record = segments(np.hstack([slab, answers]), rate, segment)
    lever = np.where(np.isin(DOFS, TURNS), lever_scale(result.scenario.plant), 1.0)
    power = (np.abs(record.lines[:, :, : len(DOFS)]) ** 2).mean(axis=0) * lever**2
    moves = power > FAINT**2 * power.max(initial=0.0)
    found = []
    for outputs, inputs in pairs:
        columns = [DOFS.index(dof) for dof in inputs]
        rows = [len(DOFS) + channels.index(name) for name in outputs]
        spectra = _only(Spectra.of_segments(record, columns, rows), moves[:, columns]).merged(per_octave)
        words = f"Welch, {record.averages:.0f} averages of {segment:.3g} s or more, {estimator.upper()}"
        found.append(Measurement(tuple(outputs), tuple(inputs), estimate(spectra, estimator, confidence), words))
    return found


def _only(spectra: Spectra, moves: NDArray[np.bool_]) -> Spectra:
    """The spectra with inputs set to zero where they do not move, (f, q)."""
    xx = spectra.xx * (moves[:, :, None] & moves[:, None, :])
    return replace(spectra, xx=xx, yx=spectra.yx * moves[:, None, :])
