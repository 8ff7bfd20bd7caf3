"""Attenuation per third-octave band: the floor's level over that of the machine, of its feet and of its points."""

import numpy as np
from numpy.typing import NDArray

from ehamj.judge.levels import BANDS, ByBand, Levels
from ehamj.plant.axes import AXES
from ehamj.plant.levers import plane
from ehamj.plant.plant import Plant

Array = NDArray[np.float64]

LEAST_SHARE = 0.1
"""Fitted floor motion, over a single mount's, below which an attenuation says nothing."""
NOISE = 1e-13
"""RMS velocity that counts as no motion [m/s]: the rounding of a simulation."""
LEAST_LEVEL = 1e-3
"""Level of a band, over the floor's strongest band, that counts as motion: below, the floor shows only the leakage and
the distortion of what moves elsewhere."""


def attenuation_at_cg(levels: Levels, plant: Plant) -> dict[str, ByBand]:
    """Of the machine's CG and rotation, for x, y, z, rx, ry: band → dB, None where the floor says nothing."""
    return {
        name: _attenuation(levels.floor[name], levels.machine[name], _reference(name, levels, plant), levels)
        for name in levels.floor
    }


def attenuation_at_places(levels: Levels) -> dict[str, dict[str, ByBand]]:
    """For x, y, z at the feet and at each point: band → dB.

    A point is held against the mean of the floor, like the CG; a foot against the ground below it, and the foot counts
    that is worst.
    """
    places = levels.places["velocity", "rms"]
    feet = {axis: _worst_foot(levels, k) for k, axis in enumerate(AXES)}
    points = {
        name: {
            axis: _attenuation(levels.floor[axis], places[name][:, k], _single(levels, k), levels)
            for k, axis in enumerate(AXES)
        }
        for name in levels.points
    }
    return {"feet": feet, **points}


def _worst_foot(levels: Levels, axis: int) -> ByBand:
    ground, feet = levels.ground[:, :, axis], levels.feet[:, :, axis]
    each = [_attenuation(g, f, g, levels) for g, f in zip(ground.T, feet.T, strict=True)]
    worst: ByBand = {}
    for band in BANDS:
        decided = [value for table in each if (value := table[band.name]) is not None]
        worst[band.name] = min(decided, default=None)
    return worst


def _single(levels: Levels, axis: int) -> Array:
    """RMS over the mounts of what a single mount moves along an axis."""
    level: Array = np.sqrt((levels.ground[:, :, axis] ** 2).mean(axis=1))
    return level


def _reference(name: str, levels: Levels, plant: Plant) -> Array:
    """What a single mount makes of this floor motion: RMS over the mounts, over their lever for a rotation."""
    if name in AXES:
        return _single(levels, AXES.index(name))
    heights = plane(plant.positions)[:, ("rx", "ry").index(name) + 1]
    return _single(levels, AXES.index("z")) / np.sqrt((heights**2).mean())


def _attenuation(floor: Array, machine: Array, reference: Array, levels: Levels) -> ByBand:
    strongest = float(np.nanmax(floor, initial=0.0))
    found: ByBand = {band.name: None for band in BANDS}
    for band, below, above, single in zip(levels.bands, floor, machine, reference, strict=True):
        if below > max(NOISE, LEAST_LEVEL * strongest) and below >= LEAST_SHARE * single and above > 0.0:
            found[band.name] = float(20.0 * np.log10(below / above))
    return found
