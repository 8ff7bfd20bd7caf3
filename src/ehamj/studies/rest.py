"""Machines about their rest: what carries them, and their modes with valves held."""

from collections.abc import Mapping

import numpy as np
import xarray as xr

from ehamj.arrays import Array
from ehamj.labels import table
from ehamj.linear.elements import Elements, coordinates
from ehamj.linear.machine import LinearModel
from ehamj.linear.modes import modes
from ehamj.linear.values import Values


def static_forces(model: LinearModel) -> dict[str, Array]:
    """What mounts carry at rest: ``stroke`` [m], ``oil`` and ``membrane``, forces on the plate along the mount, towards
    the machine [N], (mount,)."""
    plant, rest = model.plant, dict(zip(model.states, model.equilibrium.tolist(), strict=True))
    place = np.array([rest[f"displacement {name}"] for name in coordinates(plant)])
    stroke = Elements.of(Values.of(plant), place).stroke
    pressure = np.array([[rest[f"pressure_{k} {mount}"] for k in (1, 2)] for mount in plant.mounts])
    area = np.array([[a.piston_area, a.piston_area * a.area_ratio] for a in plant.actuators])
    stiffness = np.array([actuator.membrane_stiffness for actuator in plant.actuators])
    return {"stroke": stroke, "oil": (pressure * area) @ [1.0, -1.0], "membrane": -stiffness * stroke}


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
