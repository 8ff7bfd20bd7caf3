"""Peak and RMS of every variable of a run."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from ehamj.arrays import Array
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
        # One channel after the other in memory: extremes and sums along them are several times as fast.
        about = np.array(variable.values.reshape(variable.shape[0], -1).T, float, order="C")
        if name != "valve_command":
            about -= about[:, :1].copy()
        labels = [[str(label) for label in variable[dimension].values] for dimension in variable.dims[1:]]
        with np.errstate(invalid="ignore", over="ignore"):  # where nothing is
            mean = np.einsum("ij,ij->i", about, about) / about.shape[1]
            if np.isnan(mean).any():  # what is not known does not count
                mean = np.nansum(about**2, axis=1) / np.count_nonzero(~np.isnan(about), axis=1)
        rms[str(name)] = _nested(np.sqrt(mean).reshape(variable.shape[1:]), labels)
        peak[str(name)] = _nested(np.fmax.reduce(np.abs(about), axis=1).reshape(variable.shape[1:]), labels)
    return peak, rms


def _nested(values: Array, labels: Sequence[Sequence[str]]) -> Any:
    """Labelled numbers as nested dictionaries; a number that is not finite becomes None."""
    if not labels:
        return finite(float(values))
    return {label: _nested(own, labels[1:]) for label, own in zip(labels[0], values, strict=True)}
