"""Run one scenario, or many: prepare → drive → observe → summarise."""

import time as clock
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from ehamj.control import as_controller
from ehamj.control.architectures.file import Law
from ehamj.errors import InputError
from ehamj.mujoco import hydraulics
from ehamj.mujoco.model import drawn_xml
from ehamj.result import CONTROLLER_FILE, Result
from ehamj.run.drive import Progress, drive
from ehamj.run.failures import Incomplete, failure
from ehamj.run.observe import observe
from ehamj.run.prepare import prepare
from ehamj.run.summarise import summarise
from ehamj.scenario.model import Scenario


def simulate(scenario: Scenario, progress: Progress | None = None, controller: Any = None) -> Result:
    """Run a scenario.

    Args:
        scenario: what to simulate.
        progress: called now and then with the fraction done.
        controller: runs instead of the scenario's control: a `ehamj.Controller`, a bank of them, a
            `ehamj.PythonController`, or a python-control system with ``dt`` and channels as input labels.

    Raises:
        InputError: if the scenario cannot be run as it is.
        Incomplete: if the simulation fails; its ``result`` holds what was computed until then.
    """
    started = clock.perf_counter()
    with hydraulics():
        prepared = prepare(scenario, None if controller is None else as_controller(controller))
        driven = drive(prepared, progress)
    dataset = observe(prepared, driven.rows, driven.struck)
    failed = failure(prepared, driven.stopped, dataset)
    dataset.attrs["complete"] = int(failed is None)
    summary = summarise(prepared, driven, dataset, clock.perf_counter() - started, failed)
    law = prepared.law
    if law is not None and (controller is not None or isinstance(scenario.control, Law)):
        scenario = scenario.model_copy(update={"control": Law(kind="law", file=CONTROLLER_FILE)})
    result = Result(scenario, dataset, summary, drawn_xml(scenario.plant, prepared.timestep), law)
    if failed is not None:
        raise Incomplete(failed, result) from next(iter(prepared.loop.failures), None)
    return result


def simulate_many(
    scenarios: Iterable[Scenario], threads: int | None = None, controllers: Sequence[Any] | None = None
) -> list[Result]:
    """Run scenarios on threads inside this process; results come in order.

    Args:
        scenarios: what to simulate.
        threads: how many at once; by default as many as the machine has.
        controllers: one for each scenario, see `simulate`; None leaves a scenario its own control.

    Raises:
        InputError: if there are not as many controllers as scenarios.
        As `simulate`, for the first scenario that fails.
    """
    cases = list(scenarios)
    laws = [None] * len(cases) if controllers is None else list(controllers)
    if len(laws) != len(cases):
        raise InputError(f"controllers: are {len(laws)}, they must be one for each of the {len(cases)} scenarios")
    with hydraulics(), ThreadPoolExecutor(max_workers=threads) as pool:
        return list(pool.map(lambda case, law: simulate(case, controller=law), cases, laws))
