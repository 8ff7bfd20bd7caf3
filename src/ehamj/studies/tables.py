"""Tables of studies, every column with its unit and what it is."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ehamj.linear.machine import LinearModel
from ehamj.linear.modes import modes
from ehamj.studies.outcome import labelled

Column = tuple[Any, str, str]
"""Values, unit ("" for names and flags) and what they are."""


def table(
    title: str, over: Mapping[str, Column], **variables: Column | tuple[tuple[str, ...], Any, str, str]
) -> xr.Dataset:
    """Variables over all the dimensions ``over``, in this order, or over those of them that stand before the values."""
    return xr.Dataset(
        {
            name: labelled(*column) if len(column) == 4 else labelled(tuple(over), *column)
            for name, column in variables.items()
        },
        {name: labelled((name,), *column) for name, column in over.items()},
        {"title": title},
    )


def modes_table(models: Mapping[str, LinearModel]) -> xr.Dataset:
    """Modes of motion by system and number, lowest first: ``name``, ``frequency`` [Hz], ``damping`` [-]."""
    found = {name: [mode for mode in modes(model) if mode.machine_moves] for name, model in models.items()}
    most = max(map(len, found.values()))
    frequency, damping = np.full((2, len(found), most), np.nan)
    names = np.full((len(found), most), "", dtype=object)
    for i, own in enumerate(found.values()):
        for j, mode in enumerate(own):
            names[i, j], frequency[i, j], damping[i, j] = mode.name, mode.frequency, mode.damping_ratio
    return table(
        "modes",
        {"system": (list(found), "", "machine"), "number": (np.arange(1, most + 1), "1", "number")},
        name=(names.astype(str), "", "mode"),
        frequency=(frequency, "Hz", "natural frequency"),
        damping=(damping, "1", "damping ratio"),
    )
