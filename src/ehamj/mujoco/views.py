"""What compiled code sees of mjModel and mjData: numbers, arrays, and the records of `ehamj.memory`, by address.

``at`` is always `ehamj.mujoco.offsets.Offsets`.
"""

from collections import namedtuple
from typing import Any

import numpy as np

from ehamj.compiled import giving_arrays, kernel
from ehamj.compiled.native import view
from ehamj.memory import CUBIC, DOUBLE, ISOLATOR, ISOLATOR_STATE, LOADS_SIZE, MOUNT, SLIDE, STEP
from ehamj.plant.axes import DOFS

WIDTH = ISOLATOR.itemsize
LOADS_AT = STEP.itemsize
MOUNTS_AT = LOADS_AT + LOADS_SIZE
MOUNT_SIZE = MOUNT.itemsize
N_LOADS = len(DOFS)

Machine: Any = namedtuple(
    "Machine",
    "time qpos qvel qacc act act_dot states rates control length velocity isolators step loads mounts slides",
)
"""The arrays of a model and its data, and the records in them: what is of one number has one element."""


@kernel
def address_at(struct, offset):  # type: ignore[no-untyped-def]
    """The address stored ``offset`` bytes into the struct at address ``struct``."""
    return view(struct + offset, 1, np.intp)[0]


@giving_arrays
def numbers_at(struct, offset, n):  # type: ignore[no-untyped-def]
    """The array of ``n`` numbers whose address is stored ``offset`` bytes into a struct."""
    return view(address_at(struct, offset), n, np.float64)


@giving_arrays
def part(activations, place, n, dtype):  # type: ignore[no-untyped-def]
    """``n`` records at a place among the activations, or among their rates."""
    return view(activations.ctypes.data + DOUBLE * int(place), n, dtype)


@giving_arrays
def row_at(model, at, row, n, dtype):  # type: ignore[no-untyped-def]
    """``n`` records from a row of the actuators' table on."""
    return view(address_at(model, at.actuator_user) + WIDTH * int(row), n, dtype)


@giving_arrays
def mounts_at(data, at, n):  # type: ignore[no-untyped-def]
    """What a step and the mounts exchange (mount,)."""
    return view(address_at(data, at.userdata) + MOUNTS_AT, n, MOUNT)


@giving_arrays
def machine_of(model, data, at, nq, nv):  # type: ignore[no-untyped-def]
    """Views of a model and its data, of ``nq`` positions and ``nv`` velocities."""
    head = row_at(model, at, 0, 1, ISOLATOR)[0]
    n, n_act, user = int(head.mounts), int(head.activations), address_at(data, at.userdata)
    act, act_dot = numbers_at(data, at.act, n_act), numbers_at(data, at.act_dot, n_act)
    return Machine(
        view(data + at.time, 1, np.float64),
        numbers_at(data, at.qpos, nq),
        numbers_at(data, at.qvel, nv),
        numbers_at(data, at.qacc, nv),
        act,
        act_dot,
        part(act, 0, n, ISOLATOR_STATE),
        part(act_dot, 0, n, ISOLATOR_STATE),
        numbers_at(data, at.ctrl, n),
        numbers_at(data, at.actuator_length, n),
        numbers_at(data, at.actuator_velocity, n),
        row_at(model, at, 0, n, ISOLATOR),
        view(user, 1, STEP),
        view(user + LOADS_AT, N_LOADS, CUBIC),
        mounts_at(data, at, n),
        view(user + MOUNTS_AT + n * MOUNT_SIZE, int(head.slides), SLIDE),
    )
