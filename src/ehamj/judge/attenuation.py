"""Attenuation per third-octave band: the floor's level over that of the machine, of its feet and of its points."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.estimate.bands import Band
from ehamj.judge.levels import SLAB, ByBand, Levels, Loudness, by_band
from ehamj.plant.axes import AXES
from ehamj.plant.levers import levers
from ehamj.plant.plant import Plant

LEAST_SHARE = 0.1
"""Fitted floor motion, over a single mount's, below which an attenuation says nothing."""
NOISE = 1e-13
"""RMS velocity that counts as no motion [m/s]: the rounding of a simulation."""
LEAST_LEVEL = 1e-3
"""Level of a band, over the floor's strongest band, that counts as motion: below, the floor shows only the leakage and
the distortion of what moves elsewhere."""
SHOWN_BANDS: Final = ("2", "5", "10", "20", "50", "100")
"""Third-octave bands whose attenuation is named [Hz]."""


def quiet_bands(levels: Mapping[str, float | None]) -> str:
    """Attenuation in a few bands, in words; empty where every one is undecided."""
    known = {band: level for band in SHOWN_BANDS if (level := levels.get(band)) is not None}
    return ", ".join(f"{round(level)} dB at {band} Hz" for band, level in known.items())  # round has no minus zero


def attenuation_at_cg(levels: Levels, plant: Plant) -> dict[str, ByBand]:
    """Of the machine's CG and rotation, for x, y, z, rx, ry, rz: band → dB, None where the floor says nothing."""
    return attenuation_of(levels.floor, levels.machine, levels.places["floor"]["velocity", "rms"], levels.bands, plant)


def attenuation_along(heard: Loudness, place: str | None, motion: str) -> ByBand:
    """What `attenuation_at_cg` says of one motion, or `attenuation_at_places` of one ``place`` along an axis."""
    k, slab = SLAB.index(motion), heard.slab()
    if place is None:
        single = _single(heard.floor())
        beside = np.hstack([single, _turning(single, heard.plant)])[:, k]
        found = _attenuation(slab[:, k], heard.machine(motion), beside)
    elif place == "feet":
        ground = heard.floor()[:, :, k]
        found = np.fmin.reduce(_attenuation(ground, heard.at(place, motion), ground), axis=1)
    else:
        found = _attenuation(slab[:, k], heard.at(place, motion), _single(heard.floor())[:, k])
    return by_band(found[:, None], heard.bands, (motion,))[motion]


def attenuation_of(
    floor: Array, machine: Array, mounts: Array, known: tuple[Band, ...], plant: Plant
) -> dict[str, ByBand]:
    """The same of levels: of ``floor`` and ``machine`` (bands, `SLAB`), and of the ``mounts`` (bands, mount, axis)."""
    single = _single(mounts)
    return by_band(_attenuation(floor, machine, np.hstack([single, _turning(single, plant)])), known, SLAB)


def _turning(single: Array, plant: Plant) -> Array:
    """The rotations that a single mount's motion (bands, axis) would be if it were nothing else, (bands, 3): of a
    slab that turns by ω mounts move by ω times the arms, root mean square over them, and that fits best. Heights count
    from their mean."""
    places = np.array(plant.positions, float)
    places[:, AXES.index("z")] -= places[:, AXES.index("z")].mean()
    turned = levers(places)[:, len(AXES) :].reshape(-1, len(AXES), len(AXES))  # (mount, axis, rotation)
    arms = np.sqrt((turned**2).mean(axis=0))
    squares = (arms**2).sum(axis=0)
    return np.asarray(single @ np.divide(arms, squares, out=np.zeros_like(arms), where=squares > 0.0))


def attenuation_at_places(levels: Levels) -> dict[str, dict[str, ByBand]]:
    """For x, y, z at the feet and at each point: band → dB.

    A point is held against the mean of the floor, like the CG; a foot against the ground below it, and the foot counts
    that is worst.
    """
    velocity = {place: found["velocity", "rms"] for place, found in levels.places.items()}
    ground, feet = velocity.pop("floor"), velocity.pop("feet")
    del velocity["machine"]
    mean, single = levels.floor[:, : len(AXES)], _single(ground)
    found = {"feet": np.fmin.reduce(_attenuation(ground, feet, ground), axis=1)}
    found |= {point: _attenuation(mean, level, single) for point, level in velocity.items()}
    return {place: by_band(decibel, levels.bands) for place, decibel in found.items()}


def _single(mounts: Array) -> Array:
    """What a single mount makes of the floor's motion, (bands, axis): RMS over the mounts (bands, mount, axis)."""
    return np.asarray(np.sqrt((mounts**2).mean(axis=1)))


def _attenuation(floor: Array, machine: Array, single: Array) -> Array:
    """Floor over machine [dB], (bands, …) like both; NaN where the floor says nothing, beside a ``single`` mount's."""
    least = np.maximum(NOISE, LEAST_LEVEL * np.fmax.reduce(floor, axis=0, initial=0.0))
    says = (floor > least) & (floor >= LEAST_SHARE * single) & (machine > 0.0)
    ratio = np.divide(floor, machine, out=np.full_like(floor, np.nan), where=says)
    return np.asarray(20.0 * np.log10(ratio))
