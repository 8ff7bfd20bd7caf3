"""ehamj's channels of a run by their names, as `ehamj.control.channels` writes them."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from ehamj.arrays import Array
from ehamj.control.channels import ALONG, SUPPLY, UnknownChannelError, check_channel
from ehamj.errors import InputError
from ehamj.plant.axes import AXES, CHAMBERS, DOFS
from ehamj.plant.plant import Plant

UNSEEN: Final = ("edges", "ground_displacement upstream", "ground_velocity upstream", "ground_acceleration upstream")
"""What no run records."""


def check_seen(name: str, plant: Plant, said: str) -> None:
    """Refuse a channel that a run has no history of; ``said`` is what the message begins with.

    Raises:
        InputError: saying what is near, or why.
    """
    if name.startswith("valve_command ") and name.split(" ", 1)[1] in plant.mounts:
        return
    try:
        check_channel(name, plant.mounts)
    except UnknownChannelError as error:
        raise InputError(f"{said}: {error}") from None
    if name.startswith(UNSEEN) or name.split(" ")[-1].startswith("across"):
        raise InputError(f"{said}: {name!r} is no history of a run, and cannot be compared")


def taken(histories: Mapping[str, Array], plant: Plant, name: str) -> Array:
    """History of a channel, (time,), from variables of a run (`ehamj.variables`)."""
    if name == SUPPLY:
        return histories[SUPPLY]
    variable, *labels = name.split(" ")
    if variable == "machine_acceleration":
        return histories[variable][:, DOFS.index(labels[0])]
    if variable.startswith("cg_"):
        return histories[variable][:, AXES.index(labels[0])]
    if variable.startswith("machine_"):
        return histories[variable][:, DOFS.index(labels[0])]
    mount = plant.mounts.index(labels[0])
    if variable == "load_pressure":
        both = histories["chamber_pressure"][:, mount]
        return np.asarray(both[:, 0] - both[:, 1])
    if variable == "chamber_pressure":
        return histories[variable][:, mount, [str(k) for k in CHAMBERS].index(labels[1])]
    if len(labels) == 2:
        motion = histories[variable][:, mount]
        if labels[1] == ALONG:
            return np.asarray(motion @ np.array(plant.directions[mount]))
        return np.asarray(motion[:, AXES.index(labels[1])])
    return histories[variable][:, mount]
