"""The vector of signals that every channel is a combination of, and how it is filled, compiled."""

from typing import NamedTuple

from ehamj.compiled import kernel
from ehamj.memory import ISOLATOR_STATE, size
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
    size: int

    @classmethod
    def of(cls, mounts: int) -> "Layout":
        """The layout for so many mounts."""
        sizes = (len(DOFS),) * 3 + (mounts * len(AXES),) * 3 + (mounts * size(ISOLATOR_STATE),) + (mounts,) * 2
        return cls(*(sum(sizes[:k]) for k in range(len(sizes) + 1)))


@kernel
def gather(signals, layout, motion, act, length, velocity, inputs, rate):  # type: ignore[no-untyped-def]
    """Fill ``signals`` from (qpos, qvel, qacc), activations, actuators and ``inputs`` (mount, input, order)."""
    qpos, qvel, qacc = motion
    for dof in range(len(DOF_OF_JOINT)):
        joint = DOF_OF_JOINT[dof]
        signals[layout.displacement + dof] = qpos[joint]
        signals[layout.velocity + dof] = qvel[joint]
        signals[layout.acceleration + dof] = qacc[joint]
    axes = len(AXES)
    for mount in range(length.size):
        for axis in range(axes):
            channel = axes * mount + axis
            signals[layout.ground + channel] = inputs[mount, axis, 0]
            signals[layout.ground_velocity + channel] = inputs[mount, axis, 1] * rate
            signals[layout.ground_acceleration + channel] = inputs[mount, axis, 2]
        signals[layout.plate + mount] = length[mount]
        signals[layout.plate_velocity + mount] = velocity[mount]
    for k in range(layout.plate - layout.state):
        signals[layout.state + k] = act[k]
