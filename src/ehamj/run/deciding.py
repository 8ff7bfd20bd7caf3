"""Whether the valves' limit, and not the law, made the verdict: commands that were clipped when it counted."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.columns import column
from ehamj.control import LinearController
from ehamj.criteria.verdict import WHOLE
from ehamj.estimate.sliding import averaging_time, levels_over_time
from ehamj.judge.levels import BANDS, motions_of
from ehamj.judge.verdicts import Criterion
from ehamj.plant.axes import AXES
from ehamj.plant.plant import Plant

STEP = 0.05
"""Between the windows that are compared [s]."""
SECOND = 1.0
"""Around a peak that decides [s]."""


class Window(NamedTuple):
    """From when to when the machine is loudest where its verdict is decided [s]."""

    begin: float
    end: float


def clipped_when_it_counts(
    dataset: xr.Dataset, plant: Plant, rate: float, criterion: Criterion, law: LinearController | None
) -> list[str]:
    """In words: mounts whose command was clipped in the second that decides the machine's verdict.

    Args:
        dataset: of a result.
        plant: what was simulated.
        rate: recording rate [Hz].
        criterion: what the first norm says.
        law: that ran, whose converter has a range of its own; None without, or of a Python function.
    """
    if criterion.decisive is None or not dataset.time.size:
        return []
    worst = criterion.decisive.verdict.worst
    axis, which = AXES.index(worst.axis), "overall" if criterion.decisive.overall else "vertical"
    band = worst.verdict.deciding_band
    if band is None:
        return []
    velocity = motions_of(dataset, "velocity")[worst.place]
    own: list[tuple[int, ...]] = [(axis,)]
    if len(velocity.shape) > 2:  # one per mount
        mounts = range(len(plant.mounts)) if worst.mount is None else [plant.mounts.index(worst.mount)]
        own = [(k, axis) for k in mounts]
    at = max(own, key=lambda one: float(np.abs(column(velocity, *one)).max())) if len(own) > 1 else own[0]
    window = deciding(column(velocity, *at), rate, band)
    if window is None:
        return []
    limit = np.array([actuator.voltage_limit for actuator in plant.actuators])
    if law is not None:
        limit = np.minimum(limit, law.converter.voltage_limit)
    command = dataset["valve_command"].sel(time=slice(window.begin, window.end)).values
    share = (np.abs(command) >= limit).mean(axis=0) if len(command) else np.zeros(limit.size)
    k = int(np.argmax(share))
    if share[k] <= 0.0:
        return []
    where = "the peak" if band == WHOLE else f"the band at {band} Hz"
    return [
        f"the command was clipped when it counted: at {plant.mounts[k]} for {100 * share[k]:.3g} % of the time from "
        f"{window.begin:.4g} to {window.end:.4g} s, where {where} is loudest that decides the machine's {which} "
        f"verdict (range ±{limit[k]:g} V); there the valve sets the class, and not the law"
    ]


def deciding(velocity: Array, rate: float, band: str) -> Window | None:
    """Where the machine's level is largest in a band, or about its peak; None where the level is not known.

    Args:
        velocity: along the axis (n,) [m/s].
        rate: recording rate [Hz].
        band: that decides, by its name, or `WHOLE`.
    """
    if band == WHOLE:
        peak = float(np.argmax(np.abs(velocity))) / rate
        return Window(peak - 0.5 * SECOND, peak + 0.5 * SECOND)
    chosen = tuple(one for one in BANDS if one.name == band)
    time, levels = levels_over_time(velocity, rate, chosen, STEP)
    if not np.isfinite(levels).any():
        return None
    end = float(time[int(np.nanargmax(levels[0]))])
    return Window(end - averaging_time(chosen[0], "max_1s"), end)
