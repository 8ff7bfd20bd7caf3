"""What a digital controller and its sensors do at a step, compiled. Matrices come flat and transposed, see `Loop`."""

import math

from ehamj.compiled import kernel
from ehamj.plant.mounts import N_MOUNTS


@kernel
def converted(voltage: float, limit: float, resolution: float) -> float:
    """What a converter makes of a value: limited to ±``limit``, rounded to ``resolution`` (0: exact)."""
    voltage = min(max(voltage, -limit), limit)
    if resolution > 0.0:
        voltage = resolution * math.floor(voltage / resolution + 0.5)
    return voltage


@kernel
def faded(time: float, switch_on: float, fade: float) -> float:
    """Share of the commands that reaches the valves at a time: 0 before ``switch_on``, then 3s² − 2s³ over ``fade``."""
    since = time - switch_on
    if since < -5e-10:  # half a nanosecond: times of steps are rounded
        return 0.0
    if since >= fade - 5e-10:
        return 1.0
    s = max(since, 0.0) / fade
    return s * s * (3.0 - 2.0 * s)


@kernel
def add_product(matrix_t, vector, result):  # type: ignore[no-untyped-def]
    """result += matrix·vector, for the flat transposed matrix.

    Whole columns are added, one after the other, which vectorises without changing a rounding; four at a time, so that
    the result is loaded and stored a quarter as often.
    """
    size, columns = result.size, vector.size
    whole = columns - columns % 4
    for k in range(0, whole, 4):
        a, b, c, d = vector[k], vector[k + 1], vector[k + 2], vector[k + 3]
        first = matrix_t[k * size : (k + 1) * size]
        second = matrix_t[(k + 1) * size : (k + 2) * size]
        third = matrix_t[(k + 2) * size : (k + 3) * size]
        fourth = matrix_t[(k + 3) * size : (k + 4) * size]
        for i in range(size):
            result[i] = (((result[i] + first[i] * a) + second[i] * b) + third[i] * c) + fourth[i] * d
    for k in range(whole, columns):
        factor = vector[k]
        column = matrix_t[k * size : (k + 1) * size]
        for i in range(size):
            result[i] += column[i] * factor


@kernel
def wanted(Ct, Dt, state, measured, result):  # type: ignore[no-untyped-def]
    """y = C x + D u."""
    result[:] = 0.0
    add_product(Ct, state, result)
    add_product(Dt, measured, result)


@kernel
def advance_states(At, Bt, state, measured, scratch):  # type: ignore[no-untyped-def]
    """x⁺ = A x + B u; ``scratch`` is as long as the state."""
    scratch[:] = 0.0
    add_product(At, state, scratch)
    add_product(Bt, measured, scratch)
    state[:] = scratch


@kernel
def limited(total, share, limit, result):  # type: ignore[no-untyped-def]
    """What fade and range take from the wanted commands, applied − wanted."""
    for valve in range(N_MOUNTS):
        result[valve] = converted(share * total[valve], limit, 0.0) - total[valve]


@kernel
def filter_readings(filters, feedthrough, raw, states, analogue, scratch):  # type: ignore[no-untyped-def]
    """One step of every sensor's filter: analogue readings, then the states at the next step.

    ``filters`` (n + 3, n, channels) holds A row by row, then B, C and the resting state; ``states`` (n·channels).
    """
    n, channels = filters.shape[1], filters.shape[2]
    for c in range(channels):
        analogue[c] = feedthrough[c] * raw[c]
    for j in range(n):
        own = states[j * channels : (j + 1) * channels]
        for c in range(channels):
            analogue[c] += filters[n + 1, j, c] * own[c]
    for i in range(n):
        row = scratch[i * channels : (i + 1) * channels]
        for c in range(channels):
            row[c] = filters[n, i, c] * raw[c]
        for j in range(n):
            own = states[j * channels : (j + 1) * channels]
            for c in range(channels):
                row[c] += filters[i, j, c] * own[c]
    states[:] = scratch


@kernel
def settle_filters(filters, raw, states):  # type: ignore[no-untyped-def]
    """Let every sensor rest at its channel's present value."""
    n, channels = filters.shape[1], filters.shape[2]
    for i in range(n):
        for c in range(channels):
            states[i * channels + c] = filters[n + 2, i, c] * raw[c]
