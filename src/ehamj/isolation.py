"""How well the machine is isolated: attenuation per third-octave, and the vibration class of floor and machine."""

from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from ehamj.criteria.third_octave import Band, band_rms, bands
from ehamj.criteria.vc import CLASSES, judge
from ehamj.layout import AXES
from ehamj.parameters import Plant

Array = NDArray[np.float64]

BANDS = bands(1.0, 315.0)
LEAST_SHARE = 0.1
"""Fitted floor motion, over a single mount's, below which an attenuation says nothing."""
NOISE = 1e-13
"""RMS velocity that counts as no motion [m/s]: the rounding of a simulation."""
LEAST_LEVEL = 1e-3
"""Level of a band, over the floor's strongest band, that counts as motion: below, the floor shows only the leakage and
the distortion of what moves elsewhere."""


def settled(duration: float) -> float:
    """Time from which levels are taken, so that the beginning does not count [s]: a tenth of the run, at most 2 s."""
    return min(2.0, 0.1 * duration)


def isolation(dataset: xr.Dataset, plant: Plant, rate: float, usable_to: float = float("inf")) -> dict[str, Any]:
    """Attenuation and criteria of a run, as plain data.

    Args:
        dataset: of a result.
        plant: what was simulated; the mounts' positions count.
        rate: recording rate [Hz].
        usable_to: frequency above which the ground is not known [Hz].

    Returns:
        ``attenuation_db``: per axis and for rx, ry, band → dB (positive: quieter than the floor), None: undecided.
        ``third_octave_velocity``: RMS velocity [m/s] per band and axis, of the floor (worst mount) and machine (CG).
        ``criterion``: class met per axis, of floor and machine, and the verdict in words.
        ``analysis``: from when to when the levels were taken.
    """
    end = float(dataset.time[-1]) if dataset.time.size else 0.0
    begin = settled(end)
    part = dataset.sel(time=slice(begin, None))
    known = tuple(band for band in BANDS if band.edges[1] <= usable_to)
    floor, machine = floor_and_machine(part, plant)
    single = part["ground_velocity"].values
    levels = {name: (_levels(floor[name], rate, known), _levels(machine[name], rate, known)) for name in floor}
    single_levels = {axis: _levels(single[:, :, k], rate, known) for k, axis in enumerate(AXES)}
    attenuation = {name: _attenuation(levels[name], _reference(name, single_levels, plant), known) for name in levels}
    worst = {axis: single_levels[axis].max(axis=1) for axis in AXES}
    at_cg = {axis: levels[axis][1] for axis in AXES}
    return {
        "attenuation_db": attenuation,
        "third_octave_velocity": {
            "floor": {axis: _named(worst[axis], known) for axis in AXES},
            "machine": {axis: _named(at_cg[axis], known) for axis in AXES},
        },
        "criterion": _criterion(worst, at_cg, known),
        "analysis": {"from_s": begin, "to_s": end, "usable_to_hz": usable_to if np.isfinite(usable_to) else None},
    }


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


def _levels(signal: Array, rate: float, chosen: tuple[Band, ...]) -> Array:
    if signal.shape[0] < 16:
        return np.full((len(chosen), *signal.shape[1:]), np.nan)
    return band_rms(signal, rate, chosen)


def _reference(name: str, single: dict[str, Array], plant: Plant) -> Array:
    """What a single mount makes of this floor motion: RMS over the mounts, over a lever for a rotation."""
    axis = name if name in AXES else "z"
    level: Array = np.sqrt((single[axis] ** 2).mean(axis=1))
    if name in AXES:
        return level
    x, y = np.array(plant.positions).T
    lever = np.sqrt(((y if name == "rx" else x) ** 2).mean())
    return level / lever


def _attenuation(levels: tuple[Array, Array], reference: Array, chosen: tuple[Band, ...]) -> dict[str, float | None]:
    floor, machine = levels
    strongest = float(np.nanmax(floor, initial=0.0))
    found: dict[str, float | None] = {band.name: None for band in BANDS}
    for band, below, above, single in zip(chosen, floor, machine, reference, strict=True):
        if below > max(NOISE, LEAST_LEVEL * strongest) and below >= LEAST_SHARE * single and above > 0.0:
            found[band.name] = float(20.0 * np.log10(below / above))
    return found


def _named(levels: Array, chosen: tuple[Band, ...]) -> dict[str, float | None]:
    named: dict[str, float | None] = {band.name: None for band in BANDS}
    named |= {band.name: float(level) for band, level in zip(chosen, levels, strict=True) if np.isfinite(level)}
    return named


def _criterion(floor: dict[str, Array], machine: dict[str, Array], chosen: tuple[Band, ...]) -> dict[str, Any]:
    report: dict[str, Any] = {}
    for who, levels in (("floor", floor), ("machine", machine)):
        verdicts = {axis: judge(levels[axis], chosen) for axis in AXES}
        report[who] = {
            axis: {
                "class": verdict.met,
                "deciding_band_hz": verdict.deciding_band,
                "margin_db": verdict.margin_db,
                "undecided_bands_hz": list(verdict.undecided),
            }
            for axis, verdict in verdicts.items()
        }
        report[who]["worst"] = worst_class([verdict.met for verdict in verdicts.values()])
    report["verdict"] = {
        "vertical": f"{_sentence(report, ('z',))} (actuated)",
        "horizontal": f"{_sentence(report, ('x', 'y'))} (not actuated)",
    }
    return report


def worst_class(classes: list[str | None]) -> str | None:
    """The coarsest of several classes; None (not even the coarsest is met) is worst of all."""
    if None in classes:
        return None
    return min((name for name in classes if name is not None), key=list(CLASSES).index)


def _class_in_words(verdicts: list[dict[str, Any]]) -> str:
    if any(verdict["deciding_band_hz"] is None for verdict in verdicts):
        return "undecided"
    return worst_class([verdict["class"] for verdict in verdicts]) or "worse than workshop"


def _sentence(report: dict[str, Any], axes: tuple[str, ...]) -> str:
    before, after = (_class_in_words([report[who][axis] for axis in axes]) for who in ("floor", "machine"))
    words = f"floor {before}, machine {after}"
    undecided = list(dict.fromkeys(band for axis in axes for band in report["machine"][axis]["undecided_bands_hz"]))
    return words + (f", undecided at {', '.join(undecided)} Hz" if undecided else "")
