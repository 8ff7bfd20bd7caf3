"""Third-octave levels over time: how loud floor and machine are in each band, when."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.columns import Picked, Samples, fingerprint, finite, of_each
from ehamj.estimate.bands import Band
from ehamj.estimate.remembered import remembered
from ehamj.estimate.sliding import levels_over_time
from ehamj.judge.isolation import Analysis
from ehamj.judge.levels import BANDS, LEAST_ROWS
from ehamj.plant.axes import AXES

STEP = 0.25
"""Time between two levels [s]: a quarter of the window."""
COLUMNS = 240
"""Most columns of a spectrogram; of a longer run each is the largest of several levels, so that nothing is lost."""


class Run(NamedTuple):
    """What a spectrogram is made of: channels, recording rate [Hz], and from where to where the ground is known."""

    dataset: xr.Dataset
    rate: float
    analysis: Analysis


@dataclass(frozen=True)
class Spectrogram:
    """Sliding 1 s RMS velocities [m/s]; NaN where nothing is known."""

    time: Array
    """Ends of the windows [s], evenly, (t,)."""
    bands: tuple[Band, ...]
    """Without a hole; those at the ends hold something."""
    places: Mapping[str, Array] = field(repr=False)
    """Of each floor, those that are alike once, then of each machine's CG, (bands, t, axis). A floor's are those of the
    mount that moves most along the axis."""

    @property
    def step(self) -> float:
        """Time between two columns [s]."""
        return float(self.time[1] - self.time[0]) if self.time.size > 1 else STEP

    def along(self, axis: str) -> dict[str, Array]:
        """Levels along an axis by place, (bands, t); nothing where next to nothing moves beside the loudest axis."""
        peaks = [np.fmax.reduce(levels, axis=(0, 1), initial=0.0) for levels in self.places.values()]
        k, loudest = AXES.index(axis), np.max(peaks)
        if max(float(peak[k]) for peak in peaks) <= max(LEAST_SHARE * float(loudest), QUIETEST):
            return {}
        return {place: levels[:, :, k] for place, levels in self.places.items()}


LEAST_SHARE = 1e-3
"""Share of the loudest axis' level below which an axis shows only what others leak into it."""
QUIETEST = 1e-9
"""Level below which nobody looks [m/s]."""


_over_time = remembered(8)(levels_over_time)
"""Of one motion: page and replay show the same ones, alone and beside others."""


def spectrogram(runs: Mapping[str, Run]) -> Spectrogram | None:
    """Levels over time of runs by label, on the grid of the first; those with another grid are left out.

    None where no band is known at any time.
    """
    whole = [label for label, run in runs.items() if run.dataset.time.size >= LEAST_ROWS]
    if not whole or whole[0] != next(iter(runs)):
        return None
    first = runs[whole[0]]
    low, high = first.analysis.usable_from_hz, first.analysis.usable_to_hz or np.inf
    chosen = tuple(band for band in BANDS if low <= band.edges[0] and band.edges[1] <= high)
    alike = {
        label: runs[label]
        for label in whole
        if (runs[label].rate, runs[label].dataset.time.size) == (first.rate, first.dataset.time.size)
    }
    floors: dict[str, Samples] = {}
    distinct = set()
    for label, run in alike.items():
        ground = run.dataset["ground_velocity"].variable
        worst = np.argmax(of_each(ground, lambda one: (one**2).sum()), axis=0)
        floor = Picked(ground, [(int(mount), axis) for axis, mount in enumerate(worst)])
        if (told := fingerprint(floor)) not in distinct:
            distinct.add(told)
            floors[f"floor of {label}" if floors else "floor"] = floor
    motions = floors | {label: run.dataset["cg_velocity"].variable for label, run in alike.items()}
    if not chosen or not all(map(finite, motions.values())):
        return None
    over_time = [_over_time(motion, first.rate, chosen, STEP) for motion in motions.values()]
    time, found = over_time[0][0], [levels for _, levels in over_time]
    known = np.flatnonzero(np.any([np.isfinite(levels).any(axis=(1, 2)) for levels in found], axis=0))
    if not known.size:
        return None
    rows, every = slice(int(known[0]), int(known[-1]) + 1), -(-time.size // COLUMNS)
    places = {place: _largest(levels[rows], every) for place, levels in zip(motions, found, strict=True)}
    return Spectrogram(time[::-every][::-1], chosen[rows], places)


def _largest(levels: Array, every: int) -> Array:
    """The largest of so many columns (bands, t, axis) at a time, counted from the end; the first may be of fewer."""
    lead = np.full((levels.shape[0], -levels.shape[1] % every, levels.shape[2]), np.nan)
    padded = np.concatenate([lead, levels], axis=1)
    return np.asarray(np.fmax.reduce(padded.reshape(levels.shape[0], -1, every, levels.shape[2]), axis=2))
