"""Sensitivities of a test's outputs by the nonlinear engine, whose neighbours step side by side."""

from collections.abc import Sequence

import numpy as np

from ehamj.arrays import Array
from ehamj.identification.planning.forecast import Lines
from ehamj.identification.planning.linear import Machines, Neighbours
from ehamj.identification.planning.trial import Trial
from ehamj.identification.unknowns import Unknown, Values
from ehamj.rig.measurement import channel
from ehamj.run.many import observe_many
from ehamj.run.simulate import Observed
from ehamj.scenario.model import Scenario

WIDE = 1e-2
"""Half of a central difference, in the scaled unknown."""
WIDER = 5e-2
"""The same where an unknown stands at a bound, as an option that is off does: how it begins."""


def runs_of(
    trials: Sequence[Trial],
    unknowns: Sequence[Unknown],
    at: Values,
    having: Machines,
    channels: Sequence[str],
    rate: float,
    threads: int | None = None,
) -> list[Lines]:
    """The lines of each test, simulated at the point and two neighbours of each unknown.

    Args:
        trials: tests, none at rest.
        unknowns, at: where.
        having: makes scenarios of values.
        channels: wanted.
        rate: samples per second [Hz].
        threads: by default one for each processor.

    Raises:
        Incomplete: if a run stops.
        InputError: if a scenario cannot be run.
    """
    near = neighbours(unknowns, at)
    scenarios = [having(_recorded(trial.scenario, rate), point) for trial in trials for point in near.points]

    def signals(run: Observed) -> Array:
        return np.array([channel(run.dataset, name) for name in channels]).T

    found = observe_many(scenarios, signals, threads)
    size = len(near.points)
    return [
        _lines(trial, np.array(found[k * size : (k + 1) * size]), near.widths, rate) for k, trial in enumerate(trials)
    ]


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


def _recorded(scenario: Scenario, rate: float) -> Scenario:
    return scenario.model_copy(update={"record_rate": rate, "engine": "small-motion"})


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
