"""The stepping loop, compiled: inputs in, one Runge–Kutta step of the engine, a row out now and then."""

import ctypes
import math
from functools import cache
from typing import Any, Final, NamedTuple

import mujoco
import numba
import numpy as np
from numba import types

from ehamj.arrays import Array
from ehamj.compiled import copy, kernel
from ehamj.compiled.kept import compiled
from ehamj.compiled.native import c_function
from ehamj.control.compiled.laws import AT_ONCE, FAILED, convert_held, release, take_sample
from ehamj.control.compiled.sensing import read_sensors
from ehamj.control.compiled.signals import gather, take
from ehamj.control.loop import DigitalLoop, no_loop
from ehamj.isolator.cylinder import chamber_volumes
from ehamj.isolator.equations import settled
from ehamj.isolator.spool import limits_reached
from ehamj.memory import COMMAND, SLIDE, inputs, mounts_of, size
from ehamj.mujoco.callbacks import feed_from
from ehamj.mujoco.feet import plates
from ehamj.mujoco.hold import library
from ehamj.mujoco.offsets import offsets
from ehamj.mujoco.rows import Recording, Rows, Tally
from ehamj.mujoco.slides import place_slides, write_slides
from ehamj.mujoco.unpacking import isolator_of, options_of, put_cubic, state_of
from ehamj.mujoco.views import machine_of
from ehamj.plant.axes import DOFS
from ehamj.stopped import CHAMBER_1_EMPTY, CHAMBER_2_EMPTY, DONE, LAW_FAILED, NOT_FINITE, Stopped

STANDING: Final = np.zeros((0, 0, size(SLIDE)))
"""No slide moves."""

NOT_LOADED: Final = (np.zeros((0, len(DOFS), 2)), np.zeros((0, len(DOFS), 2)), STANDING)
"""No force on the machine itself, and no slide that moves."""

on_state = c_function(types.void, types.intp, types.intp)
"""void f(mjModel*, mjData*)"""
runge_kutta = c_function(types.void, types.intp, types.intp, types.int32)
"""void f(mjModel*, mjData*, int order)"""


class Engine(NamedTuple):
    """Addresses of mj_forward, mj_RungeKutta, the model and its data, and sizes of position and velocity."""

    forward: int
    runge_kutta: int
    model: int
    data: int
    nq: int
    nv: int

    @classmethod
    def of(cls, model: mujoco.MjModel, data: mujoco.MjData) -> "Engine":
        """Of a model and its data."""
        return cls(*_functions(), model._address, data._address, model.nq, model.nv)


class Stretch(NamedTuple):
    """Steps to take: number of the first, how many, whether the state after them is evaluated too, and their h [s]."""

    first: int
    steps: int
    last: bool
    timestep: float


class Given(NamedTuple):
    """Inputs and load at the start and at the end of each step, and what drives slides in it, read-only."""

    start: Array
    end: Array
    known: Array
    """`start`, each step's flat, as sensors take it."""
    pushed: Array
    released: Array
    slides: Array

    @classmethod
    def of(cls, given: tuple[Array, Array], load: tuple[Array, Array, Array]) -> "Given":
        """The arrays as the loop takes them."""
        start, end = (np.ascontiguousarray(part) for part in given)
        flat = start.reshape(start.shape[0], math.prod(start.shape[1:]))
        parts = [np.ascontiguousarray(part).view() for part in (start, end, flat, *load)]
        for part in parts:
            part.flags.writeable = False
        return cls(*parts)


@kernel
def write_inputs(machine, time, rate, start, end):  # type: ignore[no-untyped-def]
    """Hand a step its inputs: (mount, input, order) at its start and end."""
    step = machine.step[0]
    step.start, step.rate = time, rate
    for k in range(machine.mounts.size):
        mount = machine.mounts[k]
        put_cubic(mount.ground_x, start[k, 0], end[k, 0])
        put_cubic(mount.ground_y, start[k, 1], end[k, 1])
        put_cubic(mount.ground_z, start[k, 2], end[k, 2])
        put_cubic(mount.open_loop, start[k, COMMAND], end[k, COMMAND])


@kernel
def write_switches(machine, switching):  # type: ignore[no-untyped-def]
    """Hand a step what commands that switch within it add at its start, middle and end: (3·mount)."""
    count = machine.mounts.size
    for k in range(count):
        mount = machine.mounts[k]
        mount.switch_start, mount.switch_middle = switching[k], switching[count + k]
        mount.switch_end = switching[2 * count + k]


@kernel
def write_load(machine, start, end):  # type: ignore[no-untyped-def]
    """Hand a step the force on the machine: (dof, 2) value and slope·step at its start and end."""
    machine.step[0].loaded = 1.0
    for dof in range(machine.loads.size):
        put_cubic(machine.loads[dof], start[dof], end[dof])


@kernel
def excess(values):  # type: ignore[no-untyped-def]
    """Zero where all values are finite: a NaN or an infinity is the only number that is not itself minus itself."""
    total = 0.0
    for value in values:
        total += value - value
    return total


@kernel
def check(machine):  # type: ignore[no-untyped-def]
    """Status and mount of the present state: everything finite, no chamber empty (of several the emptiest)."""
    least, status, where = 0.0, DONE, -1
    for k in range(machine.mounts.size):
        if excess(state_of(machine.states[k])) + excess(state_of(machine.rates[k])) != 0.0:
            return NOT_FINITE, k
        own = isolator_of(machine.isolators[k]).cylinder
        volume_1, volume_2 = chamber_volumes(machine.length[k] - machine.mounts[k].ground, own)
        share_1, share_2 = volume_1 / own.volume_1, volume_2 / own.volume_2
        if share_1 <= least:
            least, status, where = share_1, CHAMBER_1_EMPTY, k
        if share_2 <= least:
            least, status, where = share_2, CHAMBER_2_EMPTY, k
    if excess(machine.qacc) != 0.0:
        return NOT_FINITE, -1
    return status, where


@kernel
def count_limits(machine, tally):  # type: ignore[no-untyped-def]
    """Add the present state to the tally of limits reached, and of oil drawn."""
    drawn, power = 0.0, 0.0
    for k in range(machine.mounts.size):
        mount, state, counted = machine.mounts[k], machine.states[k], tally.limits[k]
        own = isolator_of(machine.isolators[k])
        command, spool, drive = limits_reached(machine.control[k] + mount.command, state.spool, own.spool)
        vapour = own.fluid.vapour_pressure
        counted.command += command
        counted.spool += spool
        counted.spool_drive += drive
        counted.cavitation += state.pressure_1 <= vapour or state.pressure_2 <= vapour
        taken = machine.isolators[k].connected * mount.drawn
        drawn += taken
        power += taken * feed_from(machine, k).supply_pressure
    total = tally.drawn[0]
    total.flow += drawn
    total.peak_flow = max(total.peak_flow, drawn)
    total.power += power


@kernel
def settle_valves(machine):  # type: ignore[no-untyped-def]
    """What a step leaves to be put right at its end: spools at their stops, and where hysteresis holds the edges."""
    for k in range(machine.mounts.size):
        mount, state, record = machine.mounts[k], machine.states[k], machine.isolators[k]
        state.spool, state.spool_rate, mount.metering = settled(
            state_of(state), mount.metering, machine.time[0], options_of(machine.act, record), isolator_of(record)
        )


@kernel
def write_row(machine, rows, row, values, readings):  # type: ignore[no-untyped-def]
    """Record the present state."""
    copy(machine.qpos, rows.qpos[row])
    copy(machine.qvel, rows.qvel[row])
    copy(machine.qacc, rows.qacc[row])
    copy(machine.act, rows.act[row])
    for k in range(machine.mounts.size):
        mount = machine.mounts[k]
        rows.command[row, k] = machine.control[k] + mount.command
        rows.flow[row, k, 0], rows.flow[row, k, 1] = mount.into_1, mount.into_2
    copy(values, rows.states[row])
    copy(readings, rows.readings[row])


@cache
def _functions() -> tuple[int, int]:
    """Addresses of mj_forward and mj_RungeKutta."""
    forward, runge_kutta = library().mj_forward, library().mj_RungeKutta
    return tuple(ctypes.cast(f, ctypes.c_void_p).value for f in (forward, runge_kutta))  # type: ignore[return-value]


@cache
def _advance() -> Any:
    """The loop, compiled for the types of a stretch without anything in it."""
    at = offsets()

    def advance(engine, stretch, driving, recording, laws, memory, sensing, readings, noise, first_noise):  # type: ignore[no-untyped-def]
        model, data = engine.model, engine.data
        machine, h, every = machine_of(model, data, at, engine.nq, engine.nv), stretch.timestep, recording.every
        signals, row = np.zeros(sensing.layout.size), 0
        length, velocity, fed = np.zeros(machine.mounts.size), np.zeros(machine.mounts.size), np.zeros(1)
        motion, alone = (machine.qpos, machine.qvel, machine.qacc), (0.0,)
        for k in range(stretch.steps + stretch.last):
            number = stretch.first + k
            time = number * h
            machine.time[0] = time
            write_inputs(machine, time, 1.0 / h, driving.start[k], driving.end[k])
            if driving.pushed.shape[0] > 0:
                write_load(machine, driving.pushed[k], driving.released[k])
            if driving.slides.shape[0] > 0:
                write_slides(machine, driving.slides[k])
            release(number, laws, memory, machine.control, alone)
            write_switches(machine, memory.switching)
            on_state(engine.forward, (model, data))
            status, mount = check(machine)
            if status != DONE:
                return k, status, mount, row
            sampled = laws.base > 0 and number % laws.base == 0
            if sampled or sensing.order > 0:
                plates(machine, length, velocity)
                gather(signals, sensing.layout, motion, machine.act, length, velocity, driving.known[k], 1.0 / h, alone)
                for mount in range(machine.mounts.size):
                    signals[sensing.layout.edges + mount] = machine.mounts[mount].metering
                if machine.mounts.size > 0:
                    fed[0] = feed_from(machine, 0).supply_pressure
                    take(signals, sensing.layout.supply, fed, 0, 1.0, alone)
                sample = number // laws.base - first_noise if sampled else -1
                read_sensors(number, sample, sensing, noise, signals, readings, alone)
            if sampled:
                answer = take_sample(number, time, laws, readings.readings, memory, alone)
                if answer == FAILED:
                    return k, LAW_FAILED, -1, row
                if answer == AT_ONCE:
                    convert_held(number, laws, memory, machine.control, alone)
                    write_switches(machine, memory.switching)
                    on_state(engine.forward, (model, data))
            count_limits(machine, recording.tally)
            if number % every == 0:
                write_row(machine, recording.rows, row, memory.values, readings.readings)
                row += 1
            if k < stretch.steps:
                runge_kutta(engine.runge_kutta, (model, data, 4))
                settle_valves(machine)
                place_slides(machine)
        return stretch.steps, DONE, -1, row

    model = mujoco.MjModel.from_xml_string("<mujoco/>")
    loop = no_loop(0)
    nothing = (inputs(0, 0), inputs(0, 0))
    recording = Recording(1, Rows(*(np.zeros((0,) * n) for n in (2, 2, 2, 2, 2, 3, 2, 2))), Tally.of(0))
    example = _arguments(Engine.of(model, mujoco.MjData(model)), Stretch(0, 0, False, 1.0), nothing, recording, loop)
    return compiled(advance, tuple(numba.typeof(argument) for argument in example))


def _arguments(
    engine: Engine,
    stretch: Stretch,
    given: tuple[Array, Array],
    recording: Recording,
    loop: DigitalLoop,
    noise: Array | None = None,
    load: tuple[Array, Array, Array] = NOT_LOADED,
) -> tuple[Any, ...]:
    """What the compiled loop takes."""
    silent = np.zeros((0, loop.sensing.channels))
    tables = (loop.laws, loop.law_memory, loop.sensing, loop.readings)
    heard = silent if noise is None else np.ascontiguousarray(noise)
    return (engine, stretch, Given.of(given, load), recording, *tables, heard, loop.samples(*stretch[:2])[0])


def compile_loop() -> None:
    """Compile the stepping loop now, or take it from the cache, so that no simulation's timing contains it."""
    _advance()


def advance(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    first: int,
    steps: int,
    given: tuple[Array, Array],
    recording: Recording,
    last: bool = False,
    loop: DigitalLoop | None = None,
    noise: Array | None = None,
    load: tuple[Array, Array, Array] = NOT_LOADED,
) -> tuple[Stopped, int]:
    """Take ``steps`` steps from step number ``first``; call it with the hydraulics installed.

    Args:
        model: compiled model.
        data: its state, which is advanced.
        first: number of the first step; its time is first·timestep.
        steps: how many.
        given: value, slope·timestep and second derivative at the start and at the end of each step, (steps (+1),
            mount, input, 3) each; see `ehamj.memory.inputs`.
        recording: where rows and counts go.
        last: also evaluate (and record) the state after the last step; ``given`` then has one row more.
        loop: digital controller, whose memory is advanced.
        noise: noise of its readings at the samples among these steps (`DigitalLoop.samples`), (samples, channels).
        load: force on the machine itself, value and slope·timestep at the start and at the end of each step,
            (steps (+1), 6, 2) each; and what drives slides in each step (`ehamj.mujoco.slides.drives`).

    Returns:
        How it stopped, and the number of rows recorded.
    """
    engine, stretch = Engine.of(model, data), Stretch(int(first), int(steps), bool(last), float(model.opt.timestep))
    loop = no_loop(mounts_of(model)) if loop is None else loop
    done, status, mount, recorded = _advance()(*_arguments(engine, stretch, given, recording, loop, noise, load))
    return Stopped(done, status, mount), recorded
