"""Relative motions of a run: peak, RMS and third-octave levels."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
import xarray as xr
from pydantic import Field

from ehamj.arrays import Array
from ehamj.columns import columns
from ehamj.findings import Finding, finite
from ehamj.judge.levels import BANDS, ByBand, by_band, rms_in_bands
from ehamj.plant.axes import AXES
from ehamj.plant.points import Relative

ALONG = (*AXES, "total")


class RelativeMotion(Finding):
    """How one place moves relative to another, per axis and in ``total``: the distance moved, all axes together."""

    origin: str = Field(alias="from")
    to: str
    peak: dict[str, float | None]
    """About the first value, over the whole run [m]."""
    rms: dict[str, float | None]
    """About the first value, over the whole run [m]."""
    statistic: Literal["rms"] = "rms"
    """Of the levels that follow: RMS over the whole run."""
    third_octave_displacement: dict[str, ByBand]
    """RMS [m]."""


def relative_motions(
    dataset: xr.Dataset, relatives: Sequence[Relative], rate: float, usable_to: float
) -> dict[str, RelativeMotion]:
    """Each relative displacement by name; ``rate`` and ``usable_to`` [Hz] as in `ehamj.judge.isolation`."""
    displacement = dataset["relative_displacement"].variable
    peak, rms = (np.zeros((len(relatives), len(ALONG))) for _ in range(2))
    for k in range(len(relatives)):
        moved = [one - one[:1] for one in columns(displacement[:, k])]
        moved.append(np.sqrt(sum(one**2 for one in moved)))
        peak[k] = [np.abs(one).max(initial=0.0) for one in moved]
        rms[k] = [np.sqrt((one**2).sum() / (one.size or np.nan)) for one in moved]
    known = tuple(band for band in BANDS if band.edges[1] <= usable_to)
    levels = _with_total(rms_in_bands(displacement, rate, known))
    return {
        relative.name: RelativeMotion(
            origin=relative.origin,
            to=relative.to,
            peak=dict(zip(ALONG, map(finite, peak[k]), strict=True)),
            rms=dict(zip(ALONG, map(finite, rms[k]), strict=True)),
            statistic="rms",
            third_octave_displacement=by_band(levels[:, k], known, ALONG),
        )
        for k, relative in enumerate(relatives)
    }


def _with_total(moved: Array) -> Array:
    """The axes (…, 3) and beside them their root of the sum of squares, (…, 4)."""
    return np.concatenate([moved, np.sqrt((moved**2).sum(axis=-1, keepdims=True))], axis=-1)
