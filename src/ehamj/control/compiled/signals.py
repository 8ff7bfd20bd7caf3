"""The vector of signals that every channel is a combination of, and how it is filled, compiled.

Arrays are flat, the lanes of a block of machines last: entry i of a lane is at ``i * len(lanes) + lane``.
"""

from functools import cache
from typing import NamedTuple

from ehamj.compiled import kernel
from ehamj.memory import INPUTS, ISOLATOR_STATE, ORDERS, size
from ehamj.plant.axes import AXES, DOF_OF_JOINT, DOFS


class Layout(NamedTuple):
    """Where each kind of signal begins, for a number of mounts."""

    displacement: int
    """Machine, per degree of freedom [m, rad]."""
    velocity: int
    acceleration: int
    ground: int
    """Displacement of each mount and axis [m]."""
    ground_velocity: int
    ground_acceleration: int
    state: int
    """States of each isolator (`ehamj.memory.ISOLATOR_STATE`)."""
    plate: int
    """Height of each plate [m]."""
    plate_velocity: int
    edges: int
    """Position of the metering edges of each valve, which its spool carries [mA]."""
    supply: int
    """Absolute pressure of the supply [Pa]."""
    upstream: int
    """Displacement of the ground upstream in each axis [m], then velocity, then acceleration."""
    size: int

    @classmethod
    @cache
    def of(cls, mounts: int) -> "Layout":
        """The layout for so many mounts."""
        machine = (len(DOFS),) * 3 + (mounts * len(AXES),) * 3 + (mounts * size(ISOLATOR_STATE),) + (mounts,) * 3
        sizes = (*machine, 1, len(AXES) * ORDERS)
        return cls(*(sum(sizes[:k]) for k in range(len(sizes) + 1)))


@kernel
def take(signals, place, values, first, factor, lanes):  # type: ignore[no-untyped-def]
    """One signal of all lanes, from ``first`` on in other values."""
    for lane in range(len(lanes)):
        signals[place * len(lanes) + lane] = values[first + lane] * factor


@kernel
def gather(signals, layout, motion, act, length, velocity, inputs, rate, lanes):  # type: ignore[no-untyped-def]
    """Fill ``signals`` from (qpos, qvel, qacc), activations, actuators and ``inputs`` (mount·input·order), which may
    have the ground upstream as one mount more."""
    width = len(lanes)
    for dof in range(len(DOF_OF_JOINT)):
        joint = DOF_OF_JOINT[dof] * width
        take(signals, layout.displacement + dof, motion[0], joint, 1.0, lanes)
        take(signals, layout.velocity + dof, motion[1], joint, 1.0, lanes)
        take(signals, layout.acceleration + dof, motion[2], joint, 1.0, lanes)
    mounts, each = length.size // width, len(INPUTS) * ORDERS * width
    for mount in range(mounts):
        for axis in range(len(AXES)):
            channel, first = len(AXES) * mount + axis, (len(INPUTS) * mount + axis) * ORDERS * width
            take(signals, layout.ground + channel, inputs, first, 1.0, lanes)
            take(signals, layout.ground_velocity + channel, inputs, first + width, rate, lanes)
            take(signals, layout.ground_acceleration + channel, inputs, first + 2 * width, 1.0, lanes)
        take(signals, layout.plate + mount, length, mount * width, 1.0, lanes)
        take(signals, layout.plate_velocity + mount, velocity, mount * width, 1.0, lanes)
    if inputs.size > mounts * each:
        for axis in range(len(AXES)):
            first = mounts * each + axis * ORDERS * width
            for order in range(ORDERS):
                factor = rate if order == 1 else 1.0
                take(signals, layout.upstream + len(AXES) * order + axis, inputs, first + order * width, factor, lanes)
    for k in range((layout.plate - layout.state) * width):
        signals[layout.state * width + k] = act[k]
