"""A unit that runs: variables that are set and read by number, and a machine that is stepped."""

import re
import warnings
from collections.abc import Mapping, Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any, Final

import numpy as np

from ehamj.control import LinearController, load_controller
from ehamj.control.channels import ALONG
from ehamj.control.law import silent
from ehamj.errors import DerivedAnew, InputError
from ehamj.export.fmu.interface import (
    CONTROL,
    GROUND,
    READS_EVERY,
    TABLES,
    Variable,
    check_names,
    inputs,
    outputs,
    parameters,
    structured,
)
from ehamj.plant.axes import AXES
from ehamj.plant.mounts import UPRIGHT
from ehamj.run.instant import Instant
from ehamj.run.stepper import ON_A_STEP, Stepper
from ehamj.scenario.load import changed, load_scenario
from ehamj.scenario.model import Scenario

SCENARIO: Final = "scenario.toml"
LAW: Final = "controller.json"
GIVEN: Final = "law-is-given"
"""Mark in a unit's folder: nothing in [control] changes its law."""


class Unit:
    """A scenario, its law and what is held, in a folder of a unit's resources."""

    def __init__(self, folder: Path) -> None:
        """Read what the unit is; nothing is prepared yet.

        Raises:
            InputError: if the folder does not hold what was exported.
        """
        self.scenario = load_scenario(folder / SCENARIO)
        self.law: LinearController | None = load_controller(folder / LAW) if (folder / LAW).is_file() else None
        mounts = self.scenario.plant.mounts
        self.reads = standard_reads(self.scenario) if self.law is None else self.law.reads
        reader = silent(self.reads, mounts, 1.0) if self.law is None else self.law
        self.parameters = parameters(self.scenario, self.law is not None, (folder / GIVEN).is_file())
        self.inputs, self.outputs = inputs(mounts), outputs(self.scenario, reader)
        self.variables: Sequence[Variable] = (*self.parameters, *self.inputs, *self.outputs)
        check_names(self.variables)
        self._set = {one.name: one.start for one in self.parameters}
        self._held, self._new = np.zeros(len(self.inputs)), False
        self._start, self._stop = 0.0, 0.0
        self._machine: Stepper | None = None
        self._seen: Instant | None = None
        self._places = [(one.keys[0], (0, *one.place)) for one in self.outputs]
        self._begun = False

    def value(self, name: str) -> Any:
        """Of a parameter."""
        return self._set[name]

    def set_value(self, name: str, value: Any) -> None:
        """State a parameter, until initialisation ends.

        Raises:
            InputError: after that.
        """
        if self._begun and value != self._set[name]:
            raise InputError(f"{name} = {value!r}: parameters are set before initialisation ends; a reset begins anew")
        if value != self._set[name]:
            self._set[name], self._machine, self._seen = value, None, None

    def held(self, number: int) -> float:
        """Of an input [SI, V]."""
        return float(self._held[number])

    def hold(self, number: int, value: float) -> None:
        """State an input [SI, V]."""
        if value != self._held[number]:
            self._held[number], self._new = value, True

    def output(self, number: int) -> float:
        """Of an output at the present instant, under what is held now [SI, V, mA]."""
        if self._seen is None or self._new:
            self._hold()
            self._seen = self.machine.now
        name, place = self._places[number]
        return float(self._seen[name][place])

    def experiment(self, start: float, stop: float | None) -> None:
        """When it begins, and ends where that is known [s]."""
        self._start, self._stop = start, 0.0 if stop is None else stop

    @property
    def machine(self) -> Stepper:
        """Prepared under the parameters as they are."""
        if self._machine is None:
            self._machine, self._new, self._seen = self._prepared(), True, None
        return self._machine

    def begin(self) -> None:
        """End the initialisation.

        Raises:
            InputError: if the scenario cannot be run under the parameters.
        """
        self._begun = self.machine is not None

    def step(self, time: float, seconds: float) -> None:
        """Step on from a communication point.

        Raises:
            InputError: if it is not where the machine is, or ends within a timestep.
            SimulationFailed: if the simulation fails.
        """
        machine, since = self.machine, time - self._start
        if abs(since - machine.time) > ON_A_STEP * machine.timestep:
            raise InputError(
                f"communication point {time:.9g} s: the machine stands at {self._start + machine.time:.9g} s, and "
                "steps on from there only"
            )
        steps = seconds / machine.timestep
        if not np.isfinite(steps) or round(steps) < 1 or abs(steps - round(steps)) > ON_A_STEP:
            near = max(1, round(steps)) if np.isfinite(steps) else 1
            raise InputError(
                f"communication step {seconds:.9g} s: must be a multiple of the timestep, {machine.timestep:.9g} s, "
                f"such as {near * machine.timestep:.9g} s"
            )
        self._hold()
        self._seen = machine.step(machine.time + round(steps) * machine.timestep)

    def close(self) -> None:
        """Let go of the machine."""
        self._machine = None

    def _hold(self) -> None:
        machine = self.machine
        if self._new:
            count = len(machine.mounts)
            commands, ground, force = np.split(self._held, [count, count * (1 + len(AXES))])
            machine.hold(commands, ground.reshape(count, len(AXES)), force)
            self._new, self._seen = False, None

    def _changed(self, changes: Mapping[tuple[str, ...], Any]) -> Scenario:
        """The scenario with other values by their keys in parts; what is wrong is said of the unit's variables."""
        try:
            return changed(self.scenario, whole_lists(self.scenario.table, changes))
        except InputError as error:
            found = re.sub(rf"\b({'|'.join(TABLES)})(\.[\w-]+)+", lambda key: structured(key[0].split(".")), str(error))
            raise InputError(found) from None

    def _prepared(self) -> Stepper:
        scenario, changes = self.scenario, dict[tuple[str, ...], Any]()
        for one in self.parameters:
            value = self._set[one.name]
            written = float(f"{one.start:.16g}") if one.type == "Real" else one.start  # as the description has it
            if one.keys and value not in (one.start, written):
                changes[one.keys] = value
        if self._stop - self._start > scenario.duration:
            changes["duration",] = self._stop - self._start
        if not self._set[GROUND]:
            changes = {keys: value for keys, value in changes.items() if keys[0] != "ground"}
            changes["ground",] = {"kind": "rest"}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DerivedAnew)
            scenario = self._changed(changes) if changes else scenario
        if self.law is not None and self._set[CONTROL]:
            anew = any(keys[0] == "control" for keys in changes)
            return Stepper(scenario, None if anew else self.law)
        scenario = scenario if self._set.get(CONTROL, True) else scenario.variant("passive")
        every = self._set[READS_EVERY] if self.law is None else min(part.period for part in self.law.parts)
        return Stepper(scenario, reads=self.reads, reads_every=every)


def whole_lists(table: Mapping[str, Any], changes: Mapping[tuple[str, ...], Any]) -> dict[tuple[str, ...], Any]:
    """Values by their keys in parts, those within lists of numbers gathered into the lists, whose others stay.

    A list that follows from another value, as moments of inertia from the mass, is otherwise gone once that is placed.
    """
    found: dict[tuple[str, ...], Any] = {}
    for keys, value in changes.items():
        first = len(keys)
        while first > 1 and keys[first - 1].isdigit() and isinstance(_at(table, keys[: first - 1]), list):
            first -= 1
        if first == len(keys):
            found[keys] = value
            continue
        entries = found.setdefault(keys[:first], deepcopy(_at(table, keys[:first])))
        _at(entries, keys[first:-1])[int(keys[-1])] = value
    return found


def _at(table: Any, keys: Sequence[str]) -> Any:
    """What stands under a key in parts; nothing where it leads nowhere."""
    for part in keys:
        table = table[int(part)] if isinstance(table, list) else table.get(part, {})
    return table


def standard_reads(scenario: Scenario) -> tuple[str, ...]:
    """What is read where no law says it: velocities of ground and foot along each mount, stroke, load pressure."""
    plant, found = scenario.plant, []
    for name, direction in zip(plant.mounts, plant.directions, strict=True):
        axis = "z" if direction[2] > 1.0 - UPRIGHT else ALONG
        found += [f"ground_velocity {name} {axis}", f"foot_velocity {name} {axis}"]
        found += [f"stroke {name}", f"load_pressure {name}"]
    return tuple(channel for channel in found if _measured(channel, scenario))


def _measured(channel: str, scenario: Scenario) -> bool:
    """Whether an instrument of the scenario's gives a channel."""
    try:
        scenario.sensors.rows([channel], scenario.plant, scenario.seed)
    except InputError:
        return False
    return True
