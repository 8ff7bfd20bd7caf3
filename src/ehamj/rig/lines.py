"""Frequency responses measured from nonlinear simulations as on a rig: multisine in, spectra and coherence out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from ehamj.control.channels import UnknownChannelError, channel_row
from ehamj.errors import InputError
from ehamj.plant.axes import DOFS
from ehamj.plant.mounts import MOUNTS
from ehamj.run.simulate import simulate_many
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

PERIOD = 1.0
"""Period of the exciting multisines [s]; their lines are its multiples."""
SETTLING = 2.0
"""Time before the period that is evaluated [s]: the slowest oscillation, near 70 Hz, has then decayed to 1e-11."""


@dataclass(frozen=True)
class Measured:
    """A measured response: ``response`` (frequency, output) over the input, ``coherence`` (frequency, output)."""

    frequency: Array
    """Excited lines [Hz]."""
    outputs: tuple[str, ...]
    response: ComplexArray
    coherence: Array
    """Ordinary coherence over the realisations: 1 where the output is a linear answer to the input."""


def lines(first: float = 1.0, last: float = 300.0, count: int = 40) -> Array:
    """About ``count`` frequencies [Hz] between ``first`` and ``last``, spaced evenly in logarithm, on the line grid."""
    grid = np.unique(np.round(np.geomspace(first, last, count) * PERIOD))
    return grid[grid > 0] / PERIOD


def channel(dataset: xr.Dataset, name: str) -> Array:
    """A named channel of a result as an array (time,); names as in `ehamj.control.channels`."""
    variable, *labels = name.split(" ")
    if variable == "load_pressure":
        pressure = dataset["chamber_pressure"].sel(mount=labels[0])
        return np.asarray(pressure.sel(chamber=1) - pressure.sel(chamber=2))
    values = dataset[variable]
    for dimension, label in zip(values.dims[1:], labels, strict=True):
        values = values.sel({dimension: int(label) if dimension == "chamber" else label})
    return np.asarray(values)


def measure_valves(
    scenario: Scenario,
    outputs: Sequence[str],
    pattern: Sequence[str] = MOUNTS,
    amplitude: float = 0.01,
    frequency: ArrayLike | None = None,
    realisations: int = 4,
) -> Measured:
    """Response of channels to a command given to the valves of ``pattern`` alike.

    Args:
        scenario: what is excited; its ground and control are replaced.
        outputs: channels (`ehamj.control.channels`).
        pattern: mounts whose valves are driven.
        amplitude: of each line [V].
        frequency: excited lines [Hz], multiples of 1/`PERIOD`; `lines` without.
        realisations: runs with different random phases, for the coherence.
    """
    f = lines() if frequency is None else np.asarray(frequency, float)

    def control(phases: Array) -> dict[str, Any]:
        signal = {"kind": "multisine", "mounts": list(pattern), "amplitude": amplitude}
        signal |= {"frequencies": f.tolist(), "phases": phases.tolist()}
        return {"ground": {"kind": "rest"}, "control": {"kind": "open-loop", "signals": [signal]}}

    return _measure(scenario, f, control, f"valve_command {pattern[0]}", outputs, realisations)


def measure_floor(
    scenario: Scenario,
    outputs: Sequence[str],
    dof: str = "z",
    velocity: float = 1e-6,
    frequency: ArrayLike | None = None,
    realisations: int = 4,
) -> Measured:
    """Response of channels to the displacement of a rigid floor in one degree of freedom.

    Args:
        scenario: what is excited; its ground and control are replaced.
        outputs: channels.
        dof: x, y, z, rx, ry or rz of the floor.
        velocity: RMS velocity of each line [m/s or rad/s].
        frequency: see `measure_valves`.
        realisations: see `measure_valves`.

    Raises:
        InputError: if ``dof`` is none.
    """
    if dof not in DOFS:
        raise InputError(f"dof = {dof!r}: must be one of {', '.join(DOFS)}")
    f = lines() if frequency is None else np.asarray(frequency, float)

    def ground(phases: Array) -> dict[str, Any]:
        floor = {"kind": "multisine", "dof": dof, "velocities": [velocity]}
        floor |= {"frequencies": f.tolist(), "phases": phases.tolist()}
        return {"control": {"kind": "passive"}, "ground": floor}

    amplitude = np.sqrt(2.0) * velocity / (2 * np.pi * f)
    return _measure(scenario, f, ground, amplitude, outputs, realisations)


def _measure(
    scenario: Scenario,
    frequency: Array,
    excitation: Any,
    source: str | Array,
    outputs: Sequence[str],
    realisations: int,
) -> Measured:
    """Run the realisations side by side and average spectra; ``source`` is the input's channel, or its amplitudes."""
    for name in outputs:
        try:
            channel_row(name, scenario.plant)
        except UnknownChannelError as error:
            raise InputError(f"output: {error}") from error
    random = [np.random.default_rng([scenario.seed, k]) for k in range(realisations)]
    phases = [generator.uniform(0, 2 * np.pi, frequency.size) for generator in random]
    duration = SETTLING + PERIOD
    runs = simulate_many(excited(scenario, excitation(phase), frequency, duration) for phase in phases)
    x, y = [], []
    for run, phase in zip(runs, phases, strict=True):
        part = run.dataset.sel(time=slice(SETTLING - 1e-9, duration - 0.5 / run.scenario.record_rate))
        index = np.round(frequency * PERIOD).astype(int)
        answer = [line_amplitudes(channel(part, name), index) for name in outputs]
        # A sine of phase φ has the spectral line −j·A·exp(jφ) at the beginning of its period.
        phasor = -1j * np.exp(1j * phase)
        x.append(line_amplitudes(channel(part, source), index) if isinstance(source, str) else source * phasor)
        y.append(np.array(answer).T)
    inputs, answers = np.array(x)[:, :, None], np.array(y)
    cross = (inputs.conj() * answers).sum(axis=0)
    own, other = (np.abs(inputs) ** 2).sum(axis=0), (np.abs(answers) ** 2).sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        coherence = np.abs(cross) ** 2 / (own * other)
    return Measured(frequency, tuple(outputs), cross / own, coherence)


def excited(scenario: Scenario, change: Mapping[str, Any], frequency: Array, duration: float) -> Scenario:
    """The scenario with tables of ``change`` replaced, for ``duration`` [s], recorded fast enough for ``frequency``.

    Raises:
        InputError: if a line is no multiple of 1/`PERIOD`.
    """
    if np.abs(frequency * PERIOD - np.round(frequency * PERIOD)).max() > 1e-9:
        raise InputError(f"frequency: lines must be multiples of {1 / PERIOD:g} Hz")
    rate = 1000.0 * float(np.ceil(max(1000.0, 4.0 * float(frequency.max())) / 1000.0))
    table = scenario.model_dump() | dict(change)
    table |= {"duration": duration, "record_rate": rate, "compare": ()}
    return parse_scenario(table)


def line_amplitudes(signal: Array, index: NDArray[np.int64]) -> ComplexArray:
    """Complex amplitude of each line of a periodic signal, about its mean."""
    return 2.0 / signal.size * np.fft.rfft(signal - signal.mean())[index]
