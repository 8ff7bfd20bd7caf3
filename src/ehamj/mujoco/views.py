"""The records of `ehamj.memory` in compiled code, from the addresses of mjModel and mjData.

``at`` is always `ehamj.mujoco.offsets.Offsets`.
"""

from numba import carray

from ehamj.compiled import kernel
from ehamj.memory import (
    CUBIC,
    DOUBLE,
    ISOLATOR,
    ISOLATOR_STATE,
    LEDGER,
    LOADS_SIZE,
    MOUNT,
    OIL,
    STEP,
    SUPPLY,
    SUPPLY_STATE,
)
from ehamj.mujoco.pointers import address_at, pointer
from ehamj.plant.axes import DOFS

WIDTH = ISOLATOR.itemsize
LOADS_AT = STEP.itemsize
MOUNTS_AT = LOADS_AT + LOADS_SIZE
N_LOADS = len(DOFS)
OIL_SIZE = OIL.itemsize


@kernel
def isolators_at(model, at):  # type: ignore[no-untyped-def]
    """Records of the isolators (mount,)."""
    rows = pointer(address_at(model, at.actuator_user))
    return carray(rows, int(carray(rows, 1, ISOLATOR)[0].mounts), ISOLATOR)


@kernel
def supply_at(model, at, row):  # type: ignore[no-untyped-def]
    """Record of the shared supply, which is in a row."""
    return carray(pointer(address_at(model, at.actuator_user) + WIDTH * int(row)), 1, SUPPLY)[0]


@kernel
def step_at(data, at):  # type: ignore[no-untyped-def]
    """The step's record (1,)."""
    return carray(pointer(address_at(data, at.userdata)), 1, STEP)


@kernel
def loads_at(data, at):  # type: ignore[no-untyped-def]
    """Cubics of the load (dof,)."""
    return carray(pointer(address_at(data, at.userdata) + LOADS_AT), N_LOADS, CUBIC)


@kernel
def mounts_at(data, at, n):  # type: ignore[no-untyped-def]
    """What a step and the mounts exchange (mount,)."""
    return carray(pointer(address_at(data, at.userdata) + MOUNTS_AT), n, MOUNT)


@kernel
def isolator_states(address, n):  # type: ignore[no-untyped-def]
    """States of the isolators, or their rates (mount,), from where the activations lie."""
    return carray(pointer(address), n, ISOLATOR_STATE)


@kernel
def supply_states(address, place):  # type: ignore[no-untyped-def]
    """States of the supply, or their rates, at a place among the activations."""
    return carray(pointer(address + DOUBLE * int(place)), 1, SUPPLY_STATE)[0]


@kernel
def oil_states(address, place, n):  # type: ignore[no-untyped-def]
    """What the ledger holds of the mounts (mount,), at its place among the activations."""
    return carray(pointer(address + DOUBLE * int(place)), n, OIL)


@kernel
def ledger_states(address, place, n):  # type: ignore[no-untyped-def]
    """What the ledger holds of the whole, at its place among the activations."""
    return carray(pointer(address + DOUBLE * int(place) + OIL_SIZE * n), 1, LEDGER)[0]
