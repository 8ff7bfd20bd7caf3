"""Named scalar channels of the machine as linear maps of its state: what sensors measure and linear models give.

A channel is written as in the result's variables, with its labels: ``ground_velocity front-left z``,
``stroke rear-right``, ``chamber_pressure front-left 1``, ``cg_acceleration z``. Rotations are small.
"""

import difflib
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from ehamj.arrays import Array
from ehamj.control.compiled.signals import Layout
from ehamj.memory import ISOLATOR_STATE, size
from ehamj.plant.axes import AXES, CHAMBERS, DOFS
from ehamj.plant.levers import lever
from ehamj.plant.mounts import MOUNTS
from ehamj.plant.plant import Plant

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
    at, row = Layout.of(len(plant.mounts)), np.zeros(Layout.of(len(plant.mounts)).size)
    variable, *labels = name.split(" ")
    what, _, motion = variable.rpartition("_")
    mount = plant.mounts.index(labels[0]) if labels[0] in plant.mounts else 0
    ground = [first + len(AXES) * mount for first in (at.ground, at.ground_velocity, at.ground_acceleration)]
    if what in ("ground", "foot", "cg", "machine") and motion in _MOTIONS:
        order = _MOTIONS.index(motion)
        first = (at.displacement, at.velocity, at.acceleration)[order]
        if what == "ground":
            row[ground[order] + AXES.index(labels[1])] = 1.0
        elif what == "machine":
            row[first + DOFS.index(labels[0])] = 1.0
        else:
            point = plant.positions[mount] if what == "foot" else plant.machine.cg
            row[first : first + len(DOFS)] = lever(point)[AXES.index(labels[-1])]
        return row
    assert ISOLATOR_STATE.names is not None
    first = at.state + size(ISOLATOR_STATE) * mount
    below, moving = ({start + k: -share for k, share in enumerate(plant.directions[mount])} for start in ground[:2])
    state = {name: first + k for k, name in enumerate(ISOLATOR_STATE.names)}
    shares = {
        "stroke": {at.plate + mount: 1.0, **below},
        "stroke_velocity": {at.plate_velocity + mount: 1.0, **moving},
        "spool": {state["spool"]: 1.0},
        "load_pressure": {state["pressure_1"]: 1.0, state["pressure_2"]: -1.0},
        "chamber_pressure": {state[f"pressure_{labels[-1]}"]: 1.0} if variable == "chamber_pressure" else {},
    }
    for place, share in shares[variable].items():
        row[place] = share
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
