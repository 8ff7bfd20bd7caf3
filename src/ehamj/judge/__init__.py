"""How well the machine is isolated: attenuation per third-octave, and what norms say of floor, machine and points."""

from typing import Any

import numpy as np
import xarray as xr

from ehamj.criteria.curves import Norm, Quantity
from ehamj.criteria.settings import CriteriaSettings
from ehamj.judge.attenuation import attenuation_at_cg, attenuation_at_places
from ehamj.judge.levels import BANDS, Measured, floor_and_machine, measure, named, settled
from ehamj.judge.verdicts import judged, undecided, worst_class
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant

__all__ = ["floor_and_machine", "isolation", "settled", "worst_class"]


def isolation(
    dataset: xr.Dataset,
    plant: Plant,
    rate: float,
    usable_to: float = float("inf"),
    criteria: CriteriaSettings | None = None,
) -> dict[str, Any]:
    """Attenuation and criteria of a run, as plain data.

    Places are the floor (its worst mount), the feet (the worst), the machine (its CG) and each named point.

    Args:
        dataset: of a result.
        plant: what was simulated; the mounts' positions count.
        rate: recording rate [Hz].
        usable_to: frequency above which the ground is not known [Hz].
        criteria: the norms that judge.

    Returns:
        ``attenuation_db``: per axis and for rx, ry, band → dB (positive: quieter than the floor), None: undecided.
        ``attenuation_at_db``: the same for x, y, z at the feet (worst of foot over its own ground) and each point.
        ``third_octave_velocity``: RMS velocity [m/s] per place, axis and band; ``third_octave_displacement`` [m] and
        ``third_octave_acceleration`` [m/s²] where a norm limits them.
        ``criterion``: by the first norm, class met per axis of floor and machine, and the verdict in words.
        ``criteria``: by each norm, the same for every place.
        ``undecided``: in words, bands that a longer run or a higher recording rate would decide.
        ``analysis``: from when to when the levels were taken.
    """
    criteria = criteria or CriteriaSettings()
    end = float(dataset.time[-1]) if dataset.time.size else 0.0
    begin = settled(end)
    known = tuple(band for band in BANDS if band.edges[1] <= usable_to)
    norms = criteria.chosen()
    measured = measure(dataset.sel(time=slice(begin, None)), plant, rate, known)
    verdicts = {name: judged(norm, measured) for name, norm in norms.items()}
    first = next(iter(verdicts.values()))
    return {
        "attenuation_db": attenuation_at_cg(measured, plant),
        "attenuation_at_db": attenuation_at_places(measured),
        **{f"third_octave_{quantity}": _tables(measured, quantity) for quantity in _wanted(list(norms.values()))},
        "criterion": {**{who: first["places"][who] for who in ("floor", "machine")}, "verdict": first["verdict"]},
        "criteria": verdicts,
        "undecided": undecided(norms, end - begin, rate, usable_to),
        "analysis": {"from_s": begin, "to_s": end, "usable_to_hz": usable_to if np.isfinite(usable_to) else None},
    }


def _wanted(norms: list[Norm]) -> list[Quantity]:
    """Velocity, and what else the norms limit."""
    limited = {
        limit.quantity
        for norm in norms
        for name in norm.classes
        for axis in AXES
        for band in BANDS
        if (limit := norm.limit(name, axis, band)) is not None
    }
    return [quantity for quantity in ("velocity", "displacement", "acceleration") if quantity in {"velocity", *limited}]


def _tables(measured: Measured, quantity: Quantity) -> dict[str, dict[str, dict[str, float | None]]]:
    return {
        place: {axis: named(levels[:, k], measured.bands) for k, axis in enumerate(AXES)}
        for place, levels in measured.places[quantity].items()
    }
