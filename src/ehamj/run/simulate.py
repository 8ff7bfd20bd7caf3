"""Run one scenario, or many: prepare → drive → observe → summarise."""

import threading
import time as clock
from collections.abc import Callable, Iterable, Iterator, Sequence, Sized
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeVar, overload

import xarray as xr

from ehamj.control import as_controller
from ehamj.control.architectures.file import Law
from ehamj.errors import InputError
from ehamj.mujoco import hydraulics
from ehamj.mujoco.model import drawn_xml
from ehamj.result import CONTROLLER_FILE, Result
from ehamj.run.drive import Driven, Progress, drive
from ehamj.run.failures import Incomplete, failure
from ehamj.run.observe import observe
from ehamj.run.prepare import Prepared, prepare
from ehamj.run.side_by_side import drive_block, small
from ehamj.run.summarise import summarise
from ehamj.run.workers import processors, worked_through
from ehamj.scenario.load import Given, as_scenario
from ehamj.scenario.model import Scenario
from ehamj.scenario.variation import derived_anew, unlike, warn_derived

T = TypeVar("T")


def simulate(scenario: Given, progress: Progress | None = None, controller: Any = None) -> Result:
    """Run a scenario.

    Args:
        scenario: what to simulate: a scenario, a shipped name, a file, or a table (`ehamj.parse_scenario`).
        progress: called now and then with the fraction done.
        controller: runs instead of the scenario's control: a `ehamj.Controller`, a bank of them, a
            `ehamj.PythonController`, the file of a law, or a python-control system with ``dt`` and channels as input
            labels.

    Raises:
        InputError: if the scenario cannot be run as it is.
        Incomplete: if the simulation fails; its ``result`` holds what was computed until then.
    """
    began = clock.perf_counter()
    run = _observed(as_scenario(scenario), progress, controller)
    return _judged(run, began, controller)


class Observed(NamedTuple):
    """A run that nobody has judged: its channels, and what they came from."""

    prepared: Prepared
    driven: Driven
    dataset: xr.Dataset
    failed: str | None
    """What went wrong, in words; None where nothing did."""

    @property
    def scenario(self) -> Scenario:
        """What was simulated."""
        return self.prepared.scenario


def observed(scenario: Scenario, controller: Any = None) -> Observed:
    """As `simulate`, without a summary, which takes longer than most short runs."""
    began = clock.perf_counter()
    run = _observed(scenario, None, controller)
    if run.failed is not None:
        _judged(run, began, controller)  # raises
    return run


def _observed(scenario: Scenario, progress: Progress | None, controller: Any) -> Observed:
    with hydraulics():
        prepared = prepare(scenario, None if controller is None else as_controller(controller))
        driven = driven_by_engine(prepared, progress)
    dataset = observe(prepared, driven.rows, driven.struck)
    failed = failure(prepared, driven.stopped, dataset)
    dataset.attrs["complete"] = int(failed is None)
    return Observed(prepared, driven, dataset, failed)


def driven_by_engine(prepared: Prepared, progress: Progress | None = None) -> Driven:
    """What the stepping loop of a scenario's engine left."""
    if prepared.scenario.engine == "mujoco":
        return drive(prepared, progress)
    return next(drive_block([prepared], [small(prepared)], progress))


def _judged(run: Observed, began: float, controller: Any) -> Result:
    """The result of a run that began at a time of the clock [s]; raises `Incomplete` of one that failed."""
    prepared, scenario, law = run.prepared, run.scenario, run.prepared.law
    summary = summarise(prepared, run.driven, run.dataset, clock.perf_counter() - began, run.failed)
    if law is not None and (controller is not None or isinstance(scenario.control, Law)):
        scenario = scenario.model_copy(update={"control": Law(kind="law", file=CONTROLLER_FILE)})
    result = Result(scenario, run.dataset, summary, drawn_xml(scenario.plant, prepared.timestep), law)
    if run.failed is not None:
        raise Incomplete(run.failed, result) from next(iter(prepared.loop.failures), None)
    return result


@overload
def simulate_many(
    scenarios: Iterable[Given], threads: int | None = None, controllers: Sequence[Any] | None = None
) -> list[Result]: ...


@overload
def simulate_many(
    scenarios: Iterable[Given],
    threads: int | None = None,
    controllers: Sequence[Any] | None = None,
    *,
    reduce: Callable[[Result], T],
) -> list[T]: ...


def simulate_many(
    scenarios: Iterable[Given],
    threads: int | None = None,
    controllers: Sequence[Any] | None = None,
    *,
    reduce: Callable[[Result], Any] | None = None,
) -> list[Any]:
    """Run scenarios on threads inside this process; results come in order.

    Args:
        scenarios: what to simulate, each as `simulate` takes it. They are asked for one by one as threads get free, so
            that a generator need not hold them all.
        threads: how many at once; by default as many as the process has processors.
        controllers: one for each scenario, see `simulate`; None leaves a scenario its own control.
        reduce: makes of each result, on its thread, what is wanted of it. The result is then forgotten, so that memory
            is that of ``threads`` runs, however many there are.

    Warns:
        DerivedAnew: if scenarios of one control differ in their machines, and the law was derived for each: it knows
            every one exactly, and what comes out is no scatter within tolerances. `Scenario.varied` holds the law.

    Raises:
        InputError: if there are not as many controllers as scenarios, or ``threads`` is less than one.
        As `simulate` or ``reduce``, for the first scenario that fails, which the message names; no further one begins.
    """
    if threads is not None and threads < 1:
        raise InputError(f"threads = {threads}: must be at least 1")
    laws = None if controllers is None else list(controllers)
    if isinstance(scenarios, str):
        raise InputError(f"scenarios = {scenarios!r}: must be several, such as a list; `simulate` runs one")
    if laws is not None and isinstance(scenarios, Sized):
        _check_count(laws, len(scenarios))
    watch = _Watch()

    def one(number: int, given: Given) -> Any:
        with _naming(f"scenario {number}"):
            scenario = as_scenario(given)
        with _naming(f"scenario {number} ({scenario.name})"):
            if laws is not None:
                _check_count(laws, max(number + 1, len(laws)))
            law = None if laws is None else laws[number]
            if law is None:
                watch.see(scenario)
            result = simulate(scenario, controller=law)
            return result if reduce is None else reduce(result)

    with hydraulics():
        found = worked_through(scenarios, one, threads or processors(), watch.say)
    if laws is not None:
        _check_count(laws, len(found))
    return found


def observe_many(scenarios: Iterable[Scenario], reduce: Callable[[Observed], T]) -> list[T]:
    """What is made of the channels of each scenario's run, which nobody judges; else as `simulate_many`."""

    def one(number: int, scenario: Scenario) -> T:
        with _naming(f"scenario {number} ({scenario.name})"):
            return reduce(observed(scenario))

    with hydraulics():
        return worked_through(scenarios, one, processors())


def _check_count(laws: Sequence[Any], scenarios: int) -> None:
    if len(laws) != scenarios:
        raise InputError(f"controllers: are {len(laws)}, they must be one for each of the {scenarios} scenarios")


@contextmanager
def _naming(where: str) -> Iterator[None]:
    """What fails within says where among many."""
    try:
        yield
    except Exception as error:
        named = _named(error, where)
        if named is error:
            raise
        raise named from error


def _named(error: Exception, where: str) -> Exception:
    """The error of one scenario among many, which says which."""
    if isinstance(error, Incomplete):
        return Incomplete(f"{where}: {error}", error.result)
    if isinstance(error, InputError):
        return InputError(f"{where}: {error}")
    error.add_note(f"in {where}")
    return error


class _Watch:
    """Sees scenarios that have one control and machines of their own, so that the law is another one for each."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.first: Scenario | None = None
        self.found: dict[str, tuple[Any, Any]] = {}
        self.said = False

    def see(self, scenario: Scenario) -> None:
        """Compare a scenario with the first one."""
        with self.lock:
            first = self.first = self.first or scenario
        if first.control == scenario.control and not self.found:
            own, other = first.installation, scenario.installation
            if derived_anew(scenario.control, own, other):
                self.found = unlike(own, other)

    def say(self) -> None:
        """Warn, once."""
        if self.found and not self.said and self.first is not None:
            self.said = True
            warn_derived(self.first.control, self.found, 5)
