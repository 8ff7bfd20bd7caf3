"""From a file and its tests to the identified machine."""

import time as clock
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ehamj.campaign.threads import one_thread
from ehamj.errors import InputError, SimulationFailed
from ehamj.identification.checks import Doubt, doubts, doubts_at, undriven
from ehamj.identification.choice import Choosing
from ehamj.identification.file import IdentifyFile, load_identify
from ehamj.identification.fit import Fitted, Told, fitted
from ehamj.identification.held import following, held_values
from ehamj.identification.misfit import misfits
from ehamj.identification.modal.residuals import ModalResiduals
from ehamj.identification.optional import neutral_of, places_of
from ehamj.identification.outcome import Identification
from ehamj.identification.parameters import parameters_of
from ehamj.identification.problem import Problem
from ehamj.identification.residual import Failed, Residuals
from ehamj.identification.results import identification_of
from ehamj.identification.starts import begun
from ehamj.identification.stepping import coarse, short_enough
from ehamj.identification.tests.hammer import HammerTest
from ehamj.identification.tests.record import RecordTest
from ehamj.identification.tests.responses import ResponsesTest
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
        source: an identification file, a shipped one's name, or its content.
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
            "test: there is none; state what was measured, [[test]], or ask which to make: --plan (`ehamj.plan_tests`)"
        )
    progress("reading the tests")
    read = _read(file, measured or {})
    parameters, tests = prepared(file, read, threads)
    progress("looking at the channels")
    doubted = checked(file, _doubts(file, parameters, read, threads))
    choosing = None if file.choice is None else _choosing(file, tests, parameters, progress)
    problem = Problem(tests, parameters, held=choosing.held if choosing is not None else None)
    starts = begun(problem, file.fit, progress)
    found, choice = best(problem, starts.points, file, progress), None
    if choosing is not None:
        progress("which options of the valve the data justify")
        model, choice = choosing.choose(found)
        problem, found = model.problem, model.fitted
    progress("what the data tell")
    at = problem.linearised(found.point, central=True)
    found = short_enough(problem, found if isinstance(at, Failed) else replace(found, at=at), progress)
    told = {
        "starts": len(starts.costs), "steps": found.steps, "runs": problem.runs + starts.runs,
        "seconds": round(clock.perf_counter() - began, 3), "converged": found.converged,
    }  # fmt: skip
    outcome = identification_of(file, problem, tests, found, told, progress)
    seeming = doubts_at(found.at.tests, found.at.compared, doubted)
    notes = [*undriven(file.machine, read), *(f"test {one.test!r}: {one.channel} {one.said}" for one in doubted)]
    notes += [
        f"test {one.name!r}: {note}" for one in tests if isinstance(one, ModalResiduals) for note in one.measured.notes
    ]
    notes += [f"test {one.test!r}, beside the machine that was found: {one.channel} {one.said}" for one in seeming]
    notes += [
        *outcome.notes,
        *coarse(problem, found),
        *misfits(file, read, threads, problem, found, outcome.tests, progress),
    ]
    return replace(outcome, choice=choice, notes=tuple(notes))


def _read(file: IdentifyFile, measured: Mapping[str, Any]) -> dict[str, Any]:
    """Measurements by the test's name, those of files too: a record is read once, whoever asks for it."""
    context = Context(file.machine, (), tests=tuple(test.name for test in file.test), measured=measured)
    read = (RecordTest, ResponsesTest, HammerTest)
    own = {test.name: test.read(context) for test in file.test if isinstance(test, read)}
    return {**measured, **own}


def _doubts(
    file: IdentifyFile, parameters: tuple[Unknown, ...], read: Mapping[str, Any], threads: int | None
) -> list[Doubt]:
    """What is wrong with the channels beside machines of which other values differ than those that are looked for."""
    machine, looked_for = file.machine, list(file.parameters)
    neutral = {} if file.choice is None else neutral_of(places_of(file.choice, machine, looked_for))
    held = held_values(file, machine, looked_for)
    keys = (*looked_for, *(one.name for one in held), *neutral)
    tests = zip(file.test, following(file, machine, keys, read, threads), strict=True)
    judged = [one for test, one in tests if isinstance(test, RecordTest | ResponsesTest)]
    return doubts(judged, (*parameters, *held), neutral)


def checked(file: IdentifyFile, found: list[Doubt]) -> list[Doubt]:
    """What is wrong with the channels beside the model, where the file lets it pass.

    Raises:
        InputError: naming all of them, where it does not.
    """
    if found and file.fit.doubtful == "refuse":
        order = [one.name for one in file.test]
        said = "\n".join(f"test.{order.index(one.test)} ({one.test}): {one.channel} {one.said}" for one in found)
        raise InputError(f'{said}\n(fit.doubtful = "note" fits them all the same)')
    return found


def _choosing(
    file: IdentifyFile, tests: tuple[Residuals, ...], parameters: tuple[Unknown, ...], progress: Told
) -> Choosing:
    assert file.choice is not None
    return Choosing(file.choice, file.machine, tests, parameters, file.fit.iterations, progress)


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
    options = {} if file.choice is None else places_of(file.choice, scenario, list(file.parameters))
    keys, names = (*file.parameters, *neutral_of(options)), tuple(test.name for test in file.test)
    context = Context(scenario, keys, file.engine, threads, names, measured)
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
