"""The way through a run, stretch by stretch: rows are recorded until the end, or until something fails."""

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ehamj import columns
from ehamj.arrays import Array
from ehamj.control.loop import DigitalLoop
from ehamj.errors import InputError
from ehamj.faults import in_order
from ehamj.forces import Load
from ehamj.ground import Motion
from ehamj.interruption import check
from ehamj.memory import COMMAND, inputs
from ehamj.mujoco.advance import NOT_LOADED, STANDING, advance, compile_loop
from ehamj.mujoco.rows import Recording, Rows, Tally
from ehamj.mujoco.slides import drives
from ehamj.run.budget import streams
from ehamj.run.faults import Struck, step_of, strike
from ehamj.run.prepare import Prepared
from ehamj.run.stream import Stream, ready, room, rows_of
from ehamj.signals import Signal, Zero
from ehamj.stopped import DONE, Stopped

Progress = Callable[[float], None]

STRETCH = 2048
"""Steps between two returns to Python."""


@dataclass(frozen=True)
class Driven:
    """What the stepping loop left: recorded rows, the tally of limits, how it ended, seconds spent in the loop."""

    rows: Rows | None = field(repr=False)
    """None where they are in ``stream``."""
    tally: Tally
    stopped: Stopped
    seconds: float
    struck: tuple[Struck, ...] = ()
    """Faults that struck, in order."""
    stream: Stream | None = None
    """Where rows are that are too many for memory."""
    lost: Exception | None = None
    """Why it went no further, where what drives the machine could not be read or held."""


def drive(prepared: Prepared, progress: Progress | None = None) -> Driven:
    """Step to the end, or until something fails; call it with the hydraulics installed.

    Args:
        prepared: what to step; its data and its controller's memory are advanced.
        progress: called after each stretch with the fraction done.

    Raises:
        InputError: if the rows do not fit in memory.
    """
    compile_loop()
    loop = prepared.loop
    count = rows_of(prepared)
    stream = Stream(prepared) if streams(prepared.scenario) else None
    places = count if stream is None else min(count, room(STRETCH))
    try:
        recording = Recording.of(prepared.model, loop, prepared.every, places)
    except MemoryError:
        raise no_room(prepared, count) from None
    done, recorded, seconds = 0, 0, 0.0
    stopped, struck, lost = Stopped(0, DONE, -1), Faults(prepared), None
    while stopped.status == DONE and done < prepared.steps and not (stream and stream.lost):
        check()
        struck.strike(done)
        steps = min(STRETCH, prepared.steps - done, struck.steps_left(done))
        last = done + steps == prepared.steps
        try:
            driven, pushed = driving(prepared, done, steps + last)
        except (MemoryError, OSError) as error:
            if not recorded:
                raise
            lost = error
            break
        noise = None if prepared.noise is None else prepared.noise.take(loop.samples(done, steps + last)[1])
        began = clock.perf_counter()
        stopped, rows_done = advance(
            prepared.model, prepared.data, done, steps, driven, recording.after(recorded), last, loop, noise, pushed
        )  # fmt: skip
        seconds += clock.perf_counter() - began
        done += stopped.steps
        recorded += rows_done
        while stream is not None and ready(recorded):
            stream.add(recording.rows.part(slice(columns.ROWS)), struck.found)
            recording.rows.move(slice(columns.ROWS, recorded))
            recorded -= columns.ROWS
        if progress is not None:
            progress(done / prepared.steps)
    rows, ended = recording.rows.part(slice(recorded)), stopped._replace(steps=done)
    if stream is None:
        return Driven(rows, recording.tally, ended, seconds, struck.found, lost=lost)
    stream.add(rows, struck.found)
    return Driven(None, recording.tally, ended, seconds, struck.found, stream, lost)


def no_room(prepared: Prepared, count: int) -> InputError:
    """What to say of so many rows that do not fit in memory."""
    s = prepared.scenario
    return InputError(
        f"duration = {s.duration:g} s at record_rate = {s.record_rate:g} Hz: {count} rows do not fit in memory"
    )


class Faults:
    """Faults of a run as it goes on: what is due strikes before the next stretch, which ends before the others."""

    def __init__(self, prepared: Prepared, loop: DigitalLoop | None = None) -> None:
        self._prepared, self._plant, self._loop = prepared, prepared.scenario.plant, loop or prepared.loop
        self._due = [(step_of(fault, prepared.timestep), fault) for fault in in_order(prepared.scenario.fault)]
        self.found: tuple[Struck, ...] = ()

    def due(self, done: int) -> bool:
        """Whether one strikes after so many steps."""
        return bool(self._due) and self._due[0][0] <= done

    def strike(self, done: int) -> None:
        """Let strike what is due after so many steps."""
        own = self._prepared
        while self.due(done):
            _, fault = self._due.pop(0)
            channels = own.controller.reads if own.controller is not None else ()
            one = strike(own.model, own.data, self._loop, channels, self._plant, fault, done * own.timestep)
            self._plant, self.found = one.plant, (*self.found, one)

    def steps_left(self, done: int) -> int:
        """Steps until the next."""
        return self._due[0][0] - done if self._due else self._prepared.steps


class Driving(NamedTuple):
    """What drives a machine in some steps, as `ehamj.mujoco.advance.advance` takes it."""

    inputs: tuple[Array, Array]
    load: tuple[Array, Array, Array]


def driving(prepared: Prepared, first: int, steps: int) -> Driving:
    """What drives a machine in so many steps from step number ``first``: ground, open-loop commands, forces, slides."""
    load, timestep, plant = prepared.load, prepared.timestep, prepared.scenario.plant
    driven = sample_inputs(prepared.motion, prepared.commands, first, steps, timestep)
    pushed = NOT_LOADED if load.absent else sample_load(load, first, steps, timestep)
    if plant.slides:
        pushed = (*pushed[:2], drives(plant, prepared.courses, first, steps, timestep))
    return Driving(driven, pushed)


def sample_inputs(
    motion: Motion, commands: tuple[Signal, ...], first: int, steps: int, timestep: float
) -> tuple[Array, Array]:
    """Inputs of some steps at start and end: value, slope·timestep, second derivative, (steps, mount, input, 3) each.

    The inputs of a mount are the ground's x, y, z [m], then its command [V] (`ehamj.memory.INPUTS`); the ground
    upstream is one mount more where a sensor stands there.
    """
    times = np.arange(first, first + steps + 1, dtype=np.float64) * timestep
    sampled = None if motion.at_rest else motion.sample(times)
    points = inputs(steps + 1, len(commands) if sampled is None else sampled.displacement.shape[1])
    for order, part in enumerate(sampled or ()):
        points[:, :, :COMMAND, order] = part
    starts = points[:-1].copy()
    ends = points[1:]
    for mount, signal in enumerate(commands):
        if isinstance(signal, Zero):
            continue
        starts[:, mount, COMMAND, :2], ends[:, mount, COMMAND, :2] = sample_command(signal, times)
    starts[..., 1] *= timestep
    ends[..., 1] *= timestep
    return starts, ends


def sample_command(signal: Signal, times: Array) -> tuple[Array, Array]:
    """Value and slope of a command where steps start and where they end, as it comes there, (step, 2) each."""
    now, then = signal.sample(times[:-1]), signal.sample(times[1:], left=True)
    return np.column_stack(now[:2]), np.column_stack(then[:2])


def sample_load(load: Load, first: int, steps: int, timestep: float) -> tuple[Array, Array, Array]:
    """Force on the machine in some steps: value and slope·timestep at start and end, (steps, 6, 2) each; no slides."""
    times = np.arange(first, first + steps + 1, dtype=np.float64) * timestep
    scale = np.array([1.0, timestep])
    starts, ends = load.sample(times[:-1]), load.sample(times[1:], left=True)
    return np.stack(starts, axis=2) * scale, np.stack(ends, axis=2) * scale, STANDING
