"""Third-octave levels of floor, feet, machine and points, all from one spectrum of the recorded velocities."""

from dataclasses import dataclass, field

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.criteria.curves import ORDERS, Kind, Quantity
from ehamj.estimate.bands import Band, bands
from ehamj.estimate.periodogram import PowerSpectrum
from ehamj.plant.axes import AXES
from ehamj.plant.levers import plane_fit
from ehamj.plant.plant import Plant

Array = NDArray[np.float64]
ByBand = dict[str, float | None]
"""A level, or a ratio [dB], by the bands' names; None where unknown."""

BANDS = bands(1.0, 315.0)
LEAST_ROWS = 16
"""Recorded rows below which nothing is said."""


def settled(duration: float) -> float:
    """Time from which levels are taken, so that the beginning does not count [s]: a tenth of the run, at most 2 s."""
    return min(2.0, 0.1 * duration)


@dataclass(frozen=True)
class Levels:
    """Levels of a run in the bands that are known, NaN where they are not."""

    bands: tuple[Band, ...]
    ground: Array = field(repr=False)
    """RMS velocity of the ground at each mount, (bands, mount, axis) [m/s]."""
    feet: Array = field(repr=False)
    """RMS velocity of each foot, (bands, mount, axis) [m/s]."""
    floor: dict[str, Array] = field(repr=False)
    """RMS velocity of the floor as a whole: x, y, z [m/s], rx, ry [rad/s], (bands,) each."""
    machine: dict[str, Array] = field(repr=False)
    """The same of the machine."""
    places: dict[Kind, dict[str, Array]] = field(repr=False)
    """By kind at floor (worst mount), feet (worst), machine (CG) and points, SI: RMS (bands, axis), peaks (1, axis)."""

    @property
    def points(self) -> tuple[str, ...]:
        """The named points among the places."""
        return tuple(place for place in self.places["velocity", "rms"] if place not in ("floor", "feet", "machine"))


def levels_of(dataset: xr.Dataset, plant: Plant, rate: float, known: tuple[Band, ...]) -> Levels:
    """Levels of a recorded motion in the bands that are known.

    Args:
        dataset: of a result, without its beginning.
        plant: what was simulated; the mounts' positions count.
        rate: recording rate [Hz].
        known: bands.
    """
    floor, machine = floor_and_machine(dataset, plant)
    signals = {name: dataset[f"{name}_velocity"].values for name in ("ground", "foot", "cg")}
    names = []
    if "point_velocity" in dataset:
        signals["point"] = dataset["point_velocity"].values
        names = [str(name) for name in dataset["point"].values]
    places: dict[Kind, dict[str, Array]] = {("velocity", "peak"): _places(_peaks(signals), names)}
    signals["floor"] = np.column_stack(list(floor.values()))
    signals["turning"] = np.column_stack([machine["rx"], machine["ry"]])
    in_bands = _levels(signals, rate, known)
    places |= {(quantity, "rms"): _places(found, names) for quantity, found in in_bands.items()}
    velocity = in_bands["velocity"]
    return Levels(
        bands=known,
        ground=velocity["ground"],
        feet=velocity["foot"],
        floor=dict(zip(floor, velocity["floor"].T, strict=True)),
        machine=dict(zip(machine, [*velocity["cg"].T, *velocity["turning"].T], strict=True)),
        places=places,
    )


def _places(found: dict[str, Array], points: list[str]) -> dict[str, Array]:
    """Levels (n, axis) at each place: of floor and feet those of the worst mount."""
    places = {"floor": found["ground"].max(axis=1), "feet": found["foot"].max(axis=1), "machine": found["cg"]}
    return places | {name: found["point"][:, k] for k, name in enumerate(points)}


def _peaks(signals: dict[str, Array]) -> dict[str, Array]:
    """Largest absolute value (1, …) of each history (time, …)."""
    few = next(iter(signals.values())).shape[0] < LEAST_ROWS
    return {
        name: np.full((1, *signal.shape[1:]), np.nan) if few else np.abs(signal).max(axis=0, keepdims=True)
        for name, signal in signals.items()
    }


def _levels(signals: dict[str, Array], rate: float, known: tuple[Band, ...]) -> dict[Quantity, dict[str, Array]]:
    """Levels (bands, …) of each quantity, of velocities (time, …) by name; one transform for all."""
    shapes = {name: (len(known), *signal.shape[1:]) for name, signal in signals.items()}
    rows = next(iter(signals.values())).shape[0]
    if rows < LEAST_ROWS:
        return {quantity: {name: np.full(shape, np.nan) for name, shape in shapes.items()} for quantity in ORDERS}
    spectrum = PowerSpectrum.of(np.column_stack([signal.reshape(rows, -1) for signal in signals.values()]), rate)
    ends = np.cumsum([int(np.prod(shape[1:])) for shape in shapes.values()])[:-1]
    found: dict[Quantity, dict[str, Array]] = {}
    for quantity, order in ORDERS.items():
        parts = np.split(spectrum.band_rms(known, order), ends, axis=1)
        found[quantity] = {name: part.reshape(shapes[name]) for name, part in zip(shapes, parts, strict=True)}
    return found


def floor_and_machine(dataset: xr.Dataset, plant: Plant) -> tuple[dict[str, Array], dict[str, Array]]:
    """Velocity of the floor as a whole and of the machine, for x, y, z [m/s] and rx, ry [rad/s], shape (time,) each.

    The floor's translation is the mean of the mounts, its rotation that of the plane fitted to them.
    """
    ground = dataset["ground_velocity"].values
    cg, turning = dataset["cg_velocity"].values, dataset["machine_velocity"].values
    plane = ground[:, :, AXES.index("z")] @ plane_fit(plant.positions).T
    floor = {axis: ground[:, :, k].mean(axis=1) for k, axis in enumerate(AXES)}
    floor |= {"rx": plane[:, 1], "ry": plane[:, 2]}
    machine = {axis: cg[:, k] for k, axis in enumerate(AXES)} | {"rx": turning[:, 3], "ry": turning[:, 4]}
    return floor, machine


def named(levels: Array, chosen: tuple[Band, ...]) -> ByBand:
    """Levels by the bands' names, None where unknown."""
    found: ByBand = {band.name: None for band in BANDS}
    found |= {band.name: float(level) for band, level in zip(chosen, levels, strict=True) if np.isfinite(level)}
    return found
