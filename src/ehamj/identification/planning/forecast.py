"""What a test tells of the unknowns: its lines and their derivatives against the noise of its channels."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.identification.planning.information import without
from ehamj.identification.planning.instruments import Instruments

Free = Literal["gain", "delay"]
"""What of each channel nobody knows in a test, beside its offset, which is never counted on."""


@dataclass(frozen=True)
class Lines:
    """What channels do in a test, at each line, and how that depends on the unknowns.

    ``values`` (f, channel, experiment, 1 + k), complex amplitudes and their derivatives in the scaled unknowns;
    ``weights`` (f,) [s] and experiments see `ehamj.identification.planning.trial.Excitation`.
    """

    frequency: Array
    weights: Array
    values: ComplexArray


def told_by(lines: Lines, instruments: Instruments, longest: float, free: Sequence[Free] = ()) -> Array:
    """Information of a test on the unknowns, (k, k), what is ``free`` in each channel fitted beside them.

    Args:
        lines: of the test.
        instruments: that read it.
        longest: time of the test [s]; noise is not asked for slower than once in it.
        free: of each channel.
    """
    hertz = np.maximum(lines.frequency, 1.0 / longest)
    seen = lines.values * instruments.response(hertz)[:, :, None, None]
    density = instruments.density(hertz, rms_of(lines, instruments, longest))
    seen = seen * np.sqrt(lines.weights[:, None] / np.where(density > 0.0, density, np.inf))[:, :, None, None]
    columns = [seen[..., 1:], *(_nuisances(kind, lines.frequency, seen[..., 0]) for kind in free)]
    slopes = np.concatenate(columns, axis=-1).reshape(-1, sum(part.shape[-1] for part in columns))
    return without((slopes.conj().T @ slopes).real, lines.values.shape[-1] - 1)


def rms_of(lines: Lines, instruments: Instruments, longest: float) -> Array:
    """RMS of each channel's reading in a test of so long [s], (channel,)."""
    seen = lines.values[..., 0] * instruments.response(np.maximum(lines.frequency, 1.0 / longest))[:, :, None]
    power = (lines.weights[:, None] * (np.abs(seen) ** 2).sum(axis=2)).sum(axis=0) / longest
    return np.asarray(np.sqrt(0.5 * power))


def _nuisances(kind: Free, hertz: Array, values: ComplexArray) -> ComplexArray:
    """Derivatives of all channels in the gain or the delay of each, (f, channel, experiment, channel)."""
    shape = (*values.shape, values.shape[1])
    found = np.zeros(shape, complex)
    factor = 1.0 if kind == "gain" else -2j * np.pi * hertz[:, None]
    for channel in range(values.shape[1]):
        found[:, channel, :, channel] = factor * values[:, channel]
    return found
