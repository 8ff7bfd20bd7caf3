"""The way through runs of equal structure on the small-motion engine: as `ehamj.run.drive`, a lane for each."""

import time as clock
from collections.abc import Hashable, Iterator, Sequence
from typing import Final

import numpy as np

from ehamj import columns
from ehamj.arrays import Array
from ehamj.compiled.kept import uncollected
from ehamj.control.noise import Heard, ReadingNoise
from ehamj.ground import GroundSample
from ehamj.interruption import check
from ehamj.run.budget import check_disk, size_of, streams
from ehamj.run.drive import Driven, Faults, Progress, no_room, sample_command, sample_load
from ehamj.run.prepare import Prepared
from ehamj.run.stream import Stream, ready, room, rows_of
from ehamj.signals import Zero
from ehamj.smallmotion.advance import Recorded
from ehamj.smallmotion.block import Block, Simulation, simulation
from ehamj.smallmotion.cubics import staged
from ehamj.smallmotion.lanes import WIDTHS
from ehamj.smallmotion.machine import InTime
from ehamj.smallmotion.stage import Given
from ehamj.stopped import DONE, Stopped

LANES: Final = WIDTHS[-1]
"""Runs that step together at most."""

STRETCH: Final = 2048
"""Steps for which inputs are sampled at once. It is the same for one lane and for many, and whatever strikes between:
products of whole arrays round by their shapes, and a run is to be the same to the bit in any company."""


def small(prepared: Prepared) -> Simulation:
    """A scenario's machine for the small-motion engine."""
    return simulation(prepared.model, prepared.data, prepared.scenario.plant, prepared.loop)


def shape(prepared: Prepared, own: Simulation) -> Hashable:
    """What runs of one block have in common."""
    return own.structure, prepared.steps, prepared.every


def drive_block(
    runs: Sequence[Prepared],
    simulations: Sequence[Simulation],
    progress: Progress | None = None,
    copied: bool = True, heard: Heard | None = None,
) -> Iterator[Driven]:  # fmt: skip
    """Step all to the end, or until each fails; what the loop left of one after the other.

    Args:
        runs: of one `shape`, at most as many as `ehamj.smallmotion.lanes.WIDTHS` has.
        simulations: of each its `small` one.
        progress: called after each stretch with the fraction done.
        copied: whether the rows of each stand by themselves; else they hold those of all for as long as they are held.
        heard: noise that runs before these have heard, and later ones will.

    Raises:
        InputError: if the rows do not fit in memory, or, of runs that are too long for that together, on disk.
    """
    block, first, alike, count = Block.of(simulations), runs[0], _alike(runs), rows_of(runs[0])
    streaming = _streams(runs)
    recorded = _recorded(block, first, min(count, room(STRETCH)) if streaming else count)
    struck = [Faults(run, block.loop_of(number)) for number, run in enumerate(runs)]
    done, begin, rows, seconds, sampled, given, lost = 0, 0, 0, 0.0, range(0), None, None
    while done < first.steps and _goes_on(block, streaming, len(runs), done):
        check()
        if given is None or done not in sampled:
            sampled = range(done, min(done + STRETCH, first.steps))
            given, lost = _given_or_lost(block, runs, alike, done, len(sampled) + (sampled.stop == first.steps))
            if given is None:
                break
        _strike(block, struck, done)
        running = [faults for k, faults in enumerate(struck) if block.stopped(k, done).status == DONE]
        steps = min(sampled.stop - done, *(faults.steps_left(done) for faults in running))
        last = done + steps == first.steps
        noise = _heard(runs, block.width, done, steps + last, heard)
        part = given.part(done - sampled.start, steps + last)
        if done == 0:  # so that no simulation's timing contains what compiling takes
            with uncollected():
                block.advance(0, 0, False, given.part(0, 0), recorded, None)
        began = clock.perf_counter()
        taken, written = block.advance(done, steps, last, part, recorded.after(rows), noise)
        seconds += clock.perf_counter() - began
        done, rows = done + taken, rows + written
        while streaming and ready(rows):
            for number, stream in enumerate(streaming):
                own = min(_rows_of(block.stopped(number, done), first.every, begin + rows) - begin, columns.ROWS)
                if own > 0:
                    stream.add(block.rows(recorded, own, number, begin), struck[number].found)
            recorded.move(columns.ROWS, rows)
            begin, rows = begin + columns.ROWS, rows - columns.ROWS
        if progress is not None:
            progress(done / first.steps)
    for number, faults in enumerate(struck):
        stopped = block.stopped(number, done)
        own = max(_rows_of(stopped, first.every, begin + rows) - begin, 0)
        table = block.rows(recorded, own, number, begin, copied)
        told = (block.tally(number), stopped, seconds / len(runs))
        if streaming:
            streaming[number].add(table, faults.found)
        yield Driven(None if streaming else table, *told, faults.found, streaming[number] if streaming else None, lost)


def _recorded(block: Block, first: Prepared, rows: int) -> Recorded:
    """Room for so many rows of all."""
    try:
        return block.recorded(first.every, rows)
    except MemoryError:
        raise no_room(first, rows_of(first)) from None


def _goes_on(block: Block, streaming: Sequence[Stream], runs: int, done: int) -> bool:
    """Whether any run is not at its end, and has rows that are kept."""
    if streaming and all(stream.lost for stream in streaming):
        return False
    return any(block.stopped(number, done).status == DONE for number in range(runs))


def _strike(block: Block, struck: Sequence[Faults], done: int) -> None:
    """Let the faults strike that are due in each lane that still runs."""
    for number, faults in enumerate(struck):
        if faults.due(done) and block.stopped(number, done).status == DONE:
            block.put_back(number)
            faults.strike(done)
            block.renew(number)


def _streams(runs: Sequence[Prepared]) -> list[Stream]:
    """Files for the rows of runs that are too many for memory together, though each by itself may not be."""
    if not streams(*(run.scenario for run in runs)):
        return []
    check_disk(max((run.scenario for run in runs), key=size_of), len(runs), runs[0].within)
    return [Stream(run) for run in runs]


def _rows_of(stopped: Stopped, every: int, rows: int) -> int:
    """How many of so many rows a lane has."""
    return rows if stopped.status == DONE else stopped.steps // every + (stopped.steps % every > 0)


def _given(block: Block, runs: Sequence[Prepared], alike: Sequence[int], first: int, steps: int) -> Given:
    """What drives some steps of all runs; those of one floor and equal commands sample them once."""
    ground: list[GroundSample | None] = []
    commands: list[Array | None] = []
    moved: list[InTime] = []
    times = np.arange(first, first + steps + 1, dtype=np.float64) * runs[0].timestep
    for run, own, same in zip(runs, block.simulations, alike, strict=True):
        known = same < len(ground)
        ground.append(ground[same] if known else None if run.motion.at_rest else run.motion.sample(times))
        commands.append(commands[same] if known else _commands(run, times))
        load = None if run.load.absent else sample_load(run.load, first, steps, run.timestep)
        moved.append(own.machine.in_time(first, steps, run.timestep, load))
    return block.given(moved, ground, commands, steps)


def _given_or_lost(
    block: Block, runs: Sequence[Prepared], alike: Sequence[int], first: int, steps: int
) -> tuple[Given | None, Exception | None]:
    """`_given`, or why there is none, where some steps were taken before."""
    try:
        return _given(block, runs, alike, first, steps), None
    except (MemoryError, OSError) as error:
        if not first:
            raise
        return None, error


def _commands(run: Prepared, times: Array) -> Array | None:
    """Open-loop commands at start, middle and end of steps between times [s], (step, 3, mount) [V]; None: none."""
    if all(isinstance(command, Zero) for command in run.commands):
        return None
    both = zip(*(sample_command(command, times) for command in run.commands), strict=True)
    start, end = (np.stack(part, axis=1) * [1.0, run.timestep] for part in both)
    return staged(start, end)[0]


def _alike(runs: Sequence[Prepared]) -> list[int]:
    """For each run the first with the same inputs: ground, below the mounts and upstream, seed, open-loop commands."""
    keys: list[tuple[object, ...]] = []
    for run in runs:
        s = run.scenario
        open_loop = s.control if run.controller is None else None
        upstream = None if s.sensors.upstream is None else s.sensors.upstream.position
        keys.append((s.ground, s.seed, s.duration, s.mount, upstream, open_loop))
    return [keys.index(key) for key in keys]


def _heard(runs: Sequence[Prepared], width: int, first: int, steps: int, heard: Heard | None) -> Array | None:
    """Noise of the runs' readings at the samples among some steps, (sample, channel, width); None where all are
    silent. Those of one seed and equal sensors draw it once, and not at all where it was ``heard`` before."""
    noises = [run.noise for run in runs]
    if all(noise is None for noise in noises):
        return None
    loop = runs[0].loop
    begin, count = loop.samples(first, steps)
    known: list[tuple[ReadingNoise, Array]] = []
    drawn: list[Array | None] = []
    for noise in noises:
        same = None
        if noise is not None:
            same = next((own for one, own in known if one.alike(noise)), None)
            if same is None:
                same = noise.take(count) if heard is None else heard.take(noise, begin, count)
                known.append((noise, same))
        drawn.append(same)
    if all(one is known[0][1] for one in drawn):
        return np.repeat(known[0][1][:, :, None], width, axis=2)
    found = np.zeros((count, loop.sensing.channels, width))
    for lane, one in enumerate(drawn):
        if one is not None:
            found[:, :, lane] = one
    return found
