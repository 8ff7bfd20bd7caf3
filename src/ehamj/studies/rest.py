"""Machines about their rest: what carries them, and their modes with valves held."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.labels import table
from ehamj.linear.machine import LinearModel
from ehamj.linear.modes import modes
from ehamj.plant.axes import DOFS
from ehamj.views.statics import loads_at


def static_forces(model: LinearModel) -> dict[str, Array]:
    """What mounts carry at rest: ``stroke`` [m], ``oil`` and ``membrane``, forces on the plate along the mount, towards
    the machine [N], (mount,)."""
    plant, rest = model.plant, dict(zip(model.states, model.equilibrium.tolist(), strict=True))
    moved = np.array([rest[f"displacement {dof}"] for dof in DOFS])
    pressures = [np.array([rest[f"pressure_{k} {mount}"] for mount in plant.mounts]) for k in (1, 2)]
    loads = loads_at(plant, moved, *pressures)
    return {"stroke": loads.stroke, "oil": loads.oil, "membrane": loads.along - loads.oil}


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
