"""The inputs of a test as lines of a spectrum: commands, motion of the ground, forces."""

from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.identification.planning.trial import Excitation, Trial
from ehamj.linear.machine import FORCES, LinearModel, grounds
from ehamj.scenario.model import Scenario

NEGLIGIBLE: Final = 1e-7
"""Share of the largest line below which one is rounding."""
MOST_LINES: Final = 500
"""Lines from which neighbours are taken together."""
BANDS: Final = 300
"""Bands, evenly spaced in logarithm, that they are taken together in: 2 % wide over two decades and a half."""
TAPER: Final = 0.1
"""Share of a random signal at each end that is faded, so that the ends meet."""
AT_REST: Final = 1e-6
"""Frequency at which a machine is as at rest [Hz]; at zero an oil column without leakage has no answer."""


def excitation_of(trial: Trial, rate: float) -> Excitation:
    """What a test drives the machine with, as lines; of one of the course ``nonlinear`` there is none."""
    if trial.course == "rest":
        loads = np.array(trial.loads)
        # Against the machine unloaded, whose reading has the same noise: half of what two readings tell.
        amplitudes = loads.T[None].astype(complex)
        return Excitation(np.array([AT_REST]), np.array([trial.compared]), amplitudes, FORCES)
    scenario = trial.scenario
    first, last = round(trial.settle * rate), round(scenario.duration * rate)
    time = np.arange(first, last) / rate
    inputs, signals = _signals(scenario, time)
    if trial.course == "random":
        signals = signals * _taper(time.size)[:, None]
    lines = 2.0 / time.size * np.fft.rfft(signals, axis=0)[1:]
    frequency = np.arange(1, len(lines) + 1) * rate / time.size
    inside = (np.abs(lines) > NEGLIGIBLE * np.abs(lines).max(initial=1e-300)).any(axis=1) & (frequency < 0.45 * rate)
    frequency, lines = frequency[inside], lines[inside]
    if frequency.size <= MOST_LINES:
        weights = np.full(frequency.size, trial.compared)
        return Excitation(frequency, weights, lines[:, :, None], inputs)
    return _banded(frequency, lines, trial.compared, inputs)


def _signals(scenario: Scenario, time: Array) -> tuple[tuple[str, ...], Array]:
    """Names of the raw inputs that are not zero, and their samples (time, input)."""
    names: list[str] = []
    found: list[Array] = []
    for mount, signal in zip(scenario.plant.mounts, scenario.commands(), strict=True):
        names.append(f"valve_command {mount}")
        found.append(signal.sample(time).value)
    motion = scenario.motion()
    if not motion.at_rest:
        mounts = scenario.plant.mounts
        moved = motion.sample(time).below(len(mounts)).displacement.reshape(time.size, -1)
        names += [f"ground_displacement {place}" for place in grounds(mounts)]
        found += list(moved.T)
    for k, signal in enumerate(scenario.load().signals):
        names.append(f"load {k}")
        found.append(signal.sample(time).value)
    used = [k for k, values in enumerate(found) if values.any()]
    samples = np.array([found[k] for k in used]).reshape(len(used), time.size)
    return tuple(names[k] for k in used), samples.T


def _taper(size: int) -> Array:
    edge = max(1, round(TAPER * size))
    ramp = 0.5 * (1.0 - np.cos(np.pi * (np.arange(edge) + 0.5) / edge))
    return np.concatenate([ramp, np.ones(size - 2 * edge), ramp[::-1]])


def _banded(frequency: Array, lines: ComplexArray, duration: float, inputs: tuple[str, ...]) -> Excitation:
    """Neighbouring lines taken together: of each band the matrix of powers, as experiments that have it together."""
    edges = np.geomspace(frequency[0] * (1 - 1e-9), frequency[-1] * (1 + 1e-9), BANDS + 1)
    numbers = np.digitize(frequency, edges) - 1
    centres, parts = [], []
    for band in np.unique(numbers):
        own = lines[numbers == band]
        power = (np.abs(own) ** 2).sum(axis=1)
        centres.append(float((power * frequency[numbers == band]).sum() / power.sum()))
        values, vectors = np.linalg.eigh(own.T @ own.conj())
        parts.append(vectors * np.sqrt(np.maximum(values, 0.0)))
    return Excitation(np.array(centres), np.full(len(centres), duration), np.array(parts), inputs)


def into_model(inputs: tuple[str, ...], scenario: Scenario, model: LinearModel, hertz: Array) -> ComplexArray:
    """Inputs of the linear model per raw input, (f, model input, raw input): the ground's velocity with its
    displacement, forces at their places."""
    found = np.zeros((hertz.size, len(model.inputs), len(inputs)), complex)
    patterns = scenario.load().patterns
    at_force = len(model.inputs) - len(FORCES)
    for k, name in enumerate(inputs):
        if name.startswith("load "):
            found[:, at_force:, k] = patterns[int(name.removeprefix("load "))]
            continue
        found[:, model.inputs.index(name), k] = 1.0
        if name.startswith("ground_displacement"):
            velocity = model.inputs.index(name.replace("_displacement", "_velocity"))
            found[:, velocity, k] = 2j * np.pi * hertz
    return found
