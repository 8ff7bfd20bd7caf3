"""What the sensors of a run read, tick by tick, and what its laws commanded: from the stepping loop itself."""

from dataclasses import replace
from typing import Any, Final, NamedTuple

import numpy as np

from ehamj.arrays import Array
from ehamj.control import AnyController
from ehamj.export.c.ticks import Clock
from ehamj.scenario.model import Scenario

LENGTH: Final = 1.0
"""How long they go on once the commands have faded in [s]."""
MOST: Final = 20_000
"""Ticks at most."""


class Vectors(NamedTuple):
    """Readings and commands of a run's first ticks."""

    readings: Array
    """(tick, reading), SI."""
    volts: Array
    """What all laws together command, before range and rounding, (tick, valve) [V]."""
    commands: Array
    """What the valves got of it [V]."""
    failed: bool
    """The run ended early."""


def ticks_for(scenario: Scenario, controller: AnyController, clock: Clock) -> int:
    """How many ticks of a run are kept."""
    own = controller.converter
    seconds = min(own.switch_on + own.fade + LENGTH, scenario.duration)
    return max(min(round(seconds / clock.period), MOST), 1)


def vectors(scenario: Scenario, controller: AnyController, clock: Clock, ticks: int) -> Vectors:
    """The first ticks of a nonlinear run of a scenario.

    Raises:
        InputError: if it cannot be run.
    """
    from ehamj.mujoco.hold import hydraulics
    from ehamj.run.drive import drive
    from ehamj.run.prepare import prepare
    from ehamj.stopped import DONE

    with hydraulics():
        prepared = prepare(scenario.model_copy(update={"engine": "mujoco"}), controller)
        loop = prepared.loop
        assert (int(loop.laws.base), prepared.timestep) == (clock.steps, clock.timestep), "the run has another clock"
        short = prepared.scenario.model_copy(update={"duration": ticks * clock.period, "record_rate": 1.0})
        run = replace(
            prepared,
            scenario=short,
            # All that the laws remember is recorded, what each holds among it.
            loop=replace(loop, states=loop.law_memory.values.size),
            every=clock.steps,
            steps=max(ticks + clock.behind - 1, 1) * clock.steps,  # and a row at its end
        )
        driven = drive(run)
    rows = driven.rows
    assert rows is not None
    count = max(len(rows.readings) - clock.behind, 0)
    later = slice(clock.behind, clock.behind + count)
    volts: Any = np.zeros((count, rows.command.shape[1]))
    for law in loop.laws.table:
        held = int(law["held"])
        volts += rows.states[later, held : held + volts.shape[1]]
    kept = slice(min(count, ticks))
    return Vectors(rows.readings[:count][kept], volts[kept], rows.command[later][kept], driven.stopped.status != DONE)
