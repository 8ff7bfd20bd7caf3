"""Third-octave levels of floor, feet, machine and points, all from one spectrum of the recorded velocities."""

from dataclasses import dataclass, field

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.criteria.curves import ORDERS, Quantity
from ehamj.estimate.bands import Band, bands
from ehamj.estimate.periodogram import PowerSpectrum
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant

Array = NDArray[np.float64]

BANDS = bands(1.0, 315.0)
LEAST_ROWS = 16
"""Recorded rows below which nothing is said."""


def settled(duration: float) -> float:
    """Time from which levels are taken, so that the beginning does not count [s]: a tenth of the run, at most 2 s."""
    return min(2.0, 0.1 * duration)


@dataclass(frozen=True)
class Measured:
    """Levels per band, NaN where unknown."""

    bands: tuple[Band, ...]
    ground: Array = field(repr=False)
    """RMS velocity of the ground at each mount, (bands, mount, axis) [m/s]."""
    feet: Array = field(repr=False)
    """RMS velocity of each foot, (bands, mount, axis) [m/s]."""
    floor: dict[str, Array] = field(repr=False)
    """RMS velocity of the floor as a whole: x, y, z [m/s], rx, ry [rad/s], (bands,) each."""
    machine: dict[str, Array] = field(repr=False)
    """The same of the machine."""
    places: dict[Quantity, dict[str, Array]] = field(repr=False)
    """RMS per quantity at floor (worst mount), feet (worst), machine (CG) and points, (bands, axis) each, SI."""


def measure(dataset: xr.Dataset, plant: Plant, rate: float, known: tuple[Band, ...]) -> Measured:
    """Levels of a recorded motion in the bands that are known.

    Args:
        dataset: of a result, without its beginning.
        plant: what was simulated; the mounts' positions count.
        rate: recording rate [Hz].
        known: bands.
    """
    floor, machine = floor_and_machine(dataset, plant)
    signals = {name: dataset[f"{name}_velocity"].values for name in ("ground", "foot", "cg")}
    if "point_velocity" in dataset:
        signals["point"] = dataset["point_velocity"].values
    signals["floor"] = np.column_stack(list(floor.values()))
    signals["turning"] = np.column_stack([machine["rx"], machine["ry"]])
    levels = _levels(signals, rate, known)
    places: dict[Quantity, dict[str, Array]] = {}
    for quantity, found in levels.items():
        places[quantity] = {"floor": found["ground"].max(axis=1), "feet": found["foot"].max(axis=1)}
        places[quantity]["machine"] = found["cg"]
        if "point" in found:
            places[quantity] |= {str(name): found["point"][:, k] for k, name in enumerate(dataset["point"].values)}
    velocity = levels["velocity"]
    return Measured(
        bands=known,
        ground=velocity["ground"],
        feet=velocity["foot"],
        floor=dict(zip(floor, velocity["floor"].T, strict=True)),
        machine=dict(zip(machine, [*velocity["cg"].T, *velocity["turning"].T], strict=True)),
        places=places,
    )


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
    fit = np.linalg.pinv(np.array([[1.0, y, -x] for x, y in plant.positions]))
    plane = ground[:, :, AXES.index("z")] @ fit.T
    floor = {axis: ground[:, :, k].mean(axis=1) for k, axis in enumerate(AXES)}
    floor |= {"rx": plane[:, 1], "ry": plane[:, 2]}
    machine = {axis: cg[:, k] for k, axis in enumerate(AXES)} | {"rx": turning[:, 3], "ry": turning[:, 4]}
    return floor, machine


def named(levels: Array, chosen: tuple[Band, ...]) -> dict[str, float | None]:
    """Levels by the bands' names, None where unknown."""
    found: dict[str, float | None] = {band.name: None for band in BANDS}
    found |= {band.name: float(level) for band, level in zip(chosen, levels, strict=True) if np.isfinite(level)}
    return found
