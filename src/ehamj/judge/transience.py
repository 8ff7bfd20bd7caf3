"""Whether a floor is transient: whether its largest second exceeds what stationary noise has by chance."""

from typing import Final

import numpy as np
import xarray as xr
from pydantic import Field

from ehamj.arrays import Array
from ehamj.columns import Samples, column, columns, digest
from ehamj.estimate.bands import Band
from ehamj.estimate.counted import Counted
from ehamj.estimate.reading import Reading
from ehamj.estimate.remembered import remembered
from ehamj.estimate.sliding import averaging_time
from ehamj.estimate.stationarity import chance, largest_by_chance, shares, white
from ehamj.findings import Finding
from ehamj.judge.attenuation import LEAST_LEVEL, NOISE
from ehamj.judge.levels import Levels, motions_of
from ehamj.plant.axes import AXES

ONCE_IN: Final = 1000
"""Stationary Gaussian floors of which one is called transient, all bands, axes and mounts together."""


class Transience(Finding):
    """The strongest of the seconds by which a floor exceeds what stationary Gaussian noise has by chance."""

    band: str = Field(alias="band_hz")
    axis: str
    max_1s: float
    """Largest sliding 1 s RMS velocity [m/s]."""
    rms: float
    """RMS velocity over the whole run behind the same filter [m/s]."""
    by_chance: float
    """What stationary noise of that band, spectrum and duration exceeds once in a thousand runs [m/s]."""

    def in_words(self) -> str:
        """As a warning."""
        times, chance = self.max_1s / self.rms, self.by_chance / self.rms
        return (
            f"the floor is transient: along {self.axis} in the {self.band} Hz band its largest second is "
            f"{1e6 * self.max_1s:.3g} µm/s, {times:.2g} times the whole run's RMS; stationary noise of that band and "
            f"duration stays below {chance:.2g} times in {ONCE_IN - 1} runs of {ONCE_IN}"
        )


def transience(dataset: xr.Dataset, levels: Levels, rate: float) -> Transience | None:
    """The band and axis where the floor's largest second is strongest, of those in which it is no chance.

    None where it is nowhere, or nothing is known.

    Bands far below the floor's strongest do not count: there it shows only the leakage of what moves elsewhere.
    """
    velocity = motions_of(dataset, "velocity")["floor"]
    return _strongest(velocity, levels.behind, levels.places["floor"]["velocity", "max_1s"], levels.bands, rate)


@remembered(4)
def _strongest(
    velocity: Samples, behind: Array, largest: Array, known: tuple[Band, ...], rate: float
) -> Transience | None:
    """Of a floor's velocity (time, mount, axis), RMS and largest second in bands (bands, mount, axis)."""
    least = np.maximum(NOISE, LEAST_LEVEL * np.fmax.reduce(behind, axis=0, initial=0.0))
    says = (behind > least) & np.isfinite(largest)
    if not says.any():
        return None
    ratio = np.divide(largest, behind, out=np.zeros_like(behind), where=says) ** 2
    counted = Counted(velocity.shape[0], rate)
    separate = len(set(map(digest, columns(velocity))))
    probability = 1.0 / ONCE_IN / (says.any(axis=(1, 2)).sum() * separate)
    found: list[Transience] = []
    for axis, name in enumerate(AXES):
        readings: dict[int, Reading] = {}
        for row, band in enumerate(known):
            windows = counted.length / averaging_time(band, "max_1s")
            mount = int(np.argmax(ratio[row, :, axis]))
            r = float(ratio[row, mount, axis])
            if chance(r, white(band), windows) > probability:
                continue  # noise of a narrower spectrum has it more often
            if mount not in readings:
                readings = {mount: Reading.of(column(velocity, mount, axis), counted, known)}
            own = shares(readings[mount].spectra[band], band)
            if chance(r, own, windows) > probability:
                continue
            rms = float(behind[row, mount, axis])
            by_chance = rms * float(np.sqrt(largest_by_chance(probability, own, windows)))
            strongest = float(largest[row, mount, axis])
            found.append(Transience(band=band.name, axis=name, max_1s=strongest, rms=rms, by_chance=by_chance))
    return max(found, key=lambda one: one.max_1s, default=None)
