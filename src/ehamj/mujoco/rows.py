"""What the stepping loop records: a table per quantity, and a tally of limits."""

from typing import Any, Final, NamedTuple, Self

import mujoco
import numpy as np

from ehamj.arrays import Array
from ehamj.control.loop import DigitalLoop
from ehamj.memory import mounts_of, record

LIMITS: Final = record("command", "spool", "spool_drive", "cavitation")
"""States at a limit, counted per mount."""

DRAWN: Final = record("flow", "peak_flow", "power")
"""Oil drawn by all valves together: sum over states [m³/s], largest [m³/s], sum of its power [W]."""


class Rows(NamedTuple):
    """Recorded states, one row each."""

    qpos: Array
    qvel: Array
    qacc: Array
    act: Array
    command: Array
    """Of each valve [V]."""
    flow: Array
    """(…, mount, chamber) into the chambers [m³/s]."""
    states: Array
    """Of the digital controller."""
    readings: Array
    """What its sensors last read."""

    @classmethod
    def of(cls, model: mujoco.MjModel, loop: DigitalLoop, count: int) -> Self:
        """Room for so many rows."""
        n = mounts_of(model)
        shapes: list[tuple[int, ...]] = [(size,) for size in (model.nq, model.nv, model.nv, model.na, n)]
        shapes += [(n, 2), (loop.states,), (loop.sensing.channels,)]
        return cls(*(np.empty((count, *shape)) for shape in shapes))

    def part(self, rows: slice) -> Self:
        """Some of the rows."""
        return type(self)(*(table[rows] for table in self))

    def move(self, rows: slice) -> None:
        """Let some rows take the place of the first ones."""
        for table in self:
            moved = table[rows]
            table[: len(moved)] = moved


class Tally(NamedTuple):
    """What is counted at every state."""

    limits: Any
    """`LIMITS` (mount,)."""
    drawn: Any
    """`DRAWN` (1,)."""

    @classmethod
    def of(cls, mounts: int) -> Self:
        """Nothing counted."""
        return cls(np.zeros(mounts, LIMITS), np.zeros(1, DRAWN))


class Recording(NamedTuple):
    """Where what happens goes."""

    every: int
    """Each step whose number is a multiple of this is recorded."""
    rows: Rows
    tally: Tally
    """Added to."""

    @classmethod
    def of(cls, model: mujoco.MjModel, loop: DigitalLoop, every: int, count: int) -> Self:
        """Room for so many rows, and nothing counted."""
        return cls(every, Rows.of(model, loop, count), Tally.of(mounts_of(model)))

    def after(self, rows: int) -> Self:
        """The same, from a later row on."""
        return self._replace(rows=self.rows.part(slice(rows, None)))
