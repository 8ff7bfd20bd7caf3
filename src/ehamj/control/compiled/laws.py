"""What the laws of a controller do at a sample, compiled: outputs, their queue, one converter, their states."""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import types

from ehamj.compiled import copy, kernel
from ehamj.compiled.native import c_function
from ehamj.control.compiled.converter import Conversion, converted, faded, taken

LAW: Final = np.dtype(
    [
        (name, np.int64)
        for name in (
            "states",
            "inputs",
            "every",  # steps between samples
            "delay",  # steps from a sample to its command
            "function",  # address of a Python law; 0: none
            # Where its matrices begin in `Laws.matrices`, its inputs in `Laws.inputs_of`:
            "matrices",
            "windup",  # -1: no anti-windup
            "inputs_at",
            # Where in `LawMemory.values` its states lie; per valve its latest outputs, those that are held, what fade
            # and range last took; and the ring of outputs that wait for their time:
            "states_at",
            "latest",
            "held",
            "taken",
            "ring",
            "places",  # of the ring: as many samples as the delay is long, and one
        )
    ]
)
"""A law as the loop knows it; all fields are whole numbers."""

NOT_DUE: Final = 0
WAITS: Final = 1
AT_ONCE: Final = 2
FAILED: Final = 3
"""What a sample means for the commands: none was taken, they wait, they act at once, or a Python law failed."""


class Laws(NamedTuple):
    """The laws that run side by side."""

    table: Any
    """A `LAW` per law."""
    matrices: Any
    """A, B, C, D and anti-windup of every law, each transposed and flat."""
    inputs_of: Any
    """Channels that the laws measure, one law after the other."""
    converter: Conversion
    base: int
    """Steps of which all periods are multiples; 0: no controller."""


class LawMemory(NamedTuple):
    """What the laws remember (see `LAW`), and scratch."""

    values: Any
    measured: Any
    scratch: Any
    totals: Any
    """(2, valve)"""

    @classmethod
    def of(cls, size: int, inputs: int, mounts: int) -> "LawMemory":
        """Memory of a size."""
        return cls(np.zeros(size), np.zeros(inputs), np.zeros(size), np.zeros((2, mounts)))


call_law = c_function(types.int32, types.float64, types.intp, types.intp, types.intp)
"""int law(double time, double *measured, double *limited, double *wanted)"""


@kernel
def release(number, laws, memory, control):  # type: ignore[no-untyped-def]
    """Hand the valves the outputs whose time has come."""
    changed, values = False, memory.values
    for k in range(laws.table.size):
        law = laws.table[k]
        since = number - law.delay
        if law.delay > 0 and since >= 0 and since % law.every == 0:
            place = law.ring + control.size * ((since // law.every) % law.places)
            for valve in range(control.size):
                values[law.held + valve] = values[place + valve]
            changed = True
    if changed:
        convert_held(laws, memory, control)


@kernel
def convert_held(laws, memory, control):  # type: ignore[no-untyped-def]
    """Commands from what all laws hold."""
    for valve in range(control.size):
        total = 0.0
        for k in range(laws.table.size):
            total += memory.values[laws.table[k].held + valve]
        control[valve] = converted(total, laws.converter.limit, laws.converter.resolution)


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
    copy(scratch, state)


@kernel
def compute(time, law, laws, readings, memory):  # type: ignore[no-untyped-def]
    """Let one law compute its outputs; False where a Python law failed."""
    n, p, first, at = law.states, law.inputs, law.matrices, law.inputs_at
    valves, values = memory.totals.shape[1], memory.values
    for i in range(p):
        memory.measured[at + i] = readings[laws.inputs_of[at + i]]
    latest, inputs = values[law.latest : law.latest + valves], memory.measured[at : at + p]
    if law.function != 0:
        lost = values[law.taken : law.taken + valves]
        return call_law(law.function, (time, inputs.ctypes.data, lost.ctypes.data, latest.ctypes.data)) == 0
    C = first + n * (n + p)
    D = C + valves * n
    states = values[law.states_at : law.states_at + n]
    wanted(laws.matrices[C:D], laws.matrices[D : D + valves * p], states, inputs, latest)
    return True


@kernel
def take_sample(number, time, laws, readings, memory):  # type: ignore[no-untyped-def]
    """Let every law that is due compute; returns what that means for the commands."""
    answer = NOT_DUE
    for k in range(laws.table.size):
        law = laws.table[k]
        if number % law.every == 0:
            answer = max(answer, AT_ONCE if law.delay == 0 else WAITS)
            if not compute(time, law, laws, readings, memory):
                return FAILED
    if answer == NOT_DUE:
        return answer
    total, lost = memory.totals[0], memory.totals[1]
    for valve in range(total.size):
        total[valve] = 0.0
        for k in range(laws.table.size):
            total[valve] += memory.values[laws.table[k].latest + valve]
    share = faded(time, laws.converter)
    taken(total, share, laws.converter, lost)
    for k in range(laws.table.size):
        if number % laws.table[k].every == 0:
            finish_sample(number, share, laws.table[k], laws, memory)
    return answer


@kernel
def finish_sample(number, share, law, laws, memory):  # type: ignore[no-untyped-def]
    """Advance the states of a law, and queue its outputs (without delay: hold them)."""
    n, p, first, at = law.states, law.inputs, law.matrices, law.inputs_at
    values, matrices, lost = memory.values, laws.matrices, memory.totals[1]
    if law.function == 0 and n > 0:
        states = values[law.states_at : law.states_at + n]
        B = first + n * n
        inputs = memory.measured[at : at + p]
        advance_states(matrices[first:B], matrices[B : B + n * p], states, inputs, memory.scratch[:n])
        if law.windup >= 0:
            add_product(matrices[law.windup : law.windup + lost.size * n], lost, states)
    place = law.ring + lost.size * ((number // law.every) % law.places)
    if law.delay == 0:
        place = law.held
    for valve in range(lost.size):
        values[law.taken + valve] = lost[valve]
        values[place + valve] = share * values[law.latest + valve]
