"""From a scenario to a model that stands in its equilibrium, its controller and everything that drives it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

import mujoco
import numpy as np

from ehamj.control import AnyController, LinearController, PythonController
from ehamj.control.architectures.file import Law
from ehamj.control.channels import UPSTREAM
from ehamj.control.commands import Passive
from ehamj.control.loop import DigitalLoop, make_loop
from ehamj.control.noise import ReadingNoise
from ehamj.criteria.curves import Norm
from ehamj.errors import InputError
from ehamj.forces import Load
from ehamj.ground import Motion
from ehamj.ground.shared import Floors
from ehamj.mujoco.equilibrium import EquilibriumError, Inputs, equilibrium
from ehamj.mujoco.model import build_model
from ehamj.plant.plant import Plant
from ehamj.plant.statics import check_standing
from ehamj.run.budget import check_rows, check_steps
from ehamj.run.faults import shorter_step, unread
from ehamj.run.timestep import GIVEN, OF_FILE, OF_SCENARIO, Standing, choose_timestep, standing
from ehamj.scenario.model import Scenario
from ehamj.scenario.variation import held
from ehamj.signals import Signal
from ehamj.synthesis.search import Found
from ehamj.synthesis.settings import SynthesisSettings
from ehamj.variables import stored_of, variables_of

READ_FAST: Final = 2000.0
"""Rows per second from which rows show what noisy sensors make a machine do as fast as it is [Hz]: valves and oil let
little through above 1 kHz (levels of `recorded` differ by 0.03 dB from those at 5 kHz; at 1 kHz by up to 6 dB)."""


@dataclass(frozen=True)
class Prepared:
    """A scenario ready to step: ``steps`` steps, of which the first and each ``every``-th later one is recorded."""

    scenario: Scenario
    norms: Mapping[str, Norm]
    """That judge what is simulated, as their files are now."""
    model: mujoco.MjModel
    data: mujoco.MjData
    motion: Motion
    commands: tuple[Signal, ...]
    load: Load
    """About the centre of gravity of what the engine's body of the machine is: slides left out."""
    courses: tuple[Signal, ...]
    """Of the slides."""
    controller: AnyController | None
    loop: DigitalLoop
    noise: ReadingNoise | None
    every: int
    steps: int
    of_step: tuple[str, ...] = ()
    """What to know of the step."""
    found: Found | None = None
    """How the law was found, where it was found for the machine at hand."""
    within: Path | None = None
    """Folder for the file of rows that are too many for memory; None: the system's for what is temporary."""

    @cached_property
    def plant(self) -> Plant:
        """The machine as it begins."""
        return self.scenario.plant

    @property
    def timestep(self) -> float:
        """Step of the integrator [s]."""
        return float(self.model.opt.timestep)

    @property
    def law(self) -> LinearController | None:
        """The controller, unless there is none or it is a Python function, which no file can hold."""
        return None if isinstance(self.controller, PythonController) else self.controller

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader of the result must know."""
        read = tuple(self.controller.reads) if self.controller is not None else ()
        failing = (*unread(self.scenario.fault, read), *self.of_step)
        notes = (
            *self.motion.notes,
            *self.scenario.machine.assumptions,
            *self.scenario.where_slides_stand,
            *failing,
            *self._folded(),
            *self._exact_spools(),
            *self._unread_upstream(read),
        )
        if not isinstance(self.controller, PythonController):
            return (*notes, *held(self.scenario))
        said = "the commands came from a Python function, which is not in the scenario: it runs again without"
        return (*notes, said)

    def _unread_upstream(self, read: tuple[str, ...]) -> tuple[str, ...]:
        if self.scenario.sensors.upstream is None or any(f" {UPSTREAM} " in name for name in read):
            return ()
        return (
            "sensors.upstream is read by no law of this run: one that is told where isolation begins (isolate_from) "
            "reads it",
        )

    def _exact_spools(self) -> tuple[str, ...]:
        """That loops about spools read what no sensor shows."""
        if self.controller is None or not self.controller.converter.spools:
            return ()
        sensor = self.scenario.sensors.spool
        if sensor is not None and (sensor.noise > 0.0 or sensor.resolution > 0.0):
            return ()
        exact = "no sensors.spool is stated" if sensor is None else "its noise and resolution are 0"
        return (
            f"control.spool_feedback reads where the spools stand exactly, since {exact}; one as it is sold has noise: "
            "sensors.spool = {}",
        )

    def _folded(self) -> tuple[str, ...]:
        rate = self.scenario.record_rate
        if self.noise is None or rate >= READ_FAST:
            return ()
        return (
            f"record_rate = {rate:g} Hz: what the sensors' noise makes the machine do above {rate / 2:g} Hz is read as "
            f"if it were slow, so that a quiet machine looks louder than it is; record_rate = {READ_FAST:g} does not",
        )


def _check_standing(scenario: Scenario) -> None:
    """Raise InputError for a machine that gravity turns over, unless it may fall."""
    try:
        check_standing(scenario.plant, gravity=not scenario.may_fall)
    except ValueError as error:
        raise InputError(str(error)) from error


def _begins(motion: Motion, commands: Sequence[Signal]) -> Inputs:
    """Ground and commands at the beginning."""
    start = np.zeros(1)
    ground = motion.sample(start).below(len(commands))
    command = np.array([signal.sample(start, left=True).value[0] for signal in commands])
    return Inputs(ground.displacement[0], ground.velocity[0], command)


def _placed(
    plant: Plant, timestep: float, inputs: Inputs, stands: Standing | None
) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The model in its equilibrium as the run begins: the one that stands at rest already, where there is one."""
    if stands is None:
        model = build_model(plant, timestep)
        data = mujoco.MjData(model)
    else:
        model, data = stands.model, stands.data
        model.opt.timestep = timestep
    if stands is None or not inputs.at_rest:
        equilibrium(model, data, inputs)
    return model, data


def found_for(scenario: Scenario) -> Found | None:
    """How a scenario's law is found for the machine at hand; None of a law that is not."""
    control, nominal = scenario.control, scenario.nominal
    return control.found(nominal.plant, nominal.sensors) if isinstance(control, SynthesisSettings) else None


def prepare(
    scenario: Scenario, controller: AnyController | None, floors: Floors | None = None, within: Path | None = None
) -> Prepared:
    """A scenario ready to step, standing in its equilibrium; call it with the hydraulics installed.

    Args:
        scenario: what to simulate.
        controller: runs instead of the scenario's control.
        floors: that variants of a run share.
        within: folder for rows that are too many for memory.

    Raises:
        InputError: if the scenario cannot be run as it is.
    """
    check_rows(scenario, folder=within)
    _check_standing(scenario)
    norms = scenario.criteria.chosen()  # files with limits are refused before anything runs
    motion, commands = scenario.motion(floors), scenario.commands()
    load, courses = scenario.pushed(), tuple(slide.course() for slide in scenario.slide)
    found, keys = None, OF_FILE if isinstance(scenario.control, Law) else OF_SCENARIO
    if controller is None:
        found, controller = found_for(scenario), scenario.controller()
    else:  # instead of the scenario's control, its open-loop commands too
        commands, keys = Passive().commands(scenario.plant.mounts, scenario.duration), GIVEN
    stored_of(scenario.output.channels, variables_of(scenario, controller))
    try:
        stands = standing(scenario)
        timestep = choose_timestep(scenario, controller, keys, stands)
        check_steps(scenario, timestep)
        loop = make_loop(controller, scenario.plant, timestep, scenario.sensors, scenario.seed)
        model, data = _placed(scenario.plant, timestep, _begins(motion, commands), stands)
        usual = choose_timestep(scenario.model_copy(update={"fault": ()}), controller) if scenario.fault else timestep
    except EquilibriumError as error:
        raise InputError(f"{error} (machine.mass, actuators, supply, control)") from error
    steps = round(scenario.duration / timestep)
    every = round(1.0 / (scenario.record_rate * timestep))
    if steps < every:
        raise InputError(
            f"duration = {scenario.duration:g} s must be at least one recording period, {every * timestep:g} s"
        )
    noise = None
    if controller is not None:
        made = ReadingNoise(tuple(controller.reads), scenario.sensors, scenario.seed, loop.laws.base * timestep)
        noise = None if made.silent else made
    of_step = () if timestep == usual else (shorter_step(timestep, usual),)
    driven = (motion, commands, load, courses, controller, loop, noise)
    return Prepared(scenario, norms, model, data, *driven, every, steps, of_step, found, within)
