"""Work that is timed: in turn with others, and steps of a scenario over and over."""

import time
from collections.abc import Callable, Mapping, Sequence

import mujoco
import numpy as np

from ehamj.arrays import Array
from ehamj.control import AnyController
from ehamj.control.loop import DigitalLoop, no_loop
from ehamj.mujoco import hydraulics
from ehamj.mujoco.advance import NOT_LOADED, advance
from ehamj.mujoco.equilibrium import Inputs, equilibrium
from ehamj.mujoco.model import build_model
from ehamj.mujoco.rows import Recording
from ehamj.run.drive import drive, sample_inputs
from ehamj.run.prepare import prepare
from ehamj.run.side_by_side import LANES, drive_block, small
from ehamj.scenario.model import Scenario


def interleaved(works: Mapping[str, Callable[[], object]], repetitions: int) -> dict[str, Array]:
    """Wall times of each work [s], (repetition,), taken in turn; a first round, which warms up, is left out.

    A work that returns a float has timed itself: that is its time [s].
    """
    times = np.empty((repetitions + 1, len(works)))
    for repetition in times:
        for k, work in enumerate(works.values()):
            began = time.perf_counter()
            found = work()
            repetition[k] = found if isinstance(found, float) else time.perf_counter() - began
    return dict(zip(works, times[1:].T, strict=True))


def medians(works: Mapping[str, Callable[[], object]], repetitions: int) -> dict[str, float]:
    """Median of each work's `interleaved` times [s]."""
    return {name: float(np.median(each)) for name, each in interleaved(works, repetitions).items()}


class Run:
    """Steps [s] of a scenario from its equilibrium, recorded each so many; each call takes them anew."""

    def __init__(self, scenario: Scenario, step: float, steps: int, every: int = 10) -> None:
        self.model, self.steps, self.every = build_model(scenario.plant, step), steps, every
        self.start = mujoco.MjData(self.model)
        self.inputs = sample_inputs(scenario.motion(), scenario.commands(), 0, steps + 1, step)
        self.alone = no_loop(len(scenario.plant.mounts))
        with hydraulics():
            equilibrium(self.model, self.start, Inputs.rest(self.model))

    def __call__(self, loop: DigitalLoop | None = None, load: tuple[Array, Array, Array] = NOT_LOADED) -> None:
        """Take the steps, with a controller or under a force."""
        data, loop = mujoco.MjData(self.model), loop or self.alone
        data.qpos[:], data.act[:] = self.start.qpos, self.start.act
        noise = np.zeros((loop.samples(0, self.steps + 1)[1], loop.sensing.channels))
        recording = Recording.of(self.model, loop, self.every, self.steps // self.every + 1)
        with hydraulics():
            advance(self.model, data, 0, self.steps, self.inputs, recording, True, loop, noise, load)


class Stepping:
    """A scenario from its start to its end, as `ehamj.simulate` steps it; a call gives the seconds in the loop [s]."""

    def __init__(self, scenario: Scenario, law: AnyController | None = None) -> None:
        self.scenario = scenario
        self.controller = law or scenario.controller()  # once: to derive it takes as long as many steps

    def __call__(self) -> float:
        """Step it."""
        with hydraulics():
            return drive(prepare(self.scenario, self.controller)).seconds


class SideBySide:
    """Scenarios of one structure on the small-motion engine, from start to end, in as many blocks as they need.

    A call gives the seconds in the loop [s], which what samples their inputs is not part of.
    """

    def __init__(self, scenarios: Sequence[Scenario], law: AnyController | None = None) -> None:
        law = law or scenarios[0].controller()
        with hydraulics():
            self._runs = [prepare(scenario, law) for scenario in scenarios]
            self._small = [small(run) for run in self._runs]

    def __call__(self) -> float:
        """Step them all."""
        seconds = 0.0
        for first in range(0, len(self._runs), LANES):
            block = slice(first, first + LANES)
            seconds += sum(driven.seconds for driven in drive_block(self._runs[block], self._small[block]))
        return seconds
