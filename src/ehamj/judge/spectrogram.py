"""Third-octave levels over time: how loud floor and machine are in each band, when."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.estimate.bands import Band
from ehamj.estimate.sliding import levels_over_time
from ehamj.judge.isolation import Analysis
from ehamj.judge.levels import BANDS, LEAST_ROWS

STEP = 0.25
"""Time between two levels [s]: a quarter of the window."""
COLUMNS = 240
"""Most columns of a spectrogram; of a longer run each is the largest of several levels, so that nothing is lost."""


@dataclass(frozen=True)
class Spectrogram:
    """Sliding 1 s RMS velocities [m/s] of floor and machine; NaN where nothing is known."""

    time: Array
    """Ends of the windows [s], evenly, (t,)."""
    bands: tuple[Band, ...]
    """Without a hole; those at the ends hold something."""
    levels: Mapping[str, Array] = field(repr=False)
    """Of ``floor`` (in each band at its worst mount) and ``machine`` (its CG), (bands, t, axis)."""

    @property
    def step(self) -> float:
        """Time between two columns [s]."""
        return float(self.time[1] - self.time[0]) if self.time.size > 1 else STEP

    def beside(self, others: Mapping[str, "Spectrogram | None"]) -> Iterator[tuple[str, Array]]:
        """Floors, those that are alike once, then machines by label; without those on another grid than this one."""
        alike = {
            label: one
            for label, one in others.items()
            if one is not None and np.array_equal(one.time, self.time) and one.bands == self.bands
        }
        floors: list[Array] = []
        for label, one in alike.items():
            floor = one.levels["floor"]
            if not any(np.array_equal(floor, known, equal_nan=True) for known in floors):
                floors.append(floor)
                yield "floor" if len(floors) == 1 else f"floor of {label}", floor
        for label, one in alike.items():
            yield label, one.levels["machine"]


def spectrogram(dataset: xr.Dataset, rate: float, analysis: Analysis) -> Spectrogram | None:
    """Levels over time of a run; None where no band is known at any time.

    Args:
        dataset: of a result.
        rate: recording rate [Hz].
        analysis: of its summary: from where to where the ground is known.
    """
    low, high = analysis.usable_from_hz, analysis.usable_to_hz or np.inf
    chosen = tuple(band for band in BANDS if low <= band.edges[0] and band.edges[1] <= high)
    motions = {"floor": dataset["ground_velocity"].values, "machine": dataset["cg_velocity"].values}
    if not chosen or len(motions["machine"]) < LEAST_ROWS:
        return None
    levels = {}
    for place, velocity in motions.items():
        time, found = levels_over_time(velocity, rate, chosen, STEP)
        levels[place] = found.max(axis=2) if place == "floor" else found
    known = np.isfinite(levels["machine"]).any(axis=(1, 2))
    if not known.any():
        return None
    rows = slice(int(np.argmax(known)), len(chosen) - int(np.argmax(known[::-1])))
    every = -(-time.size // COLUMNS)
    thinned = {place: _largest(found[rows], every) for place, found in levels.items()}
    return Spectrogram(time[::-every][::-1], chosen[rows], thinned)


def _largest(levels: Array, every: int) -> Array:
    """The largest of so many columns (bands, t, axis) at a time, counted from the end; the first may be of fewer."""
    lead = np.full((levels.shape[0], -levels.shape[1] % every, levels.shape[2]), np.nan)
    padded = np.concatenate([lead, levels], axis=1)
    return np.asarray(np.fmax.reduce(padded.reshape(levels.shape[0], -1, every, levels.shape[2]), axis=2))
