"""Third-octave levels of floor, feet, machine and points, from the recorded velocities."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.columns import Made, Samples, columns, peaks
from ehamj.criteria.curves import ORDERS, Kind
from ehamj.estimate.bands import Band, bands
from ehamj.estimate.counted import Counted, by_column
from ehamj.estimate.reading import Reading, band_rms
from ehamj.estimate.remembered import remembered
from ehamj.estimate.sliding import TIMES, statistics
from ehamj.findings import finite
from ehamj.judge.actuation import PASSIVE, actuation
from ehamj.plant.axes import AXES, DOFS
from ehamj.plant.levers import slab_fit
from ehamj.plant.plant import Plant
from ehamj.records.units import Quantity

ByBand = dict[str, float | None]
"""A level, or a ratio [dB], by the bands' names; None where unknown."""

Positions = Sequence[Sequence[float]]
"""Of the mounts [m]."""

BANDS = bands(1.0, 315.0)
LEAST_ROWS = 16
"""Recorded rows below which nothing is said."""
SLAB: Final = DOFS
"""Motions of the floor as a whole, and of the machine that is held against it: x, y, z, rx, ry, rz."""


def duration_of(dataset: xr.Dataset) -> float:
    """Time of the last row of a run [s]; 0 without any."""
    return float(dataset.time[-1]) if dataset.time.size else 0.0


@dataclass(frozen=True)
class Levels:
    """Levels of a run in the bands that are known, NaN where they are not."""

    bands: tuple[Band, ...]
    floor: Array = field(repr=False)
    """Whole-run RMS velocity of the floor as a whole, (bands, `SLAB`) [m/s, rad/s]."""
    machine: Array = field(repr=False)
    """The same of the machine."""
    places: dict[str, dict[Kind, Array]] = field(repr=False)
    """By kind, SI: in bands (bands, …, axis), peaks of the whole history (1, …, axis); floor and feet have one per
    mount, machine and points not."""
    behind: Array = field(repr=False)
    """RMS velocity of the floor over the whole run behind the filters of the sliding levels, (bands, mount, axis)."""
    mounts: tuple[str, ...]
    seconds: float
    """How long is counted [s]."""
    actuated: Mapping[str, str] = field(default_factory=dict)
    """Directions that are judged, see `ehamj.judge.actuation`, and how the run's commands reach each."""

    def row(self, band: str | None) -> int | None:
        """Where a band lies, by its name; None where it is not known."""
        return next((k for k, one in enumerate(self.bands) if one.name == band), None)

    def loudest(self, place: str, kind: Kind, axis: str, band: str | None) -> int | None:
        """The mount of floor or feet with the largest level of a kind in a band; None of other places and bands."""
        found, row = self.places[place][kind], self.row(band)
        return None if found.ndim < 3 or row is None else int(np.argmax(found[row, :, AXES.index(axis)]))

    def at(self, place: str) -> dict[Kind, Array]:
        """Levels of a place by kind, (n, axis); of floor and feet those of the worst mount."""
        return {kind: found.max(axis=1) if found.ndim > 2 else found for kind, found in self.places[place].items()}


def known_bands(usable_from: float, usable_to: float) -> tuple[Band, ...]:
    """Those of `BANDS` in which a ground is known that is known between two frequencies [Hz]."""
    return tuple(band for band in BANDS if usable_from <= band.edges[0] and band.edges[1] <= usable_to)


def levels_of(
    dataset: xr.Dataset, plant: Plant, rate: float, known: tuple[Band, ...], wanted: Collection[Kind] = ()
) -> Levels:
    """Levels of a recorded motion in the bands that are known.

    Args:
        dataset: of a result, from time 0 on; its beginning counts for peaks only.
        plant: what was simulated; the mounts' positions count.
        rate: recording rate [Hz].
        known: bands.
        wanted: kinds of levels behind filters that are wanted beside those of velocity, which are all taken.
    """
    kinds: list[Kind] = [(q, "rms") for q in ORDERS]
    kinds += [(q, name) for q in ORDERS for name in TIMES if q == "velocity" or (q, name) in wanted]
    places: dict[str, dict[Kind, Array]] = {}
    behind = np.empty(0)
    motions = motions_of(dataset, "velocity")
    for place, velocity in motions.items():
        read = _read_floor if place == "floor" else _read
        tables = read(velocity, rate, known, tuple(kinds))
        places[place] = dict(zip(kinds, tables, strict=False))
        behind = tables[-1] if place == "floor" else behind
        enough = velocity.shape[0] >= LEAST_ROWS
        peak = peaks(velocity) if enough else np.full(velocity.shape[1:], np.nan)
        places[place]["velocity", "peak"] = peak[None]
    turning = rms_in_bands(dataset["machine_velocity"].variable[:, len(AXES) :], rate, known)
    slab = _of_floor(motions["floor"], tuple(map(tuple, plant.positions)), rate, known)
    own = np.hstack([places["machine"]["velocity", "rms"], turning])
    seconds = Counted(len(dataset["time"]), rate).length
    commanded = "valve_command" in dataset and any(map(np.any, columns(dataset["valve_command"].variable)))
    actuated = {name: words if commanded else PASSIVE for name, words in actuation(plant.layout).items()}
    return Levels(known, slab, own, places, behind, plant.mounts, seconds, actuated)


def _read(velocity: Samples, rate: float, known: tuple[Band, ...], kinds: Sequence[Kind]) -> Array:
    """Levels of a velocity (time, …) of each kind, and last its RMS behind the filters, (kinds + 1, bands, …)."""
    counted = Counted(velocity.shape[0], rate)

    def of_one(samples: Array) -> Array:
        reading = Reading.of(samples, counted, known)
        found = np.full((len(kinds) + 1, len(known)), np.nan)
        for quantity, order in ORDERS.items():
            own = [name for name in TIMES if (quantity, name) in kinds]
            rows = [kinds.index((quantity, name)) for name in own]
            if (quantity, "rms") in kinds:
                found[kinds.index((quantity, "rms"))] = reading.rms(known, order)
            if own:
                found[rows], behind = statistics(reading, known, own, order)
                if quantity == "velocity":
                    found[-1] = behind
        return found

    if counted.n - counted.start < LEAST_ROWS:
        return np.full((len(kinds) + 1, len(known), *velocity.shape[1:]), np.nan)
    return by_column(velocity, of_one)


_read_floor = remembered(4)(_read)


class Loudness:
    """RMS levels in bands of one place along one axis at a time, those of `levels_of` to the bit."""

    def __init__(self, dataset: xr.Dataset, plant: Plant, rate: float, known: tuple[Band, ...]) -> None:
        """Arguments as of `levels_of`; of the dataset those channels count that are asked for."""
        self.bands, self.plant = known, plant
        self._dataset, self._rate = dataset, rate
        self._known: dict[tuple[str, str, Quantity], Array] = {}

    def slab(self) -> Array:
        """Velocity of the floor as a whole, (bands, `SLAB`) [m/s, rad/s]."""
        floor = self._dataset["ground_velocity"].variable
        return _of_floor(floor, tuple(map(tuple, self.plant.positions)), self._rate, self.bands)

    def floor(self) -> Array:
        """Velocity of the ground below the mounts, (bands, mount, axis) [m/s]."""
        floor = self._dataset["ground_velocity"].variable
        found: Array = _read_floor(floor, self._rate, self.bands, (("velocity", "rms"),))[0]
        return found

    def machine(self, motion: str) -> Array:
        """Velocity of the machine along one of `SLAB`, (bands,) [m/s, rad/s]."""
        if motion in AXES:
            return self.at("machine", motion)
        turning = self._dataset["machine_velocity"].variable[:, SLAB.index(motion)]
        return rms_in_bands(turning, self._rate, self.bands)

    def at(self, place: str, axis: str, quantity: Quantity = "velocity") -> Array:
        """Of a place of the machine along an axis, (bands,), of feet (bands, mount), SI."""
        key = place, axis, quantity
        if key not in self._known:
            self._known[key] = self._read(*key)
        return self._known[key]

    def _read(self, place: str, axis: str, quantity: Quantity) -> Array:
        own = motions_of(self._dataset, "velocity")[place][..., AXES.index(axis)]
        counted = Counted(own.shape[0], self._rate)
        if counted.n - counted.start < LEAST_ROWS:
            return np.full((len(self.bands), *own.shape[1:]), np.nan)
        return band_rms(own, self._rate, self.bands, ORDERS[quantity])


def motions_of(dataset: xr.Dataset, motion: str) -> dict[str, Samples]:
    """A motion of each place: floor and feet (time, mount, axis), the machine's CG and the points (time, axis)."""
    found = {"floor": "ground", "feet": "foot", "machine": "cg"}
    places: dict[str, Samples] = {
        place: dataset[f"{what}_{motion}"].variable for place, what in found.items() if f"{what}_{motion}" in dataset
    }
    if f"point_{motion}" in dataset:
        of_points = dataset[f"point_{motion}"].variable
        places |= {str(name): of_points[:, k] for k, name in enumerate(dataset["point"].values)}
    return places


def _slab(ground: Samples, positions: Positions) -> Made:
    """`floor_as_whole` of samples of any length, as it is asked for."""
    return Made((ground.shape[0], len(SLAB)), lambda rows: _as_whole(np.asarray(ground[rows]), positions))


def floor_as_whole(ground: Array, plant: Plant) -> Array:
    """Motion (time, `SLAB`) of the floor of the mounts' (time, mount, axis): its translation is their mean, its
    rotation that of the rigid slab whose six motions fit them best.

    Where all mounts stand at one height roll and pitch are those of the plane that fits their heights best, and yaw
    comes from what they do along x and y alone.
    """
    return _as_whole(ground, plant.positions)


def _as_whole(ground: Array, positions: Positions) -> Array:
    fit = slab_fit(positions)[len(AXES) :].reshape(len(AXES), *ground.shape[1:])
    turning = np.tensordot(ground, fit, axes=((1, 2), (1, 2)))
    return np.hstack([ground.mean(axis=1), turning])


def rms_in_bands(signal: Samples, rate: float, known: tuple[Band, ...]) -> Array:
    """Whole-run RMS in bands (bands, …) of a signal (time, …), its beginning not counted; NaN of too few rows."""
    counted = Counted(signal.shape[0], rate)
    if counted.n - counted.start < LEAST_ROWS:
        return np.full((len(known), *signal.shape[1:]), np.nan)
    return band_rms(signal, rate, known)


@remembered(4)
def _of_floor(ground: Samples, positions: Positions, rate: float, known: tuple[Band, ...]) -> Array:
    """Levels of the floor as a whole (bands, `SLAB`), from the mounts' velocities."""
    return rms_in_bands(_slab(ground, positions), rate, known)


def by_band(levels: Array, known: tuple[Band, ...], labels: Iterable[str] = AXES) -> dict[str, ByBand]:
    """Levels (bands, label) by label and by the bands' names, None where unknown."""
    unknown: ByBand = dict.fromkeys(band.name for band in BANDS)
    names = [band.name for band in known]
    return {
        label: unknown | dict(zip(names, map(finite, column), strict=True))
        for label, column in zip(labels, levels.T, strict=True)
    }
