"""Peak and RMS of every variable of a run."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.columns import columns
from ehamj.findings import finite


def peak_and_rms(dataset: xr.Dataset) -> tuple[dict[str, Any], dict[str, Any]]:
    """Peak and RMS of every variable and channel about its first value, which is the equilibrium; commands about 0.

    States of the controller, and what it learns, are left out: nobody asks for them first.
    """
    peak: dict[str, Any] = {}
    rms: dict[str, Any] = {}
    for name, variable in dataset.data_vars.items():
        if not variable.size or name in ("controller_state", "line_frequency") or str(name).startswith("learnt_"):
            continue
        labels = [[str(label) for label in variable[dimension].values] for dimension in variable.dims[1:]]
        found = [_of_one(one, name != "valve_command") for one in columns(variable.variable)]
        for table, values in zip((peak, rms), zip(*found, strict=True), strict=True):
            table[str(name)] = _nested(np.array(values).reshape(variable.shape[1:]), labels)
    return peak, rms


def _of_one(samples: Array, from_first: bool) -> tuple[float, float]:
    """Peak and RMS of a channel, about its first value or about zero."""
    about = samples - samples[0] if from_first else samples
    with np.errstate(invalid="ignore", over="ignore"):  # where nothing is
        mean = np.einsum("i,i->", about, about) / about.size
        if np.isnan(mean):  # what is not known does not count
            mean = np.nansum(about**2) / np.count_nonzero(~np.isnan(about))
        return float(np.fmax.reduce(np.abs(about))), float(np.sqrt(mean))


def _nested(values: Array, labels: Sequence[Sequence[str]]) -> Any:
    """Labelled numbers as nested dictionaries; a number that is not finite becomes None."""
    if not labels:
        return finite(float(values))
    return {label: _nested(own, labels[1:]) for label, own in zip(labels[0], values, strict=True)}
