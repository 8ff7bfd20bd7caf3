"""A block of lanes: simulations of equal structure as the compiled loop takes them, and what it leaves of each."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, Self, TypeVar

import mujoco
import numpy as np

from ehamj.arrays import Array
from ehamj.control.loop import DigitalLoop, structure
from ehamj.control.loop import stacked as stacked_loops
from ehamj.ground.motion import GroundSample
from ehamj.memory import isolators, supply
from ehamj.mujoco.rows import DRAWN, LIMITS, Rows, Tally
from ehamj.plant.axes import DOFS
from ehamj.smallmotion.advance import Counted, Plates, Recorded, compiled_advance
from ehamj.smallmotion.floor import Floor, Riding
from ehamj.smallmotion.isolators import AT_LIMIT, BLOCK, EXCHANGE_AT, METERING, REST, forms_of
from ehamj.smallmotion.lanes import WIDTHS, lane, lanes_of, stacked
from ehamj.smallmotion.machine import InTime, SmallMachine, small_machine
from ehamj.smallmotion.stage import Given, Lanes, Scratch, Sizes
from ehamj.stopped import DONE, Stopped

T = TypeVar("T")


class Simulation(NamedTuple):
    """One simulation that stands in its equilibrium."""

    model: mujoco.MjModel
    data: mujoco.MjData
    machine: SmallMachine
    loop: DigitalLoop

    @property
    def structure(self) -> Hashable:
        """What simulations of one block have in common."""
        model, head = self.model, isolators(self.model)[0]
        n = self.machine.mass.shape[0]
        places = tuple(int(head[name]) for name in ("supply_at", "ledger_at"))
        return n, model.na, len(self.machine.along), places, float(model.opt.timestep), structure(self.loop)


def simulation(model: mujoco.MjModel, data: mujoco.MjData, plant: Any, loop: DigitalLoop) -> Simulation:
    """A simulation of a plant whose model stands in its equilibrium in ``data``."""
    return Simulation(model, data, small_machine(model, data, plant), loop)


@dataclass(frozen=True)
class Block:
    """Simulations of equal structure side by side. Lanes beyond them repeat the last."""

    simulations: tuple[Simulation, ...]
    own: Lanes
    scratch: Scratch
    counted: Counted
    plates: Plates
    loop: DigitalLoop
    """Of all lanes, the lane last."""
    control: Array
    """What the laws command (m) [V]."""
    ended: Any
    """(width, 3) step, status and mount of where each lane ended; lanes without a simulation have."""

    @classmethod
    def of(cls, simulations: Sequence[Simulation]) -> Self:
        """The simulations as they stand.

        Raises:
            ValueError: if there are more than the largest of `ehamj.smallmotion.lanes.WIDTHS`.
        """
        width = next((width for width in WIDTHS if width >= len(simulations)), 0)
        if not width:
            raise ValueError(f"a block holds up to {WIDTHS[-1]} simulations, not {len(simulations)}")
        full = _filled(simulations, width)
        machines, models = [one.machine for one in full], [one.model for one in full]
        n, mounts, na = machines[0].mass.shape[0], len(machines[0].along), models[0].na
        head, shared = isolators(models[0])[0], supply(models[0])
        sizes = Sizes(n, na, int(head["supply_at"]), int(head["ledger_at"]), float(models[0].opt.timestep))
        blocks = np.zeros((mounts, BLOCK, width))
        blocks[:, REST] = np.stack([machine.force_at_rest for machine in machines], axis=-1)
        start = [np.concatenate([np.zeros(2 * n), one.data.act]) for one in full]
        size = (2 * n + na) * width
        ended = np.zeros((width, 3), np.int64)
        ended[len(simulations) :, 1] = -1
        first = len(DOFS)
        block = cls(
            tuple(simulations),
            Lanes(
                np.zeros(mounts, np.int64),
                blocks.ravel(),
                stacked(machine.levers for machine in machines),
                np.zeros(0) if shared is None else np.zeros(len(shared) * width),
                sizes,
            ),
            Scratch(stacked(start), np.zeros(size), np.zeros(size), np.zeros(size), Riding.of(n, mounts, width)),
            Counted(np.zeros(5 * width), np.zeros((4 * mounts + 3) * width)),
            Plates(
                stacked(machine.rest[:first] for machine in machines),
                stacked(machine.plate_at_rest for machine in machines),
            ),
            stacked_loops([one.loop for one in full]),
            np.zeros(mounts * width),
            ended,
        )
        for number in range(width):
            block._take(number)
        block._reform()
        spools = lane(block.scratch.state, (2 * n + na,), width, slice(None))[2 * n : 2 * n + 4 * mounts : 4]
        lane(block.own.blocks, (mounts, BLOCK), width, slice(None))[:, METERING] = spools
        return block

    @property
    def width(self) -> int:
        """How many lanes the compiled code advances."""
        return len(self.ended)

    def _simulation(self, number: int) -> Simulation:
        return self.simulations[min(number, len(self.simulations) - 1)]

    def renew(self, number: int) -> None:
        """Take the records of a lane's model anew, and its activations, after a fault."""
        self._take(number)
        self._reform()

    def _reform(self) -> None:
        self.own.forms[:] = forms_of([isolators(each.model) for each in self.simulations])

    def _take(self, number: int) -> None:
        one, mounts, sizes = self._simulation(number), len(self.own.forms), self.own.sizes
        table = isolators(one.model)
        values = table.view(np.float64).reshape(mounts, EXCHANGE_AT)
        lane(self.own.blocks, (mounts, BLOCK), self.width, number)[:, :EXCHANGE_AT] = values
        shared = supply(one.model)
        if shared is not None:
            lane(self.own.supply, (len(shared),), self.width, number)[:] = list(shared)
        self._state(number)[2 * sizes.coordinates :] = one.data.act

    def put_back(self, number: int) -> None:
        """Hand a lane's activations to its data: what a fault changes."""
        one = self._simulation(number)
        one.data.act[:] = self._state(number)[2 * self.own.sizes.coordinates :]

    def _state(self, number: int) -> Array:
        return lane(self.scratch.state, (self.scratch.state.size // self.width,), self.width, number)

    def loop_of(self, number: int) -> DigitalLoop:
        """The loop of one lane: its sensors and readings are views."""
        sensing, readings = self.loop.sensing, self.loop.readings

        def own(table: Any, names: Sequence[str]) -> Any:
            return table._replace(**{name: lane(getattr(table, name), (-1,), self.width, number) for name in names})

        return replace(self.loop, sensing=own(sensing, ("gains", "offsets")), readings=own(readings, ("readings",)))

    def given(
        self,
        moved: Sequence[InTime],
        ground: Sequence[GroundSample | None],
        commands: Sequence[Array | None],
        steps: int,
    ) -> Given:
        """What drives a stretch of so many steps, of each lane; lanes may share their ground and their commands.

        Args:
            moved: the machine's coefficients.
            ground: at the start of each step and the end of the last; None: at rest.
            commands: open-loop commands at start, middle and end of each step, (step, 3, mount) [V]; None: none.
            steps: how many.
        """
        full = _filled(moved, self.width)
        matrices = np.broadcast_arrays(*(np.swapaxes(one.matrix, -1, -2) for one in full))  # some slides may stand
        times = matrices[0].shape[1]
        return Given(
            stacked(matrices),
            self._inverses(full, times),
            _unless_none([one.pushed for one in full]),
            _unless_none(_filled(commands, self.width)),
            Floor.of(
                _filled(ground, self.width),
                [self._simulation(number).machine.effects for number in range(self.width)],
                steps,
                self.own.sizes.step,
            ),
            times,
            steps,
        )

    def _inverses(self, moved: Sequence[InTime], times: int) -> Array:
        """M⁻¹ of lanes with slides, and one of lanes whose effects are accelerations; nothing where no slide moves."""
        if all(one.inverse is None for one in moved):
            return np.zeros(0)
        one = np.eye(self.own.sizes.coordinates)[None, None]
        shape = (*next(each.matrix for each in moved if each.matrix.shape[1] == times).shape[:2], *one.shape[2:])
        return stacked(
            np.broadcast_to(np.swapaxes(one if each.inverse is None else each.inverse, -1, -2), shape) for each in moved
        )

    def advance(
        self, first: int, steps: int, last: bool, given: Given, recorded: Recorded, noise: Array | None
    ) -> tuple[int, int]:
        """Take steps; how many were taken, and rows recorded, by the lane that went furthest.

        ``noise`` of the readings is (sample, channel, width).
        """
        loop = self.loop
        heard = np.zeros((0, loop.sensing.channels * self.width))
        if noise is not None:
            heard = noise.reshape(-1, heard.shape[1])
        law = (loop.laws, loop.law_memory, loop.sensing, loop.readings, heard, loop.samples(first, steps)[0])
        done, rows = compiled_advance()(
            self.own, given, (first, steps, int(last)), recorded, self.counted, self.plates, (*law, self.control),
            self.scratch, self.ended, lanes_of(self.width),
        )  # fmt: skip
        return int(done), int(rows)

    def recorded(self, every: int, count: int) -> Recorded:
        """Room for so many rows.

        Raises:
            MemoryError: if there is none.
        """
        n, mounts, loop = self.own.sizes.coordinates, len(self.own.forms), self.loop
        sizes = (2 * n + self.own.sizes.activations, n, mounts, 2 * mounts, loop.states, loop.sensing.channels)
        return Recorded.of([size * self.width for size in sizes], every, count)

    def rows(self, recorded: Recorded, count: int, number: int, first: int = 0, copied: bool = True) -> Rows:
        """Rows of one lane, of which so many stand recorded; ``first`` is the number of the first of them.

        Unless they are ``copied``, most are views of what was recorded of all lanes.
        """
        n, mounts = self.own.sizes.coordinates, len(self.own.forms)

        def own(flat: Array, *shape: int) -> Array:
            size = int(np.prod(shape))
            total = flat[: count * size * self.width] if size else np.zeros(0)
            view = lane(total, (count, *shape), self.width, number)
            return np.ascontiguousarray(view) if copied else view

        states = np.ascontiguousarray(own(recorded.states, 2 * n + self.own.sizes.activations))
        accelerations = np.ascontiguousarray(own(recorded.accelerations, n))
        times = np.arange(first, first + count, dtype=np.float64) * (recorded.every * self.own.sizes.step)
        machine = self._simulation(number).machine
        moved = machine.in_model(times, states[:, :n], states[:, n : 2 * n], accelerations)
        return Rows(
            *moved,
            np.ascontiguousarray(states[:, 2 * n :]),
            own(recorded.commands, mounts),
            own(recorded.flows, mounts, 2),
            own(recorded.laws, self.loop.states),
            own(recorded.readings, self.loop.sensing.channels),
        )

    def tally(self, number: int) -> Tally:
        """What was counted of one lane."""
        mounts = len(self.own.forms)
        counts = lane(self.own.blocks, (mounts, BLOCK), self.width, number)[:, AT_LIMIT : AT_LIMIT + 4]
        total = lane(self.counted.drawn, (5,), self.width, number)[2:]
        if self.ended[number, 1] != DONE:
            kept = lane(self.counted.kept, (4 * mounts + 3,), self.width, number)
            counts, total = kept[: 4 * mounts].reshape(mounts, 4), kept[4 * mounts :]
        limits, drawn = np.zeros(mounts, LIMITS), np.zeros(1, DRAWN)
        for k, name in enumerate(LIMITS.names or ()):
            limits[name] = counts[:, k]
        drawn[0] = tuple(total)
        return Tally(limits, drawn)

    def stopped(self, number: int, done: int) -> Stopped:
        """How one lane ended, of ``done`` steps."""
        step, status, mount = self.ended[number].tolist()
        return Stopped(done, DONE, -1) if status == DONE else Stopped(step, status, mount)


def _filled(parts: Sequence[T], width: int) -> list[T]:
    """One for each lane: the last again where there is none."""
    return [*parts, *[parts[-1]] * (width - len(parts))]


def _unless_none(parts: Sequence[Array | None]) -> Array:
    """The lanes' arrays side by side, zeros for those that have none, or nothing where none has."""
    some = next((part for part in parts if part is not None), None)
    if some is not None and all(part is some for part in parts):
        return np.repeat(some, len(parts))
    return np.zeros(0) if some is None else stacked(np.zeros_like(some) if part is None else part for part in parts)
