"""From an identification file to a plan: which test next, beside those that were made."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np

from ehamj.campaign.threads import one_thread
from ehamj.errors import InputError, SimulationFailed
from ehamj.identification.file import IdentifyFile, load_identify
from ehamj.identification.fit import Told
from ehamj.identification.identify import best, prepared, silent
from ehamj.identification.machine import with_values
from ehamj.identification.parameters import parameters_of
from ehamj.identification.planning.information import Knowledge, without
from ehamj.identification.planning.outcome import Plan
from ehamj.identification.planning.plan import Subject, planned
from ehamj.identification.planning.settings import PlanSettings
from ehamj.identification.problem import Problem
from ehamj.identification.residual import Failed
from ehamj.identification.starts import begun
from ehamj.identification.statistics import information

OTHERWISE: Final = ("control", "force", "ground", "fault")
"""Tables of a scenario that a test states itself."""


@one_thread()
def plan_tests(
    source: str | Path | Mapping[str, Any] | IdentifyFile,
    *,
    overrides: Iterable[str] = (),
    measured: Mapping[str, Any] | None = None,
    progress: Told = silent,
    threads: int | None = None,
) -> Plan:
    """Predict what tests would tell of a machine's parameters, and which to make next.

    Where the file has tests that were made, parameters are identified from them first: sensitivities are taken at what
    was found, and what these tests tell counts as known.

    Args:
        source: an identification file, or its content; its table [plan] says what tests are possible.
        overrides: ``KEY=VALUE`` each, as ``--set`` has them.
        measured: measurements in memory, see `ehamj.identify`.
        progress: called with what is done.
        threads: that step runs; by default as many as the process has processors.

    Raises:
        InputError: if the file, a test or a candidate is not as it must be.
        SimulationFailed: if the model cannot be run where the fit begins.
    """
    file = load_identify(source, overrides)
    for key in file.parameters:
        if key.split(".")[0] in OTHERWISE:
            raise InputError(
                f"parameters: {key}: a plan is for values of the machine, and tests that could be made state "
                f"{', '.join(OTHERWISE)} themselves; leave it out"
            )
    subject = _done(file, measured or {}, progress, threads) if file.test else _begun(file, threads)
    return planned(subject, file.plan or PlanSettings(), progress)


def _begun(file: IdentifyFile, threads: int | None) -> Subject:
    """What is looked for, nothing measured."""
    machine = file.machine.model_copy(update={"compare": ()})
    unknowns = parameters_of(machine, file.parameters)
    return Subject(file.title, machine, unknowns, {one.name: one.start for one in unknowns}, threads=threads)


def _done(file: IdentifyFile, measured: Mapping[str, Any], progress: Told, threads: int | None) -> Subject:
    """What is looked for, and what the tests that were made tell of it."""
    progress("reading the tests")
    parameters, tests = prepared(file, measured, threads)
    problem = Problem(tests, parameters)
    found = best(problem, begun(problem, file.fit, progress).points, file, progress)
    at = problem.linearised(found.point, central=True)
    if isinstance(at, Failed):
        raise SimulationFailed(f"the model cannot be run beside what was found: {at}")
    own = information(at, found.noise, problem.unknowns)
    number = len(parameters)
    values = {one.name: one.value(float(z)) for one, z in zip(parameters, found.point[:number], strict=True)}
    subject = Subject(file.title, with_values(file.machine, values), parameters, values, threads=threads)
    # Nuisances of made tests are known within nothing but these tests.
    known = Knowledge.before(subject.spreads).after(np.asarray(without(own, number)))
    return Subject(
        file.title, subject.machine, parameters, values, known, tuple(one.name for one in problem.tests), threads
    )
