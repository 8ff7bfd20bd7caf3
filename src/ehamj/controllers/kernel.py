"""One tick of a digital controller, compiled."""

import math

from ehamj.compiled import kernel
from ehamj.layout import N_MOUNTS


@kernel
def converted(voltage: float, limit: float, resolution: float) -> float:
    """What a converter makes of a voltage: limited to ±``limit``, rounded to ``resolution`` [V] (0: exact)."""
    voltage = min(max(voltage, -limit), limit)
    if resolution > 0.0:
        voltage = resolution * math.floor(voltage / resolution + 0.5)
    return voltage


@kernel
def tick(At, Bt, Ct, Dt, measured, state, scratch, limit, resolution, commands):  # type: ignore[no-untyped-def]
    """y = C x + D u into ``commands`` (converted), then x⁺ = A x + B u into ``state``; ``scratch`` is as long.

    The matrices come transposed: a product then adds whole columns, which vectorises without changing a rounding.
    """
    commands[:] = 0.0
    scratch[:] = 0.0
    add_product(Ct, state, commands)
    add_product(Dt, measured, commands)
    add_product(At, state, scratch)
    add_product(Bt, measured, scratch)
    for valve in range(N_MOUNTS):
        commands[valve] = converted(commands[valve], limit, resolution)
    for i in range(state.size):
        state[i] = scratch[i]


@kernel
def add_product(matrix_t, vector, result):  # type: ignore[no-untyped-def]
    """result += matrix·vector, for the transposed matrix."""
    for k in range(vector.size):
        for i in range(result.size):
            result[i] += matrix_t[k, i] * vector[k]
