"""From a file and its tests to the identified machine."""

import time as clock
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ehamj.campaign.threads import one_thread
from ehamj.errors import InputError, SimulationFailed
from ehamj.identification.file import IdentifyFile, load_identify
from ehamj.identification.fit import Fitted, Told, fitted
from ehamj.identification.outcome import Identification
from ehamj.identification.parameters import parameters_of
from ehamj.identification.problem import Problem
from ehamj.identification.residual import Failed, Residuals
from ehamj.identification.results import identification_of
from ehamj.identification.starts import begun
from ehamj.identification.tests.test import Context
from ehamj.identification.unknowns import Unknown


def silent(words: str) -> None:
    """Say nothing."""


@one_thread()
def identify(
    source: str | Path | Mapping[str, Any] | IdentifyFile,
    *,
    overrides: Iterable[str] = (),
    measured: Mapping[str, Any] | None = None,
    progress: Told = silent,
    threads: int | None = None,
) -> Identification:
    """Find parameters of a machine from measurements.

    Args:
        source: an identification file, or its content.
        overrides: ``KEY=VALUE`` each, as ``ehamj identify FILE --set`` has them.
        measured: measurements in memory (`ehamj.measured.Measured`) by the test's name, in place of its file.
        progress: called with what is done.
        threads: that step runs; by default as many as the process has processors.

    Raises:
        InputError: if the file, a test or what was measured is not as it must be.
        SimulationFailed: if the model cannot be run where the fit begins.
    """
    began = clock.perf_counter()
    file = load_identify(source, overrides)
    if not file.test:
        raise InputError(
            "test: there is none; state what was measured, [[test]], or plan what to measure (`ehamj.plan_tests`)"
        )
    progress("reading the tests")
    parameters, tests = prepared(file, measured or {}, threads)
    problem = Problem(tests, parameters)
    starts = begun(problem, file.fit, progress)
    found = best(problem, starts.points, file, progress)
    progress("what the data tell")
    at = problem.linearised(found.point, central=True)
    found = found if isinstance(at, Failed) else replace(found, at=at)
    told = {
        "starts": len(starts.costs), "steps": found.steps, "runs": problem.runs + starts.runs,
        "seconds": round(clock.perf_counter() - began, 3), "converged": found.converged,
    }  # fmt: skip
    return identification_of(file, problem, tests, found, told)


def prepared(
    file: IdentifyFile, measured: Mapping[str, Any], threads: int | None
) -> tuple[tuple[Unknown, ...], tuple[Residuals, ...]]:
    """Parameters and tests of a file, read and ready to be compared.

    Raises:
        InputError: see `identify`.
    """
    scenario = file.machine
    parameters = parameters_of(scenario, file.parameters)
    unknown = next((name for name in measured if name not in [test.name for test in file.test]), None)
    if unknown is not None:
        raise InputError(f"measured: {unknown!r} is none of the tests {', '.join(test.name for test in file.test)}")
    context = Context(scenario, tuple(file.parameters), file.engine, threads, measured)
    return parameters, tuple(test.residuals(context) for test in file.test)


def best(problem: Problem, points: list[np.ndarray], file: IdentifyFile, progress: Told) -> Fitted:
    """The fit from the first of some starts from which there is one.

    Raises:
        SimulationFailed: if the model cannot be run at any of them.
    """
    failed = Failed("no start")
    for point in points:
        found = fitted(problem, point, file.fit.iterations, told=progress)
        if isinstance(found, Fitted):
            return found
        failed = found
    raise SimulationFailed(f"the model cannot be run where the fit begins: {failed}")
