"""Parts of a run, each judged by itself: from a row to another."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from ehamj.columns import Samples, columns, of_each, peaks
from ehamj.criteria.curves import Norm
from ehamj.findings import finite
from ehamj.judge.faults import Phase, Pressures
from ehamj.judge.isolation import isolation
from ehamj.judge.levels import LEAST_ROWS, motions_of
from ehamj.judge.verdicts import strongest_second
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant
from ehamj.run.limits import WORDS, reached

LEAD = 1.0
"""Time before a transient that its judgement begins with [s]: levels leave out the beginning of what they are given."""


def part_of(dataset: xr.Dataset, begin: float, end: float) -> xr.Dataset:
    """The rows from a time on and before another [s], with their own clock from 0 on."""
    time = dataset.time.values
    rows = slice(int(np.searchsorted(time, begin - 1e-9)), int(np.searchsorted(time, end - 1e-9)))
    found = dataset.isel(time=rows)
    return found.assign_coords(time=found.time - (found.time[0] if found.time.size else 0.0))


def phase(
    dataset: xr.Dataset, plant: Plant, rate: float, span: tuple[float, float], norms: Mapping[str, Norm],
    usable: tuple[float, float], transient: bool = False,
) -> Phase | None:  # fmt: skip
    """What a part of a run says; None where it has too few rows.

    Args:
        dataset: of the whole result.
        plant: what was simulated.
        rate: recording rate [Hz].
        span: from when to when [s].
        norms: that judge.
        usable: from where to where the ground is known [Hz].
        transient: judge by the largest sliding 1 s RMS, with `LEAD` before it.
    """
    begin, end = span
    own = part_of(dataset, begin, end)
    if own.time.size < LEAST_ROWS:
        return None
    name, norm = next(iter(norms.items()))
    second = strongest_second(norm) if transient else None
    judged = part_of(dataset, max(begin - LEAD, 0.0), end) if transient else own
    found, _ = isolation(judged, plant, rate, usable[1], {name: second or norm}, usable[0])
    at_rest = dataset["stroke"].variable[0].values
    strokes = zip(columns(own["stroke"].variable), at_rest, strict=True)
    stroke = np.array([np.abs(one - at).max() for one, at in strokes])
    shares: dict[str, dict[str, float]] = {limit: {} for limit in WORDS}
    for k, mount in enumerate(plant.mounts):
        for limit, states in reached(own, plant, k).items():
            shares[limit][mount] = float(states.mean())
    lowest, highest = (of_each(own["chamber_pressure"].variable, extreme) for extreme in (np.min, np.max))
    return Phase(
        from_s=begin,
        to_s=end,
        criterion=found.criterion,
        attenuation_db=found.attenuation_db["z"],
        peak_velocity={place: _peaks(velocity) for place, velocity in motions_of(own, "velocity").items()},
        stroke=dict(zip(plant.mounts, map(finite, stroke.tolist()), strict=True)),
        pressure={
            mount: Pressures(lowest=finite(float(lowest[k].min())), highest=finite(float(highest[k].max())))
            for k, mount in enumerate(plant.mounts)
        },
        saturation=shares,
    )


def _peaks(velocity: Samples) -> dict[str, float | None]:
    """Per axis, of several mounts the largest; velocity (time, …, axis)."""
    found = peaks(velocity).reshape(-1, len(AXES)).max(axis=0)
    return dict(zip(AXES, map(finite, found.tolist()), strict=True))
