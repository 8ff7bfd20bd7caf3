"""Attenuation per third-octave band: the floor's level over that of the machine, of its feet and of its points."""

import numpy as np
from numpy.typing import NDArray

from ehamj.estimate.bands import Band
from ehamj.judge.levels import BANDS, Measured
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant

Array = NDArray[np.float64]
Decibels = dict[str, float | None]

LEAST_SHARE = 0.1
"""Fitted floor motion, over a single mount's, below which an attenuation says nothing."""
NOISE = 1e-13
"""RMS velocity that counts as no motion [m/s]: the rounding of a simulation."""
LEAST_LEVEL = 1e-3
"""Level of a band, over the floor's strongest band, that counts as motion: below, the floor shows only the leakage and
the distortion of what moves elsewhere."""


def attenuation_at_cg(measured: Measured, plant: Plant) -> dict[str, Decibels]:
    """Of the machine's CG and rotation, for x, y, z, rx, ry: band → dB, None where the floor says nothing."""
    return {
        name: _attenuation(measured.floor[name], measured.machine[name], _reference(name, measured, plant), measured)
        for name in measured.floor
    }


def attenuation_at_places(measured: Measured) -> dict[str, dict[str, Decibels]]:
    """For x, y, z at the feet and at each point: band → dB.

    A point is held against the mean of the floor, like the CG; a foot against the ground below it, and the foot counts
    that is worst.
    """
    places = measured.places["velocity"]
    feet = {axis: _worst_foot(measured, k) for k, axis in enumerate(AXES)}
    points = {
        name: {
            axis: _attenuation(measured.floor[axis], levels[:, k], _single(measured, k), measured)
            for k, axis in enumerate(AXES)
        }
        for name, levels in places.items()
        if name not in ("floor", "feet", "machine")
    }
    return {"feet": feet, **points}


def _worst_foot(measured: Measured, axis: int) -> Decibels:
    ground, feet = measured.ground[:, :, axis], measured.feet[:, :, axis]
    each = [_attenuation(g, f, g, measured) for g, f in zip(ground.T, feet.T, strict=True)]
    worst: Decibels = {}
    for band in BANDS:
        decided = [value for table in each if (value := table[band.name]) is not None]
        worst[band.name] = min(decided, default=None)
    return worst


def _single(measured: Measured, axis: int) -> Array:
    """RMS over the mounts of what a single mount moves along an axis."""
    level: Array = np.sqrt((measured.ground[:, :, axis] ** 2).mean(axis=1))
    return level


def _reference(name: str, measured: Measured, plant: Plant) -> Array:
    """What a single mount makes of this floor motion: RMS over the mounts, over a lever for a rotation."""
    if name in AXES:
        return _single(measured, AXES.index(name))
    x, y = np.array(plant.positions).T
    lever = np.sqrt(((y if name == "rx" else x) ** 2).mean())
    return _single(measured, AXES.index("z")) / lever


def _attenuation(floor: Array, machine: Array, reference: Array, measured: Measured) -> Decibels:
    chosen: tuple[Band, ...] = measured.bands
    strongest = float(np.nanmax(floor, initial=0.0))
    found: Decibels = {band.name: None for band in BANDS}
    for band, below, above, single in zip(chosen, floor, machine, reference, strict=True):
        if below > max(NOISE, LEAST_LEVEL * strongest) and below >= LEAST_SHARE * single and above > 0.0:
            found[band.name] = float(20.0 * np.log10(below / above))
    return found
