"""What a machine has in hand: load of its mounts at rest, supply under load, ranges of strokes and pressures.

Each finding is a sentence that names the mount, the value and the limit, and says what it means.
"""

from collections.abc import Iterator

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.columns import of_each
from ehamj.isolator.supply import Supply
from ehamj.plant.plant import Plant

LEAST_LOAD = 0.1
"""Share of the mean load of the mounts below which one counts as hardly loaded."""
STANDING = 0.5
"""Upward share of a direction above which a mount is one that the machine stands on; level ones need carry nothing."""
LEAST_MEAN, LEAST_EVER = 0.9, 0.8
"""Shares of the set pressure, over the tank's, below which a supply counts as starved: on the mean, and at any time."""
RANGE_USED = 0.9
"""Share of its range from which a stroke or a pressure is worth a word."""

BAR, MILLIMETRE, KILONEWTON = 1e5, 1e-3, 1e3


def reserves(dataset: xr.Dataset, plant: Plant) -> list[str]:
    """In words: mounts that are not loaded at rest, a supply that is starved, ranges that are nearly used up."""
    if not dataset.time.size:
        return []
    return [*_unloaded(dataset, plant), *_starved(dataset, plant.supply), *_strokes(dataset, plant),
            *_pressures(dataset, plant)]  # fmt: skip


def support(dataset: xr.Dataset, plant: Plant) -> Array:
    """Force of oil and membrane on each plate at rest, towards the machine positive [N], (mount,); a run begins in its
    equilibrium."""
    stiffness = np.array([actuator.membrane_stiffness for actuator in plant.actuators])
    return np.asarray(dataset["actuator_force"][0].values - stiffness * dataset["stroke"][0].values)


def _unloaded(dataset: xr.Dataset, plant: Plant) -> Iterator[str]:
    """Mounts that are pulled, or carry next to nothing: a machine that only stands on its mounts lifts off there."""
    lifts = [direction[2] > STANDING for direction in plant.directions]
    mean = plant.total_mass * plant.gravity / max(sum(lifts), 1)
    if mean <= 0.0:
        return
    loads = zip(plant.mounts, support(dataset, plant).tolist(), lifts, strict=True)
    carried = {mount: force for mount, force, stands in loads if stands}
    pulled = {mount: -force for mount, force in carried.items() if force <= 0.0}
    light = {mount: force for mount, force in carried.items() if 0.0 < force < LEAST_LOAD * mean}
    meaning = (
        f"(a mount carries {_newton(mean)} on the mean): a machine that only stands on its mounts lifts off there, "
        "which the model does not do; move mounts or centre of gravity (mount.position, machine.cg), or bolt it down"
    )
    if pulled:
        yield f"mounts are pulled at rest, {_each(pulled)} {meaning}"
    if light:
        yield f"mounts carry less than {100 * LEAST_LOAD:g} % of the mean at rest, {_each(light)} {meaning}"


def _starved(dataset: xr.Dataset, supply: Supply) -> Iterator[str]:
    """A supply with a pump of its own whose pressure falls under load."""
    if not supply.dynamic:
        return
    pressure = dataset["supply_pressure"].values
    shares = (pressure - supply.tank_pressure) / (supply.pressure - supply.tank_pressure)
    mean, row = float(np.nanmean(shares)), int(np.nanargmin(shares))
    if mean >= LEAST_MEAN and shares[row] >= LEAST_EVER:
        return
    left, held = 100.0 * np.sqrt(max(float(shares[row]), 0.0)), float(np.nanmean(pressure)) / BAR
    yield (
        f"the supply is starved: of {supply.pressure / BAR:.4g} bar set it keeps {held:.4g} bar on the mean and "
        f"{pressure[row] / BAR:.4g} bar at least, at {float(dataset.time[row]):.4g} s (less than "
        f"{100 * LEAST_MEAN:g} % on the mean or {100 * LEAST_EVER:g} % at any time counts); there a valve gives "
        f"{left:.2g} % of its flow. A larger pump (supply.pump_flow) or accumulator would hold it"
    )


def _strokes(dataset: xr.Dataset, plant: Plant) -> Iterator[str]:
    """Plates that come near the end of a cylinder; where volumes do not follow the stroke, there is no end."""
    ends = np.array([a.maximum_stroke if a.moving_volume else np.inf for a in plant.actuators])
    peaks = of_each(dataset["stroke"].variable, lambda one: np.fmax.reduce(np.abs(one)))
    k = int(np.argmax(np.nan_to_num(peaks / ends)))
    if peaks[k] >= RANGE_USED * ends[k]:
        yield (
            f"strokes used up to {100 * peaks[k] / ends[k]:.3g} % of their range ({plant.mounts[k]}: "
            f"{peaks[k] / MILLIMETRE:.3g} of {ends[k] / MILLIMETRE:.3g} mm from unloaded membranes): at its end a "
            "chamber is empty, and the run ends"
        )


def _pressures(dataset: xr.Dataset, plant: Plant) -> Iterator[str]:
    """Chambers near the supply's or the tank's pressure: there a valve can drive no more oil in, or out."""
    supply = plant.supply
    middle, half = 0.5 * (supply.pressure + supply.tank_pressure), 0.5 * (supply.pressure - supply.tank_pressure)
    pressure = dataset["chamber_pressure"].variable
    low = np.fmin.reduce(of_each(pressure, np.fmin.reduce), axis=1)
    high = np.fmax.reduce(of_each(pressure, np.fmax.reduce), axis=1)
    used = np.maximum(high - middle, middle - low) / half
    k = int(np.nanargmax(used))
    if used[k] >= RANGE_USED:
        tank, full = supply.tank_pressure / BAR, supply.pressure / BAR
        yield (
            f"chamber pressures used up to {100 * used[k]:.3g} % of the range about the middle between tank and supply "
            f"({plant.mounts[k]}: {low[k] / BAR:.3g} to {high[k] / BAR:.3g} bar, of {tank:.3g} to {full:.3g} bar): "
            "there a valve's flow no longer follows its opening"
        )


def _each(forces: dict[str, float]) -> str:
    return ", ".join(f"{mount} with {_newton(force)}" for mount, force in forces.items())


def _newton(force: float) -> str:
    return f"{force / KILONEWTON:.3g} kN" if abs(force) >= KILONEWTON else f"{force:.3g} N"
