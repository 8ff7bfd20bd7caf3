"""How large a test may be: limits of the valve and of the machine, held by the peaks that the linear model predicts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from ehamj.arrays import Array, ComplexArray
from ehamj.errors import InputError
from ehamj.linear.machine import LinearModel
from ehamj.rig.low_peak import LowPeak
from ehamj.settings import Positive, Settings

SAMPLES: Final = 8
"""Samples per period of the highest line in which peaks are looked for."""
SWING: Final = 0.5
"""Share of the way from the chambers' mean to tank or supply that pressures may go: beyond it the flow is far from
linear in the opening."""
STROKE: Final = 0.1
"""Share of the stroke at which a chamber is empty that a piston may go."""


class Limits(Settings):
    """What no test may exceed."""

    voltage: Positive = Field(10.0, description="peak of a command [V]")
    stroke: Positive | None = Field(
        None, description="peak of a piston's stroke; without: a tenth of that at which a chamber is empty [m]"
    )
    force: Positive = Field(2000.0, description="peak of a hammer's, a shaker's or a held force [N]")


@dataclass(frozen=True)
class Reach:
    """The largest multiple of a set of signals that stays within all limits, and the limit that it comes to."""

    factor: float
    limit: str


def reach(model: LinearModel, played: Mapping[str, LowPeak], limits: Limits) -> Reach:
    """How many times as large commands may be.

    Args:
        model: linear machine about its rest.
        played: multisines of one period by the channel ``valve_command MOUNT`` [V].
        limits: what the user allows; the valves' own ranges, spools, drives and pressures count beside it.

    Raises:
        InputError: if a mount has no valve that obeys.
    """
    plant, mounts = model.plant, model.plant.mounts
    period = next(iter(played.values())).period
    harmonics = np.unique(np.concatenate([one.harmonics for one in played.values()]))
    amplitudes = np.zeros((harmonics.size, len(mounts)), complex)
    for name, one in played.items():
        at = mounts.index(name.split(" ", 1)[1])
        if mounts[at] not in plant.obeying.mounts:
            raise InputError(f"plan.candidates: mount {mounts[at]!r} is passive; there is no valve to command")
        amplitudes[np.searchsorted(harmonics, one.harmonics), at] = -1j * one.amplitudes * np.exp(1j * one.phases)
    outputs = _watched(mounts)
    answers = (model.response(harmonics / period, outputs, model.commands) @ amplitudes[:, :, None])[..., 0]
    peaks = dict(zip(outputs, _peaks(answers, harmonics), strict=True))
    commands = _peaks(amplitudes, harmonics)
    spools = answers[:, [outputs.index(f"spool {mount}") for mount in mounts]]
    middle = 0.5 * (plant.supply.pressure - plant.supply.tank_pressure)
    found: list[tuple[float, str]] = []
    for k, (mount, own) in enumerate(zip(mounts, plant.actuators, strict=True)):
        drive = own.valve_frequency**2 * _peaks(own.valve_gain * amplitudes[:, [k]] - spools[:, [k]], harmonics)[0]
        stroke = STROKE * own.maximum_stroke if limits.stroke is None else limits.stroke
        found += [
            (_over(limits.voltage, commands[k]), "limits.voltage"),
            (_over(own.voltage_limit, commands[k]), "voltage_limit"),
            (_over(own.spool_stroke, peaks[f"spool {mount}"]), "spool_stroke"),
            (_over(own.spool_drive_limit, drive), "spool_drive_limit"),
            (_over(stroke, peaks[f"stroke {mount}"]), "stroke"),
            *((_over(SWING * middle, peaks[f"chamber_pressure {mount} {c}"]), "chamber pressure") for c in (1, 2)),
        ]
    return Reach(*min(found))


def _watched(mounts: Sequence[str]) -> list[str]:
    names = [f"{what} {mount}" for what in ("spool", "stroke") for mount in mounts]
    return names + [f"chamber_pressure {mount} {chamber}" for mount in mounts for chamber in (1, 2)]


def _over(limit: float, peak: float) -> float:
    return float("inf") if peak == 0.0 else float(limit / peak)


def _peaks(lines: ComplexArray, harmonics: NDArray[np.int64]) -> Array:
    """Peaks of periodic signals from their lines (f, signal)."""
    size = int(2 ** np.ceil(np.log2(SAMPLES * int(harmonics[-1]))))
    spectrum = np.zeros((size // 2 + 1, lines.shape[1]), complex)
    spectrum[harmonics] = 0.5 * size * lines
    return np.asarray(np.abs(np.fft.irfft(spectrum, size, axis=0)).max(axis=0))
