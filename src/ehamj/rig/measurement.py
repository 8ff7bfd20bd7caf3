"""What a virtual measurement gives, and how signals are taken from a run."""

from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.estimate.spectra import Estimate


@dataclass(frozen=True)
class Measurement:
    """A measured transmissibility: its estimate, outputs (channels) and inputs (degrees of freedom of the floor)."""

    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    estimate: Estimate
    method: str
    """How it was measured, in words."""

    def within(self, first: float, last: float) -> "Measurement":
        """The part of it from ``first`` to ``last`` [Hz]."""
        e = self.estimate
        kept = (e.frequency >= first) & (e.frequency <= last)
        arrays = {name: getattr(e, name)[kept] for name in ("frequency", "response", "radius", "multiple", "ordinary")}
        return replace(self, estimate=replace(e, **arrays))


def channel(dataset: xr.Dataset, name: str) -> Array:
    """A named channel of a result as an array (time,); names as in `ehamj.control.channels`."""
    variable, *labels = name.split(" ")
    if variable == "load_pressure":
        pressure = dataset["chamber_pressure"].sel(mount=labels[0])
        return np.asarray(pressure.sel(chamber=1) - pressure.sel(chamber=2))
    values = dataset[variable]
    for dimension, label in zip(values.dims[1:], labels, strict=True):
        values = values.sel({dimension: int(label) if dimension == "chamber" else label})
    return np.asarray(values)
