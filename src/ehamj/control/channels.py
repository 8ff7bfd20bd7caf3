"""Named scalar channels of the machine as linear maps of its state: what sensors measure and linear models give.

A channel is written as in the result's variables, with its labels: ``ground_velocity front-left z``,
``stroke rear-right``, ``chamber_pressure front-left 1``, ``cg_acceleration z``. Rotations are small.
"""

import difflib
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ehamj.control.compiled.signals import Layout
from ehamj.memory import ISOLATOR_STATE, size
from ehamj.plant.axes import AXES, CHAMBERS, DOFS
from ehamj.plant.levers import lever
from ehamj.plant.mounts import MOUNTS
from ehamj.plant.plant import Plant

Array = NDArray[np.float64]

_MOTIONS = ("displacement", "velocity", "acceleration")
STATIC = ("displacement", "pressure")
"""Quantities that have a value at rest."""


class UnknownChannelError(ValueError):
    """No channel has this name; the message lists what is near."""


@cache
def channel_names(mounts: tuple[str, ...] = MOUNTS) -> tuple[str, ...]:
    """Every channel there is, with these mounts."""
    names = []
    for motion in _MOTIONS:
        names += [f"ground_{motion} {mount} {axis}" for mount in mounts for axis in AXES]
        names += [f"foot_{motion} {mount} {axis}" for mount in mounts for axis in AXES]
        names += [f"cg_{motion} {axis}" for axis in AXES]
        names += [f"machine_{motion} {dof}" for dof in DOFS]
    names += [f"{name} {mount}" for name in ("stroke", "stroke_velocity", "spool", "load_pressure") for mount in mounts]
    names += [f"chamber_pressure {mount} {chamber}" for mount in mounts for chamber in CHAMBERS]
    return tuple(names)


def valve_commands(mounts: Sequence[str]) -> tuple[str, ...]:
    """What laws command."""
    return tuple(f"valve_command {mount}" for mount in mounts)


def check_channel(name: str, mounts: tuple[str, ...]) -> None:
    """Refuse a name that no channel has.

    Raises:
        UnknownChannelError: with what is near it.
    """
    names = channel_names(mounts)
    if name not in names:
        near = difflib.get_close_matches(name, names, n=3, cutoff=0.0)
        raise UnknownChannelError(f"channel {name!r} is unknown; near it are: {', '.join(map(repr, near))}")


def channel_row(name: str, plant: Plant) -> Array:
    """The channel as a row over the vector of signals, shape (signals,).

    Raises:
        UnknownChannelError: if there is no such channel.
    """
    check_channel(name, plant.mounts)
    at, places = Layout.of(len(plant.mounts)), plant.mounts
    row = np.zeros(at.size)
    variable, *labels = name.split(" ")
    what, _, motion = variable.rpartition("_")
    if what in ("ground", "foot", "cg", "machine") and motion in _MOTIONS:
        order = _MOTIONS.index(motion)
        if what == "ground":
            first = (at.ground, at.ground_velocity, at.ground_acceleration)[order]
            row[first + len(AXES) * places.index(labels[0]) + AXES.index(labels[1])] = 1.0
            return row
        first = (at.displacement, at.velocity, at.acceleration)[order]
        if what == "machine":
            row[first + DOFS.index(labels[0])] = 1.0
        else:
            foot = what == "foot"
            point = plant.positions[places.index(labels[0])] if foot else plant.machine.cg
            row[first : first + len(DOFS)] = lever(point)[AXES.index(labels[-1])]
        return row
    mount = places.index(labels[0])
    state = at.state + size(ISOLATOR_STATE) * mount
    if variable in ("stroke", "stroke_velocity"):
        plate, ground = (at.plate, at.ground) if variable == "stroke" else (at.plate_velocity, at.ground_velocity)
        row[plate + mount] = 1.0
        row[ground + len(AXES) * mount + AXES.index("z")] = -1.0
    elif variable == "spool":
        row[state] = 1.0
    elif variable == "load_pressure":
        row[state + 2], row[state + 3] = 1.0, -1.0
    else:
        row[state + 1 + int(labels[1])] = 1.0
    return row


class MountChannels(NamedTuple):
    """The channels of one quantity at all mounts, which laws measure."""

    feet: tuple[str, ...]
    """Vertical velocity of the machine above each mount."""
    strokes: tuple[str, ...]
    ground: tuple[str, ...]
    """Vertical velocity of the ground below each mount."""
    along: tuple[str, ...]
    across: tuple[str, ...]
    """Sideways velocity of the machine above each mount, along x and y."""
    pressures: tuple[str, ...]

    @classmethod
    def of(cls, mounts: Sequence[str]) -> "MountChannels":
        """Of the mounts of a plant."""
        names = ["foot_velocity {} z", "stroke {}", "ground_velocity {} z", "foot_velocity {} x", "foot_velocity {} y"]
        return cls(*(tuple(name.format(mount) for mount in mounts) for name in [*names, "load_pressure {}"]))


def quantity_of(variable: str) -> str:
    """Displacement, velocity, acceleration or pressure."""
    return "displacement" if variable == "stroke" else variable.rpartition("_")[2]
