"""The stepping loop of the small-motion engine, compiled: as that of `ehamj.mujoco.advance`, for all lanes at once."""

from collections.abc import Sequence
from functools import cache
from typing import Any, Final, NamedTuple, Self

import numpy as np

from ehamj.compiled import kernel
from ehamj.compiled.kept import compiled
from ehamj.compiled.lanes import add_products, copy_lanes, peek, poke
from ehamj.control.compiled.laws import AT_ONCE, FAILED, convert_held, release, take_sample
from ehamj.control.compiled.sensing import read_sensors
from ehamj.control.compiled.signals import gather, take
from ehamj.isolator.cylinder import chamber_volumes
from ehamj.isolator.spool import limits_reached
from ehamj.memory import INPUTS, ORDERS
from ehamj.mujoco.rows import LIMITS
from ehamj.smallmotion.floor import known, ride
from ehamj.smallmotion.isolators import (
    AT_LIMIT,
    BLOCK,
    COMMAND,
    DRAWN,
    INTO_1,
    METERING,
    OWN,
    STATE,
    STROKE,
    SUPPLY,
    TAKEN,
    isolator_in,
    settle,
    state_in,
)  # fmt: skip
from ehamj.smallmotion.stage import CONNECTED, Commanded, evaluate, runge_kutta
from ehamj.stopped import CHAMBER_1_EMPTY, CHAMBER_2_EMPTY, DONE, LAW_FAILED, NOT_FINITE, TOO_LARGE

LARGEST_TURN: Final = 1e-3
"""Angle beyond which motions are not small [rad]: what is left out is a thousandth there."""

COUNTS: Final = len(LIMITS.names or ())
"""Limits that are counted of each mount."""


class Counted(NamedTuple):
    """Added to at every state; flat with the lane last."""

    drawn: Any
    """(5,) flow [m³/s] and power [W] at the present state; sum of flows, largest flow, sum of power."""
    kept: Any
    """(4 m + 3) what was counted of a lane when it ended: limits of each mount, the last three of ``drawn``."""


class Recorded(NamedTuple):
    """Rows, flat with the lane last."""

    states: Any
    """(rows, 2 n + activations)"""
    accelerations: Any
    """(rows, n)"""
    commands: Any
    """(rows, m)"""
    flows: Any
    """(rows, m, 2)"""
    laws: Any
    """(rows, states of the law)"""
    readings: Any
    """(rows, channels)"""
    every: int
    """Each step whose number is a multiple of this is recorded."""
    room: int
    """Rows that there is room for."""

    @classmethod
    def of(cls, sizes: Sequence[int], every: int, room: int) -> Self:
        """Room for so many rows of so many numbers each."""
        states, accelerations, commands, flows, laws, readings = (np.empty(room * size) for size in sizes)
        return cls(states, accelerations, commands, flows, laws, readings, every, room)

    def after(self, rows: int) -> Self:
        """The same, from a later row on."""
        tables = (table[rows * (table.size // self.room) :] for table in self[:6])
        return type(self)._make((*tables, self.every, self.room - rows))

    def move(self, first: int, rows: int) -> None:
        """Let rows from the first one on, of so many, take the place of those before."""
        for table in self[:6]:
            size = table.size // self.room
            table[: (rows - first) * size] = table[first * size : rows * size]


class Plates(NamedTuple):
    """What a law's channels see of the mechanics; flat with the lane last."""

    rest: Any
    """(6,) coordinates in the equilibrium [m, rad]."""
    plate: Any
    """(m,) plates in the equilibrium [m]."""


@kernel
def within(own, scratch, lanes):  # type: ignore[no-untyped-def]
    """Whether nothing has failed in any lane; what is wrong where, `failing` says."""
    w, n, wrong = len(lanes), own.sizes.coordinates, 0
    state, rate, blocks = scratch.state, scratch.rate, own.blocks
    for k in range(3 * w, 6 * w):
        wrong |= abs(peek(state, k)) > LARGEST_TURN
    for k in range(state.size):
        wrong |= peek(state, k) - peek(state, k) != 0.0
    for k in range(n * w, (2 * n + OWN * own.forms.size) * w):
        wrong |= peek(rate, k) - peek(rate, k) != 0.0
    for mount in range(own.forms.size):
        for lane in range(w):
            at = mount * BLOCK * w + lane
            one, two = chamber_volumes(peek(blocks, at + STROKE * w), isolator_in(blocks, at, lanes).cylinder)
            wrong |= (one <= 0.0) | (two <= 0.0)
    return wrong == 0


@kernel
def failing(own, scratch, lane, lanes):  # type: ignore[no-untyped-def]
    """Status and mount (−1: the machine) of one lane."""
    w, n = len(lanes), own.sizes.coordinates
    least, status, where = 0.0, DONE, -1
    for mount in range(own.forms.size):
        at = mount * BLOCK * w + lane
        for k in range(2 * OWN):
            value = peek(own.blocks, at + (STATE + k) * w)
            if value - value != 0.0:
                return NOT_FINITE, mount
        cylinder = isolator_in(own.blocks, at, lanes).cylinder
        one, two = chamber_volumes(peek(own.blocks, at + STROKE * w), cylinder)
        share_1, share_2 = one / cylinder.volume_1, two / cylinder.volume_2
        if share_1 <= least:
            least, status, where = share_1, CHAMBER_1_EMPTY, mount
        if share_2 <= least:
            least, status, where = share_2, CHAMBER_2_EMPTY, mount
    for k in range(scratch.state.size // w):
        if scratch.state[k * w + lane] - scratch.state[k * w + lane] != 0.0:
            return NOT_FINITE, -1
    for k in range(n):
        value = scratch.rate[(n + k) * w + lane]
        if value - value != 0.0:
            return NOT_FINITE, -1
    if status == DONE:
        for k in range(3, 6):
            if abs(scratch.state[k * w + lane]) > LARGEST_TURN:
                return TOO_LARGE, -1
    return status, where


@kernel
def count_limits(own, counted, lanes):  # type: ignore[no-untyped-def]
    """Add the present state to what is counted: at each mount in its block, oil drawn in ``counted``."""
    w, blocks, drawn = len(lanes), own.blocks, counted.drawn
    for k in range(2 * w):
        poke(drawn, k, 0.0)
    for mount in range(own.forms.size):
        for lane in range(w):
            at = mount * BLOCK * w + lane
            isolator, state, to = (
                isolator_in(blocks, at, lanes),
                state_in(blocks, at + STATE * w, lanes),
                at + AT_LIMIT * w,
            )
            command, spool, drive = limits_reached(peek(blocks, at + COMMAND * w), state.spool, isolator.spool)
            void = (state.pressure_1 <= isolator.fluid.vapour_pressure) | (
                state.pressure_2 <= isolator.fluid.vapour_pressure
            )
            poke(blocks, to, peek(blocks, to) + command)
            poke(blocks, to + w, peek(blocks, to + w) + spool)
            poke(blocks, to + 2 * w, peek(blocks, to + 2 * w) + drive)
            poke(blocks, to + 3 * w, peek(blocks, to + 3 * w) + void)
            poke(blocks, at + TAKEN * w, peek(blocks, at + CONNECTED * w) * peek(blocks, at + DRAWN * w))
    add_products(drawn, 0, blocks, CONNECTED, blocks, DRAWN, (BLOCK, BLOCK), own.forms.size, lanes)
    add_products(drawn, 1, blocks, TAKEN, blocks, SUPPLY, (BLOCK, BLOCK), own.forms.size, lanes)
    for lane in range(w):
        flow = peek(drawn, lane)
        poke(drawn, 2 * w + lane, peek(drawn, 2 * w + lane) + flow)
        poke(drawn, 3 * w + lane, max(peek(drawn, 3 * w + lane), flow))
        poke(drawn, 4 * w + lane, peek(drawn, 4 * w + lane) + peek(drawn, w + lane))


@kernel
def write_row(own, recorded, row, values, readings, scratch, lanes):  # type: ignore[no-untyped-def]
    """Record the present state."""
    w, n, mounts = len(lanes), own.sizes.coordinates, own.forms.size
    size = scratch.state.size
    copy_lanes(scratch.state, 0, recorded.states, row * size, size)
    copy_lanes(scratch.rate, n * w, recorded.accelerations, row * n * w, n * w)
    for mount in range(mounts):
        at, to = mount * BLOCK * w, (row * mounts + mount) * w
        copy_lanes(own.blocks, at + COMMAND * w, recorded.commands, to, w)
        copy_lanes(own.blocks, at + INTO_1 * w, recorded.flows, 2 * to, 2 * w)
    laws, channels = recorded.laws.size // recorded.room, readings.size
    copy_lanes(values, 0, recorded.laws, row * laws, laws)
    copy_lanes(readings, 0, recorded.readings, row * channels, channels)


@kernel
def look(own, plates, scratch, motion, length, velocity, lanes):  # type: ignore[no-untyped-def]
    """What channels are made of: machine's coordinates and rates, and the plates'."""
    w, n = len(lanes), own.sizes.coordinates
    qpos, qvel, qacc = motion
    copy_lanes(scratch.state, n * w, qvel, 0, 6 * w)
    copy_lanes(scratch.rate, n * w, qacc, 0, 6 * w)
    for k in range(6 * w):
        poke(qpos, k, peek(plates.rest, k) + peek(scratch.state, k))
    copy_lanes(plates.plate, 0, length, 0, length.size)
    for k in range(velocity.size):
        poke(velocity, k, 0.0)
    for mount in range(own.forms.size):
        add_products(length, mount, own.levers, mount * n, scratch.state, 0, (1, 1), n, lanes)
        add_products(velocity, mount, own.levers, mount * n, scratch.state, n, (1, 1), n, lanes)


@kernel
def keep_counts(own, counted, lane, lanes):  # type: ignore[no-untyped-def]
    """Keep what was counted of a lane that has ended, whose states go on without a meaning."""
    w, size = len(lanes), COUNTS
    for mount in range(own.forms.size):
        for k in range(size):
            counts = peek(own.blocks, (mount * BLOCK + AT_LIMIT + k) * w + lane)
            poke(counted.kept, (mount * size + k) * w + lane, counts)
    for k in range(3):
        poke(counted.kept, (own.forms.size * size + k) * w + lane, peek(counted.drawn, (2 + k) * w + lane))


@kernel
def end_failed(own, scratch, counted, ended, number, lanes):  # type: ignore[no-untyped-def]
    """Note where lanes that have failed ended; whether one is left."""
    left = 0
    for lane in range(len(lanes)):
        if ended[lane, 1] == DONE:
            status, mount = failing(own, scratch, lane, lanes)
            if status == DONE:
                left += 1
            else:
                ended[lane, 0], ended[lane, 1], ended[lane, 2] = number, status, mount
                keep_counts(own, counted, lane, lanes)
    return left > 0


@cache
def compiled_advance() -> Any:
    """The loop; it is compiled for a width when it is first called with it."""

    def advance(own, given, stretch, recorded, counted, plates, law, scratch, ended, lanes):  # type: ignore[no-untyped-def]
        first, steps, last = stretch
        laws, memory, sensing, readings, noise, first_noise, control = law
        commanded = Commanded(control, memory.switching)
        w, h, mounts = len(lanes), own.sizes.step, own.forms.size
        row, acts = 0, 2 * own.sizes.coordinates
        signals, act = np.zeros(sensing.layout.size * w), scratch.state[acts * w :]
        motion = (np.zeros(6 * w), np.zeros(6 * w), np.zeros(6 * w))
        length, velocity = np.zeros(mounts * w), np.zeros(mounts * w)
        inputs = np.zeros((mounts + 1) * len(INPUTS) * ORDERS * w)
        for k in range(steps + last):
            number = first + k
            time = number * h
            ride(given.floor, given.inverse, given.times, k, scratch.riding, own.sizes.coordinates, lanes)
            release(number, laws, memory, control, lanes)
            evaluate(own, given, k, 0, time, commanded, scratch, lanes)
            if not within(own, scratch, lanes) and not end_failed(own, scratch, counted, ended, number, lanes):
                return k, row
            sampled = laws.base > 0 and number % laws.base == 0
            if sampled or sensing.order > 0:
                look(own, plates, scratch, motion, length, velocity, lanes)
                known(given.floor, scratch.riding, inputs, lanes)
                gather(signals, sensing.layout, motion, act, length, velocity, inputs, 1.0 / h, lanes)
                for mount in range(mounts):
                    take(signals, sensing.layout.edges + mount, own.blocks, (mount * BLOCK + METERING) * w, 1.0, lanes)
                take(signals, sensing.layout.supply, own.blocks, SUPPLY * w, 1.0, lanes)
                sample = number // laws.base - first_noise if sampled else -1
                read_sensors(number, sample, sensing, noise, signals, readings, lanes)
            if sampled:
                answer = take_sample(number, time, laws, readings.readings, memory, lanes)
                if answer == FAILED:
                    ended[0, 0], ended[0, 1], ended[0, 2] = number, LAW_FAILED, -1
                    keep_counts(own, counted, 0, lanes)
                    return k, row
                if answer == AT_ONCE:
                    convert_held(number, laws, memory, control, lanes)
                    evaluate(own, given, k, 0, time, commanded, scratch, lanes)
            count_limits(own, counted, lanes)
            if number % recorded.every == 0:
                write_row(own, recorded, row, memory.values, readings.readings, scratch, lanes)
                row += 1
            if k < steps:
                runge_kutta(own, given, k, time, commanded, scratch, lanes)
                settle(own.forms, own.blocks, scratch.state, acts, time, lanes)
        return steps, row

    return compiled(advance)
