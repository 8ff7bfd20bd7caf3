"""Histories of many runs, those of equal structure side by side, and nothing of them that nobody asked for."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from ehamj import growing
from ehamj.arrays import Array
from ehamj.errors import InputError, SimulationFailed
from ehamj.identification.channels import taken
from ehamj.identification.residual import Failed
from ehamj.mujoco import hydraulics
from ehamj.run.budget import size_of
from ehamj.run.failures import broken_off
from ehamj.run.observe import Observing
from ehamj.run.timestep import choose_timestep
from ehamj.run.together import Item, Ran, together
from ehamj.run.workers import processors
from ehamj.scenario.model import Scenario
from ehamj.stopped import DONE

FINER: Final = 2
"""Steps in one of the automatic choice, whose errors of 1e-3 in the fastest motions are larger than what good
measurements leave open; of this one they are 16 times smaller."""

Histories = Mapping[str, Array]
"""By ehamj's name of the channel, (time,)."""


class _Observing(Observing):
    """Channels of a run, and the machine's acceleration."""

    def __getitem__(self, name: str) -> Array:
        return self._machine(2) if name == "machine_acceleration" else super().__getitem__(name)


def histories(
    scenarios: Sequence[Scenario], wanted: Sequence[str], threads: int | None = None
) -> list[Histories | Failed]:
    """Channels of each scenario's run at its record rate; of one that cannot be run, or stops, why."""

    def seen(ran: Ran) -> Histories | Failed:
        stopped = ran.driven.stopped
        if stopped.status != DONE:
            return Failed(". ".join(part for part in broken_off(ran.prepared, stopped) if part))
        if ran.driven.rows is None:
            return Failed("the record is too long for memory; a lower rate or a part of it is not")
        own = _Observing(ran.prepared, ran.driven.rows, ran.driven.struck)
        found = {name: np.array(taken(own, ran.prepared.plant, name)) for name in wanted}
        lost = next((name for name, values in found.items() if not np.isfinite(values).all()), None)
        return found if lost is None else Failed(f"{lost} is no longer finite")

    def failed(_: int, error: Exception) -> Failed:
        if isinstance(error, InputError | SimulationFailed):
            return Failed(str(error))
        raise error

    many, found = threads or processors(), list[Histories | Failed]()
    part = many * beside(scenarios)
    for begin in range(0, len(scenarios), part):
        items = [Item(number, scenario) for number, scenario in enumerate(scenarios[begin : begin + part])]
        found += together(items, seen, many, len(items), on_failure=failed, held=False)
    return found


def beside(scenarios: Sequence[Scenario]) -> int:
    """How many of these runs step side by side with all their rows in memory; one at least."""
    largest = max((size_of(scenario) for scenario in scenarios), default=0.0)
    return max(1, int(growing.IN_MEMORY / largest)) if largest else 1


def with_step(scenario: Scenario) -> Scenario:
    """A scenario with its step stated, so that all those near it have the same one: a step that follows from a value
    would make errors of integration jump with it. Machines up to twice as fast are stable at it.

    Raises:
        InputError: as `ehamj.run.timestep.choose_timestep`.
    """
    if scenario.timestep != "auto":
        return scenario
    with hydraulics():
        step = choose_timestep(scenario, scenario.controller()) / FINER
    return scenario.model_copy(update={"timestep": step})
