"""The stage between laws and converter, compiled: each valve's wanted voltage becomes the command that gives its flow.

It stands at the converter, sees the readings of the last sample, and acts when what is wanted changes. In a step of the
integrator commands may be found twice, since a sample without delay changes them: what the stage remembers is that of
the last step until the next begins.

Arrays are flat, the lanes of a block of machines last: entry i of a lane is at ``i * len(lanes) + lane``.
"""

from typing import Final, NamedTuple

import numpy as np

from ehamj.compiled import kernel
from ehamj.control.compiled.opening import FIELDS, SIZE, SUPPLY, Pressures, known, leaning, opening_for, range_of


class Remembered(NamedTuple):
    """Of one valve when what was wanted last changed."""

    opening: float
    """Of the edges, as they were to stand [mA]."""
    lean: float
    """To which side of its play the spool leads them, −1 to 1."""
    wanted: float
    """[V]"""
    command: float
    """[V]"""


OWN: Final = len(Remembered._fields)
BEGUN, PRESENT = len(Pressures._fields), len(Pressures._fields) + OWN
"""Where in a valve's memory, after its `Pressures` at the last sample, what is remembered of the last step and of this
one begin."""
REMEMBERS: Final = PRESENT + OWN


@kernel
def begin_stage(number, memory, lanes):  # type: ignore[no-untyped-def]
    """Begin a step, or begin it again."""
    width, values = len(lanes), memory.stage
    again = memory.step[0] == number
    memory.step[0] = number
    for valve in range(values.size // (REMEMBERS * width)):
        begun = (valve * REMEMBERS + BEGUN) * width
        present = begun + OWN * width
        for k in range(OWN * width):
            if again:
                values[present + k] = values[begun + k]
            else:
                values[begun + k] = values[present + k]


@kernel
def note_sample(share, readings, channels, numbers, memory, lanes):  # type: ignore[no-untyped-def]
    """Take the pressures from the readings of a sample."""
    width, values = len(lanes), memory.stage
    fades = memory.step[1] != share
    memory.step[1] = share
    for valve in range(values.size // (REMEMBERS * width)):
        at = valve * REMEMBERS * width
        for lane in range(width):
            if channels.size > 0:
                values[at + lane] = readings[channels[2 * valve] * width + lane]
                values[at + width + lane] = readings[channels[2 * valve + 1] * width + lane]
            if channels.size % 2 > 0:
                values[at + 2 * width + lane] = readings[channels[channels.size - 1] * width + lane]
            else:
                values[at + 2 * width + lane] = numbers[(valve * SIZE + SUPPLY) * width + lane]
        if fades:  # what is wanted need not change when the offset's share does
            for lane in range(width):
                values[at + (BEGUN + 2) * width + lane] = values[at + (PRESENT + 2) * width + lane] = np.nan


@kernel
def linearised(wanted, i, numbers, memory, lanes):  # type: ignore[no-untyped-def]
    """The command [V] for a wanted voltage [V], of valve and lane ``i``."""
    width, values = len(lanes), memory.stage
    valve, lane = i // width, i % width
    at = valve * REMEMBERS * width + lane
    present = at + PRESENT * width
    if wanted == values[present + 2 * width]:
        return values[present + 3 * width]
    first = valve * SIZE * width + lane
    own, curve = known(numbers, first, lanes), first + FIELDS * width
    pressures = Pressures(values[at], values[at + width], values[at + 2 * width])
    opening = opening_for(wanted, pressures, own, numbers, curve, lanes)
    lean = leaning(values[present], opening, values[present + width], own)
    command = (opening + own.play * lean - memory.step[1] * own.offset) / own.valve_gain
    values[present], values[present + width] = opening, lean
    values[present + 2 * width], values[present + 3 * width] = wanted, command
    return command


@kernel
def taken_by_valves(total, share, numbers, memory, result, lanes):  # type: ignore[no-untyped-def]
    """What fade and the valves' ranges take from the wanted voltages of each valve (and lane), applied − wanted."""
    width, values = len(lanes), memory.stage
    for i in range(total.size):
        first, at = (i // width) * SIZE * width + i % width, (i // width) * REMEMBERS * width + i % width
        own, curve = known(numbers, first, lanes), first + FIELDS * width
        pressures = Pressures(values[at], values[at + width], values[at + 2 * width])
        low, high = range_of(pressures, own, numbers, curve, lanes)
        result[i] = min(max(share * total[i], low), high) - total[i]
