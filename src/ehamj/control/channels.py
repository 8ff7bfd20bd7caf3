"""Named scalar channels of the machine as linear maps of its state: what sensors measure and linear models give.

A channel is written as in the result's variables, with its labels: ``ground_velocity front-left z``,
``stroke rear-right``, ``chamber_pressure front-left 1``, ``cg_acceleration z``. Rotations are small. Ground and feet
have one label more beside x, y, z: ``foot_velocity front-left along`` is the component along the mount's direction.
"""

import difflib
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Final, NamedTuple

import numpy as np

from ehamj.arrays import Array
from ehamj.control.compiled.signals import Layout
from ehamj.errors import InputError
from ehamj.memory import ISOLATOR_STATE, size
from ehamj.plant.axes import AXES, CHAMBERS, DOFS
from ehamj.plant.levers import cross_axes, lever
from ehamj.plant.mounts import MOUNTS, UPRIGHT
from ehamj.plant.plant import Plant

_MOTIONS = ("displacement", "velocity", "acceleration")
ALONG: Final = "along"
"""Label of the component along a mount's own direction."""
CROSS: Final = ("across-1", "across-2")
"""Labels of the two at right angles to it (`cross_axes`); instruments that are out of line see them too."""
SUPPLY: Final = "supply_pressure"
"""The channel of the supply, which all valves share."""
UPSTREAM: Final = "upstream"
"""In a mount's place in a ground_… channel: where the sensor stands that a wave reaches before the machine."""
SPOOLS: Final = ("edges", "spool")
"""Channels of a valve's position: of its metering edges, and of the spool's driven end, which hysteresis parts."""
STATIC = ("displacement", "pressure", "position")
"""Quantities that have a value at rest."""


class UnknownChannelError(ValueError):
    """No channel has this name; the message lists what is near."""


@cache
def channel_names(mounts: tuple[str, ...] = MOUNTS) -> tuple[str, ...]:
    """Every channel there is, with these mounts."""
    names = []
    for motion in _MOTIONS:
        names += [f"ground_{motion} {mount} {axis}" for mount in mounts for axis in (*AXES, ALONG)]
        names += [f"ground_{motion} {UPSTREAM} {axis}" for axis in AXES]
        names += [f"foot_{motion} {mount} {axis}" for mount in mounts for axis in (*AXES, ALONG)]
        names += [f"cg_{motion} {axis}" for axis in AXES]
        names += [f"machine_{motion} {dof}" for dof in DOFS]
    names += [
        f"{name} {mount}"
        for name in ("stroke", "stroke_velocity", "spool", "edges", "load_pressure")
        for mount in mounts
    ]
    names += [f"chamber_pressure {mount} {chamber}" for mount in mounts for chamber in CHAMBERS]
    names.append(SUPPLY)
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
    stem, _, label = name.rpartition(" ")
    if (f"{stem} {ALONG}" if label in CROSS else name) not in names:
        near = difflib.get_close_matches(name, names, n=3, cutoff=0.0)
        raise UnknownChannelError(f"channel {name!r} is unknown; near it are: {', '.join(map(repr, near))}")


def channel_row(name: str, plant: Plant) -> Array:
    """The channel as a row over the vector of signals, shape (signals,).

    Raises:
        UnknownChannelError: if there is no such channel.
    """
    check_channel(name, plant.mounts)
    at, row = Layout.of(len(plant.mounts)), np.zeros(Layout.of(len(plant.mounts)).size)
    if name == SUPPLY:
        row[at.supply] = 1.0
        return row
    variable, *labels = name.split(" ")
    what, _, motion = variable.rpartition("_")
    if what == "ground" and labels[0] == UPSTREAM:
        row[at.upstream + len(AXES) * _MOTIONS.index(motion) + AXES.index(labels[1])] = 1.0
        return row
    mount = plant.mounts.index(labels[0]) if labels[0] in plant.mounts else 0
    ground = [first + len(AXES) * mount for first in (at.ground, at.ground_velocity, at.ground_acceleration)]
    along, axes = np.array(plant.directions[mount]), slice(0, len(AXES))
    if what in ("ground", "foot", "cg", "machine") and motion in _MOTIONS:
        order = _MOTIONS.index(motion)
        first = (at.displacement, at.velocity, at.acceleration)[order]
        if what == "ground":
            row[ground[order] :][axes] = axis_of(labels[1], along)
        elif what == "machine":
            row[first + DOFS.index(labels[0])] = 1.0
        else:
            point = plant.positions[mount] if what == "foot" else plant.machine.cg
            row[first : first + len(DOFS)] = axis_of(labels[-1], along) @ lever(point)
        return row
    assert ISOLATOR_STATE.names is not None
    first = at.state + size(ISOLATOR_STATE) * mount
    state = {name: first + k for k, name in enumerate(ISOLATOR_STATE.names)}
    shares = {
        "stroke": {at.plate + mount: 1.0, **{ground[0] + k: -along[k] for k in range(len(AXES)) if along[k]}},
        "stroke_velocity": {
            at.plate_velocity + mount: 1.0,
            **{ground[1] + k: -along[k] for k in range(len(AXES)) if along[k]},
        },
        "spool": {state["spool"]: 1.0},
        "edges": {at.edges + mount: 1.0},
        "load_pressure": {state["pressure_1"]: 1.0, state["pressure_2"]: -1.0},
        "chamber_pressure": {state[f"pressure_{labels[-1]}"]: 1.0} if variable == "chamber_pressure" else {},
    }
    for place, share in shares[variable].items():
        row[place] = share
    return row


def axis_of(label: str, along: Array) -> Array:
    """Unit vector that a label of ground or foot stands for, (3,), at a mount that acts ``along`` one."""
    if label in AXES:
        return np.asarray(np.eye(len(AXES))[AXES.index(label)])
    return along if label == ALONG else cross_axes(along)[CROSS.index(label)]


class MountChannels(NamedTuple):
    """The channels of one quantity at all mounts that obey commands, which laws measure."""

    feet: tuple[str, ...]
    """Velocity of the machine above each mount, along its direction."""
    strokes: tuple[str, ...]
    ground: tuple[str, ...]
    """Velocity of the ground below each mount, along its direction."""
    ahead: tuple[str, ...]
    across: tuple[str, ...]
    """Velocity of the machine above each mount, along x and along y."""
    pressures: tuple[str, ...]

    @classmethod
    def of(cls, plant: Plant) -> "MountChannels":
        """Of the active mounts of a plant; along an upright one is z.

        Raises:
            InputError: if there is none.
        """
        own = plant.obeying
        if not own.mounts:
            raise InputError(
                f"control: no mount obeys commands, all {len(plant.mounts)} are passive; set control.kind = 'passive', "
                "or give a mount an actuator that is not"
            )
        axes = ["z" if direction[2] > 1.0 - UPRIGHT else ALONG for direction in own.directions]
        names = [
            "foot_velocity {} {}",
            "stroke {}",
            "ground_velocity {} {}",
            "foot_velocity {} x",
            "foot_velocity {} y",
        ]
        names.append("load_pressure {}")
        return cls(*(tuple(map(name.format, own.mounts, axes)) for name in names))


def is_upstream(name: str) -> bool:
    """Whether a channel is the ground's motion upstream, and not below a mount."""
    return name.startswith("ground_") and name.split(" ")[1] == UPSTREAM


def reads_static(names: Iterable[str]) -> bool:
    """Whether one of some channels has a value at rest, from which its readings may count."""
    return any(quantity_of(name.split(" ")[0]) in STATIC for name in names)


def quantity_of(variable: str) -> str:
    """Displacement, velocity, acceleration, pressure, or a valve's position."""
    if variable in SPOOLS:
        return "position"
    return "displacement" if variable == "stroke" else variable.rpartition("_")[2]
