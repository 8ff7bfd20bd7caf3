"""A scenario's floor as its spectrum: what valves, flows and powers are judged by without a run."""

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from scipy.fft import rfft, rfftfreq

from ehamj.arrays import Array, ComplexArray
from ehamj.estimate.bands import bands
from ehamj.merits.stacked import PER_BAND, hertz_of
from ehamj.plant.axes import AXES
from ehamj.scenario.model import Scenario

RATE: Final = 2500.0
"""At which the floor is sampled [Hz]."""
LONGEST: Final = 60.0
"""Of a longer run so much is looked at [s]."""
RANGE: Final = (0.2, 1000.0)
"""First and last third-octave band that count [Hz]."""
SHARE: Final = 0.99
"""Of the power at a frequency that its columns hold; what is left is shared among them."""


@dataclass(frozen=True)
class FloorSpectrum:
    """The floor's displacement at each mount: at frequencies ``hertz`` (f,) columns (f, mount, 3, column) [m] that move
    by themselves, so that the mean square of what they do adds up."""

    hertz: Array
    columns: ComplexArray

    @classmethod
    def of(cls, scenario: Scenario, highest: float) -> Self:
        """Of a scenario's ground at its mounts, from its run's time, by a Hann window.

        Args:
            scenario: whose duration, seed and mounts count.
            highest: frequency below which all must stay [Hz].
        """
        mounts = len(scenario.plant.mounts)
        time = np.arange(int(min(scenario.duration, LONGEST) * RATE)) / RATE
        moved = scenario.motion().sample(time).below(mounts).velocity.reshape(time.size, -1)
        window = np.hanning(time.size)
        spectrum = rfft(moved * window[:, None], axis=0)[1:]
        frequency = rfftfreq(time.size, 1.0 / RATE)[1:]
        spectrum *= np.sqrt(2.0 / (time.size * (window**2).sum()))  # squares add up to the mean square
        spectrum /= (2j * np.pi * frequency)[:, None]
        chosen = [band for band in bands(*RANGE) if band.edges[1] < highest]
        hertz, edges = hertz_of(chosen), np.array([band.edges for band in chosen])
        between = np.append(
            (edges[:, :1] * (edges[:, 1:] / edges[:, :1]) ** (np.arange(PER_BAND) / PER_BAND)).ravel(), edges[-1, 1]
        )
        cell = np.searchsorted(between, frequency, side="right") - 1
        found = [_columns(spectrum[cell == k]) for k in range(hertz.size)]
        most = max(len(own) for own in found)
        columns = np.zeros((hertz.size, most, mounts * len(AXES)), complex)
        for k, own in enumerate(found):
            columns[k, : len(own)] = own
        shaped = columns.reshape(hertz.size, most, mounts, len(AXES))
        return cls(hertz, np.ascontiguousarray(np.moveaxis(shaped, 1, -1)))


def _columns(spectrum: ComplexArray) -> ComplexArray:
    """Few motions (column, mount·axis) with the power of many bins (bin, mount·axis)."""
    if not np.any(spectrum):
        return np.zeros((0, spectrum.shape[1]), complex)
    _, sizes, right = np.linalg.svd(spectrum, full_matrices=False)
    power = np.cumsum(sizes**2)
    kept = int(np.searchsorted(power, SHARE * power[-1])) + 1
    return np.asarray(sizes[:kept, None] * right[:kept] * np.sqrt(power[-1] / power[kept - 1]))
