"""Sensitivities of a test's outputs by the nonlinear engine, whose neighbours step side by side."""

from collections.abc import Sequence

import numpy as np

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.identification.machine import with_values
from ehamj.identification.planning.forecast import Lines
from ehamj.identification.planning.linear import Neighbours
from ehamj.identification.planning.trial import Trial
from ehamj.identification.residual import Failed
from ehamj.identification.runs import histories, with_step
from ehamj.identification.unknowns import Unknown, Values

WIDE = 1e-2
"""Half of a central difference, in the scaled unknown."""
WIDER = 5e-2
"""The same where an unknown stands at a bound, as an option that is off does: how it begins."""


def run_of(
    trial: Trial,
    unknowns: Sequence[Unknown],
    at: Values,
    channels: Sequence[str],
    rate: float,
    threads: int | None = None,
) -> Lines:
    """The lines of a test, simulated at the point and two neighbours of each unknown.

    Args:
        trial: the test, not one at rest.
        unknowns, at: where.
        channels: wanted.
        rate: samples per second [Hz].
        threads: by default one for each processor.

    Raises:
        InputError: if a scenario cannot be run, or a run stops.
    """
    near = neighbours(unknowns, at)
    recorded = with_step(trial.scenario.model_copy(update={"record_rate": rate, "engine": "small-motion"}))
    found = histories([with_values(recorded, point) for point in near.points], channels, threads)
    for one in found:
        if isinstance(one, Failed):
            raise InputError(f"{trial.name}: {one}")
    signals = np.array([[one[name] for name in channels] for one in found if not isinstance(one, Failed)])
    return _lines(trial, signals.transpose(0, 2, 1), near.widths, rate)


def neighbours(unknowns: Sequence[Unknown], at: Values) -> Neighbours:
    """Points about one, farther from those that stand at a bound."""
    edge = [one for one in unknowns if one.scaled(at[one.name]) in one.limits]
    plain, wide = Neighbours.of(unknowns, at, WIDE), Neighbours.of(unknowns, at, WIDER)
    points, widths = list(plain.points), plain.widths.copy()
    for k, one in enumerate(unknowns):
        if one in edge:
            points[1 + 2 * k : 3 + 2 * k] = wide.points[1 + 2 * k : 3 + 2 * k]
            widths[k] = wide.widths[k]
    return Neighbours(tuple(points), widths)


def _lines(trial: Trial, signals: Array, widths: Array, rate: float) -> Lines:
    """Spectral lines of the outputs over the compared time, the constant left to the channel's offset.

    ``signals`` (1 + 2k, time, channel).
    """
    first = round(trial.settle * rate)
    part = signals[:, first:-1] if signals.shape[1] > first + 2 else signals
    slopes = (part[2::2] - part[1::2]) / widths[:, None, None]
    together = np.concatenate([part[:1] - part[0, 0], slopes])
    size = together.shape[1]
    spectrum = 2.0 / size * np.fft.rfft(together, axis=1)[:, 1:]
    frequency = np.arange(1, spectrum.shape[1] + 1) * rate / size
    values = np.moveaxis(spectrum, 0, -1)[:, :, None, :]
    return Lines(frequency, np.full(frequency.size, size / rate), values)
