"""The way through a run, stretch by stretch: rows are recorded until the end, or until something fails."""

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field

from ehamj.errors import InputError
from ehamj.mujoco.advance import DONE, NOT_LOADED, Stopped, advance, compile_loop
from ehamj.mujoco.rows import Recording, Rows, Tally
from ehamj.run.inputs import sample_inputs, sample_load
from ehamj.run.prepare import Prepared

Progress = Callable[[float], None]

STRETCH = 2048
"""Steps between two returns to Python."""


@dataclass(frozen=True)
class Driven:
    """What the stepping loop left: recorded rows, the tally of limits, how it ended, seconds spent in the loop."""

    rows: Rows = field(repr=False)
    tally: Tally
    stopped: Stopped
    seconds: float


def drive(prepared: Prepared, progress: Progress | None = None) -> Driven:
    """Step to the end, or until something fails; call it with the hydraulics installed.

    Args:
        prepared: what to step; its data and its controller's memory are advanced.
        progress: called after each stretch with the fraction done.

    Raises:
        InputError: if the rows do not fit in memory.
    """
    compile_loop()
    recording = _room(prepared)
    loop, load, timestep = prepared.loop, prepared.load, prepared.timestep
    done, recorded, seconds = 0, 0, 0.0
    stopped = Stopped(0, DONE, -1)
    while stopped.status == DONE and done < prepared.steps:
        steps = min(STRETCH, prepared.steps - done)
        last = done + steps == prepared.steps
        inputs = sample_inputs(prepared.motion, prepared.commands, done, steps + last, timestep)
        noise = None if prepared.noise is None else prepared.noise.take(loop.samples(done, steps + last)[1])
        pushed = NOT_LOADED if load.absent else sample_load(load, done, steps + last, timestep)
        began = clock.perf_counter()
        stopped, count = advance(
            prepared.model, prepared.data, done, steps, inputs, recording.after(recorded), last, loop, noise, pushed
        )  # fmt: skip
        seconds += clock.perf_counter() - began
        done += stopped.steps
        recorded += count
        if progress is not None:
            progress(done / prepared.steps)
    return Driven(recording.rows.part(slice(recorded)), recording.tally, stopped._replace(steps=done), seconds)


def _room(prepared: Prepared) -> Recording:
    """Memory for the rows of the whole run."""
    count = prepared.steps // prepared.every + 1
    try:
        return Recording.of(prepared.model, prepared.loop, prepared.every, count)
    except MemoryError:
        s = prepared.scenario
        raise InputError(
            f"duration = {s.duration:g} s at record_rate = {s.record_rate:g} Hz: {count} rows do not fit in memory"
        ) from None
