"""Relative motions of a run: peak, RMS and third-octave levels."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydantic import Field

from ehamj.estimate.periodogram import band_rms
from ehamj.findings import Finding
from ehamj.judge.levels import BANDS, LEAST_ROWS, ByBand, named, settled
from ehamj.plant.axes import AXES
from ehamj.plant.points import Relative

Array = NDArray[np.float64]


class RelativeMotion(Finding):
    """How one place moves relative to another, per axis and in ``total``: the distance moved, all axes together."""

    origin: str = Field(alias="from")
    to: str
    peak: dict[str, float | None]
    """About the first value, over the whole run [m]."""
    rms: dict[str, float | None]
    """About the first value, over the whole run [m]."""
    third_octave_displacement: dict[str, ByBand]
    """RMS [m], from where levels are taken."""


def relative_motions(
    dataset: xr.Dataset, relatives: Sequence[Relative], rate: float, usable_to: float
) -> dict[str, RelativeMotion]:
    """Each relative displacement by name; ``rate`` and ``usable_to`` [Hz] as in `ehamj.judge.isolation`."""
    if not relatives:
        return {}
    moved = dataset["relative_displacement"].values
    end = float(dataset.time[-1]) if dataset.time.size else 0.0
    part = dataset["relative_displacement"].sel(time=slice(settled(end), None)).values
    known = tuple(band for band in BANDS if band.edges[1] <= usable_to)
    levels = np.full((len(known), *part.shape[1:]), np.nan)
    if part.shape[0] >= LEAST_ROWS:
        levels = band_rms(part.reshape(part.shape[0], -1), rate, known).reshape(levels.shape)
    return {
        relative.name: RelativeMotion(
            origin=relative.origin,
            to=relative.to,
            **_peak_and_rms(moved[:, k]),
            third_octave_displacement={
                **{axis: named(levels[:, k, a], known) for a, axis in enumerate(AXES)},
                "total": named(np.sqrt((levels[:, k] ** 2).sum(axis=1)), known),
            },
        )
        for k, relative in enumerate(relatives)
    }


def _peak_and_rms(moved: Array) -> dict[str, dict[str, float | None]]:
    about = moved - moved[:1]
    channels = {**{axis: about[:, k] for k, axis in enumerate(AXES)}, "total": np.sqrt((about**2).sum(axis=1))}
    return {
        "peak": {name: _number(np.abs(channel).max(initial=0.0)) for name, channel in channels.items()},
        "rms": {
            name: _number(np.sqrt((channel**2).mean())) if channel.size else None for name, channel in channels.items()
        },
    }


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
