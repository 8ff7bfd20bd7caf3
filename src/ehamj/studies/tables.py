"""Tables that several studies share."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from ehamj.linear.machine import LinearModel
from ehamj.linear.modes import modes
from ehamj.studies.outcome import labelled


def modes_table(models: Mapping[str, LinearModel]) -> xr.Dataset:
    """Modes of motion by system and number, lowest first: ``name``, ``frequency`` [Hz], ``damping`` [-]."""
    found = {name: [mode for mode in modes(model) if mode.machine_moves] for name, model in models.items()}
    most = max(map(len, found.values()))
    frequency, damping = np.full((2, len(found), most), np.nan)
    names = np.full((len(found), most), "", dtype=object)
    for i, own in enumerate(found.values()):
        for j, mode in enumerate(own):
            names[i, j], frequency[i, j], damping[i, j] = mode.name, mode.frequency, mode.damping_ratio
    over = ("system", "number")
    return xr.Dataset(
        {
            "name": labelled(over, names.astype(str), "", "mode"),
            "frequency": labelled(over, frequency, "Hz", "natural frequency"),
            "damping": labelled(over, damping, "1", "damping ratio"),
        },
        {
            "system": labelled(("system",), list(found), "", "machine"),
            "number": labelled(("number",), np.arange(1, most + 1), "1", "number"),
        },
        {"title": "modes"},
    )
