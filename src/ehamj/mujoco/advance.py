"""The stepping loop, compiled: inputs in, one Runge–Kutta step of the engine, a row out now and then."""

import ctypes
import math
from functools import cache
from typing import Any, Final, NamedTuple

import mujoco
import numba
import numpy as np
from numba import carray, types
from numpy.typing import NDArray

from ehamj.compiled import kernel
from ehamj.control.channels import N_SIGNALS
from ehamj.control.compiled.loop import (
    AT_ONCE,
    FAILED,
    NO_LOOP,
    Loop,
    convert_held,
    gather,
    read_sensors,
    release,
    take_sample,
)
from ehamj.isolator.valve import play, spool_target
from ehamj.memory import (
    CUBICS,
    LOAD,
    LOADED,
    METERING,
    N_INPUTS,
    N_STATES,
    STAGE_COMMAND,
    STAGE_DRAWN,
    STAGE_FLOW,
    STAGE_GROUND,
    STEP_RATE,
    STEP_START,
)
from ehamj.compiled import compiled_here
from ehamj.mujoco.callbacks import (
    DRIVE_LIMIT,
    END_STOPS,
    FREQUENCY,
    HYSTERESIS,
    N_PARAMETERS,
    SPOOL_STROKE,
    VALVE_GAIN,
    VAPOUR_PRESSURE,
    VOLTAGE_LIMIT,
    VOLUME_1,
    VOLUME_2,
    chamber_volumes,
    supply_of,
)
from ehamj.mujoco.hold import library
from ehamj.mujoco.offsets import offsets
from ehamj.mujoco.pointers import call_on_state, call_runge_kutta, doubles_at, store_double
from ehamj.plant.axes import DOFS
from ehamj.plant.mounts import N_MOUNTS

Array = NDArray[np.float64]

DONE: Final = 0
NOT_FINITE: Final = 1
CHAMBER_1_EMPTY: Final = 2
CHAMBER_2_EMPTY: Final = 3
LAW_FAILED: Final = 4

TALLY: Final = ("command", "spool", "spool_drive", "cavitation")
"""What is counted per step and mount; then come the sums of supply flow, its peak, and supply power."""
TALLY_FLOW: Final = len(TALLY) * N_MOUNTS
N_TALLY: Final = TALLY_FLOW + 3


NOT_LOADED: Final = (np.zeros((0, len(DOFS), 2)), np.zeros((0, len(DOFS), 2)))
"""No force on the machine itself."""


class Stopped(NamedTuple):
    """How a stretch ended: steps done, why (`DONE`, `NOT_FINITE`, …), and at which mount (−1: the machine)."""

    steps: int
    status: int
    mount: int


@kernel
def write_inputs(shared, time, rate, start, end):  # type: ignore[no-untyped-def]
    """Hand a step its inputs: (n_inputs, …) values and slopes·step at its start and end."""
    shared[STEP_START] = time
    shared[STEP_RATE] = rate
    for channel in range(N_INPUTS):
        offset = CUBICS + 4 * channel
        shared[offset], shared[offset + 1] = start[channel, 0], start[channel, 1]
        shared[offset + 2], shared[offset + 3] = end[channel, 0], end[channel, 1]


@kernel
def write_load(shared, start, end):  # type: ignore[no-untyped-def]
    """Hand a step the force on the machine: (dof, 2) value and slope·step at its start and end."""
    shared[LOADED] = 1.0
    for dof in range(len(DOFS)):
        offset = LOAD + 4 * dof
        shared[offset], shared[offset + 1] = start[dof, 0], start[dof, 1]
        shared[offset + 2], shared[offset + 3] = end[dof, 0], end[dof, 1]


@kernel
def check(act, act_dot, qacc, length, shared, table):  # type: ignore[no-untyped-def]
    """Status and mount of the present state: everything finite, no chamber empty (of several the emptiest)."""
    least, status, where = 0.0, DONE, -1
    for mount in range(N_MOUNTS):
        own = N_PARAMETERS * mount
        total = 0.0
        for k in range(N_STATES * mount, N_STATES * (mount + 1)):
            total += act[k] - act[k] + act_dot[k] - act_dot[k]
        if total != 0.0:  # a NaN or an infinity is the only number that is not itself minus itself
            return NOT_FINITE, mount
        volume_1, volume_2 = chamber_volumes(length[mount] - shared[STAGE_GROUND + mount], table, own)
        share_1, share_2 = volume_1 / table[own + VOLUME_1], volume_2 / table[own + VOLUME_2]
        if share_1 <= least:
            least, status, where = share_1, CHAMBER_1_EMPTY, mount
        if share_2 <= least:
            least, status, where = share_2, CHAMBER_2_EMPTY, mount
    for k in range(qacc.size):
        if qacc[k] - qacc[k] != 0.0:
            return NOT_FINITE, -1
    return status, where


@kernel
def count_limits(act, control, shared, table, tally):  # type: ignore[no-untyped-def]
    """Add the present state to the tally of limits reached, and of oil drawn."""
    drawn, power = 0.0, 0.0
    for mount in range(N_MOUNTS):
        own, first = N_PARAMETERS * mount, N_STATES * mount
        command = control[mount] + shared[STAGE_COMMAND + mount]
        target = spool_target(command, table[own + VALVE_GAIN], table[own + VOLTAGE_LIMIT])
        drive = table[own + FREQUENCY] ** 2 * (target - act[first])
        vapour = table[own + VAPOUR_PRESSURE]
        tally[mount] += abs(command) >= table[own + VOLTAGE_LIMIT]
        tally[N_MOUNTS + mount] += abs(act[first]) >= table[own + SPOOL_STROKE]
        tally[2 * N_MOUNTS + mount] += abs(drive) >= table[own + DRIVE_LIMIT]
        tally[3 * N_MOUNTS + mount] += act[first + 2] <= vapour or act[first + 3] <= vapour
        flow = shared[STAGE_DRAWN + mount]
        drawn += flow
        power += flow * supply_of(act, table, own)
    tally[TALLY_FLOW] += drawn
    tally[TALLY_FLOW + 1] = max(tally[TALLY_FLOW + 1], drawn)
    tally[TALLY_FLOW + 2] += power


@kernel
def settle_valves(act, shared, table):  # type: ignore[no-untyped-def]
    """What a step leaves to be put right at its end: where hysteresis holds the edges, and spools at their stops."""
    for mount in range(N_MOUNTS):
        own, first = N_PARAMETERS * mount, N_STATES * mount
        if table[own + END_STOPS] != 0.0 and abs(act[first]) >= table[own + SPOOL_STROKE]:
            act[first] = math.copysign(table[own + SPOOL_STROKE], act[first])
            if act[first] * act[first + 1] > 0.0:
                act[first + 1] = 0.0
        if table[own + HYSTERESIS] != 0.0:
            shared[METERING + mount] = play(shared[METERING + mount], act[first], table[own + HYSTERESIS])


class Columns(NamedTuple):
    """Where each quantity lies in a recorded row, as (first, end)."""

    qpos: tuple[int, int]
    qvel: tuple[int, int]
    qacc: tuple[int, int]
    act: tuple[int, int]
    command: tuple[int, int]
    flow: tuple[int, int]
    drawn: tuple[int, int]
    states: tuple[int, int]
    """States of the digital controller."""
    readings: tuple[int, int]
    """What its sensors last read."""


def compile_loop() -> None:
    """Compile the stepping loop now, or take it from the cache, so that no simulation's timing contains it."""
    _advance()


def columns(model: mujoco.MjModel, loop: Loop = NO_LOOP) -> Columns:
    """Row layout for a model and its controller."""
    sizes = (model.nq, model.nv, model.nv, model.na, N_MOUNTS, 2 * N_MOUNTS, N_MOUNTS, loop.states, loop.readings)
    ends = np.cumsum(sizes)
    return Columns(*((int(end - size), int(end)) for size, end in zip(sizes, ends, strict=True)))


def row_size(model: mujoco.MjModel, loop: Loop = NO_LOOP) -> int:
    """Length of a recorded row."""
    return columns(model, loop).readings[1]


@cache
def _engine() -> tuple[int, int]:
    """Addresses of mj_forward and mj_RungeKutta."""
    forward, runge_kutta = library().mj_forward, library().mj_RungeKutta
    return tuple(ctypes.cast(f, ctypes.c_void_p).value for f in (forward, runge_kutta))  # type: ignore[return-value]


@cache
def _advance() -> Any:
    at = offsets()
    time_at, user_at, shared_at, ctrl_at, length_at = (
        at.time,
        at.actuator_user,
        at.userdata,
        at.ctrl,
        at.actuator_length,
    )
    velocity_at = at.actuator_velocity
    qpos_at, qvel_at, qacc_at, act_at, act_dot_at = at.qpos, at.qvel, at.qacc, at.act, at.act_dot

    def advance(  # type: ignore[no-untyped-def]
        forward, runge_kutta, model, data, nq, nv, na, nuserdata, first, steps, h, last, start, end, every, rows, tally,
        pushed, released,
        parts, matrices, inputs_of, terms, weights, filters, feedthrough, zeroed, grid, converter, base, n_states,
        readings_at, memory, noise, noise_first,
    ):  # fmt: skip
        shared = carray(doubles_at(data, shared_at), nuserdata)
        table = carray(doubles_at(model, user_at), N_MOUNTS * N_PARAMETERS)
        control = carray(doubles_at(data, ctrl_at), N_MOUNTS)
        length = carray(doubles_at(data, length_at), N_MOUNTS)
        velocity = carray(doubles_at(data, velocity_at), N_MOUNTS)
        qpos, qvel = carray(doubles_at(data, qpos_at), nq), carray(doubles_at(data, qvel_at), nv)
        qacc = carray(doubles_at(data, qacc_at), nv)
        act, act_dot = carray(doubles_at(data, act_at), na), carray(doubles_at(data, act_dot_at), na)
        channels, filtered = terms.shape[0], filters.shape[1] > 0
        states = memory[:n_states]
        readings, rest = memory[readings_at : readings_at + channels], memory[readings_at + channels :][:channels]
        filter_states = memory[readings_at + 2 * channels :]
        signals, raw, analogue = np.zeros(N_SIGNALS), np.zeros(channels), np.zeros(channels)
        scratch, measured, totals = np.zeros(memory.size), np.zeros(inputs_of.size), np.zeros((2, N_MOUNTS))
        row = 0
        for k in range(steps + last):
            number = first + k
            time = number * h
            store_double(data, time_at, time)
            write_inputs(shared, time, 1.0 / h, start[k], end[k])
            if pushed.shape[0] > 0:
                write_load(shared, pushed[k], released[k])
            release(number, parts, converter, memory, control)
            call_on_state(forward, model, data)
            status, mount = check(act, act_dot, qacc, length, shared, table)
            if status != DONE:
                return k, status, mount, row
            sampled = base > 0 and number % base == 0
            if sampled or filtered:
                gather(signals, qpos, qvel, qacc, act, length, velocity, start[k], 1.0 / h)
                sample = number // base - noise_first if sampled else -1
                read_sensors(
                    number, sample, terms, weights, filters, feedthrough, zeroed, grid, noise, signals, raw, analogue,
                    scratch[: filter_states.size], rest, filter_states, readings,
                )  # fmt: skip
            if sampled:
                answer = take_sample(
                    number, time, parts, matrices, inputs_of, converter, readings, memory, measured, scratch, totals
                )
                if answer == FAILED:
                    return k, LAW_FAILED, -1, row
                if answer == AT_ONCE:
                    convert_held(parts, converter, memory, control)
                    call_on_state(forward, model, data)
            count_limits(act, control, shared, table, tally)
            if number % every == 0:
                out = rows[row]
                row += 1
                column = 0
                for part in (qpos, qvel, qacc, act):
                    out[column : column + part.size] = part
                    column += part.size
                for mount in range(N_MOUNTS):
                    out[column + mount] = control[mount] + shared[STAGE_COMMAND + mount]
                column += N_MOUNTS
                out[column : column + 3 * N_MOUNTS] = shared[STAGE_FLOW : STAGE_FLOW + 3 * N_MOUNTS]
                column += 3 * N_MOUNTS
                out[column : column + n_states] = states
                out[column + n_states :] = readings
            if k < steps:
                call_runge_kutta(runge_kutta, model, data, 4)
                settle_valves(act, shared, table)
        return steps, DONE, -1, row

    floats1, floats2, floats3 = types.float64[::1], types.float64[:, ::1], types.float64[:, :, ::1]
    inputs3, integers2 = types.Array(types.float64, 3, "C", readonly=True), types.int64[:, ::1]
    signature = (
        *(types.intp,) * 4,
        *(types.int64,) * 6,
        types.float64,
        types.int64,
        *(inputs3,) * 2,
        types.int64,
        floats2,
        floats1,
        *(inputs3,) * 2,
        integers2,
        floats1,
        types.int64[::1],
        integers2,
        floats2,
        floats3,
        floats1,
        floats1,
        floats2,
        floats1,
        *(types.int64,) * 3,
        floats1,
        floats2,
        types.int64,
    )
    with compiled_here() as kept:
        return numba.njit([signature], nogil=True, error_model="numpy", cache=kept)(advance)


def advance(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    first: int,
    steps: int,
    inputs: tuple[Array, Array],
    every: int,
    rows: Array,
    tally: Array,
    last: bool = False,
    loop: Loop = NO_LOOP,
    noise: Array | None = None,
    load: tuple[Array, Array] = NOT_LOADED,
) -> tuple[Stopped, int]:
    """Take ``steps`` steps from step number ``first``; call it with the hydraulics installed.

    Args:
        model: compiled model.
        data: its state, which is advanced.
        first: number of the first step; its time is first·timestep.
        steps: how many.
        inputs: value, slope·timestep and second derivative at the start and at the end of each step,
            (steps (+1), n_inputs, 3) each.
        every: record each step whose number is a multiple of this.
        rows: where rows go, (n, row_size).
        tally: counts of limits, see `TALLY`; added to.
        last: also evaluate (and record) the state after the last step; ``inputs`` then have one row more.
        loop: digital controller, whose memory is advanced.
        noise: noise of its readings at the samples among these steps (`Loop.samples`), (samples, channels).
        load: force on the machine itself, value and slope·timestep at the start and at the end of each step,
            (steps (+1), 6, 2) each.

    Returns:
        How it stopped, and the number of rows recorded.
    """
    start, end, pushed, released = (np.ascontiguousarray(part) for part in (*inputs, *load))
    for part in (start, end, pushed, released):
        part.flags.writeable = False
    steps_done, status, mount, recorded = _advance()(
        *_engine(),
        model._address,
        data._address,
        model.nq,
        model.nv,
        model.na,
        model.nuserdata,
        first,
        steps,
        model.opt.timestep,
        int(last),
        start,
        end,
        every,
        rows,
        tally,
        pushed,
        released,
        loop.parts,
        loop.matrices,
        loop.inputs_of,
        loop.terms,
        loop.weights,
        loop.filters,
        loop.feedthrough,
        loop.zeroed,
        loop.grid,
        loop.converter,
        loop.base,
        loop.states,
        loop.readings_at,
        loop.memory,
        np.zeros((0, loop.readings)) if noise is None else np.ascontiguousarray(noise),
        loop.samples(first, steps)[0],
    )
    return Stopped(steps_done, status, mount), recorded
