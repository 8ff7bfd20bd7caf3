"""Run many scenarios on threads, those of equal structure on the small-motion engine side by side."""

import threading
import time as clock
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence, Sized
from contextlib import AbstractContextManager, contextmanager
from typing import Any, NamedTuple, TypeVar, overload

from ehamj.control import as_controller
from ehamj.errors import InputError
from ehamj.ground.shared import Floors
from ehamj.mujoco import hydraulics
from ehamj.result import Result
from ehamj.run.drive import Driven
from ehamj.run.failures import Incomplete
from ehamj.run.prepare import Prepared, prepare
from ehamj.run.side_by_side import LANES, drive_block, shape, small
from ehamj.run.simulate import Observed, driven_alone, judged, seen
from ehamj.run.workers import processors, worked_through
from ehamj.scenario.load import Given, as_scenario
from ehamj.scenario.model import ENGINES, Engine, Scenario
from ehamj.scenario.variation import derived_anew, unlike, warn_derived
from ehamj.smallmotion.block import Simulation

T = TypeVar("T")


@overload
def simulate_many(
    scenarios: Iterable[Given],
    threads: int | None = None,
    controllers: Sequence[Any] | None = None,
    *,
    engine: Engine | None = None,
) -> list[Result]: ...


@overload
def simulate_many(
    scenarios: Iterable[Given],
    threads: int | None = None,
    controllers: Sequence[Any] | None = None,
    *,
    reduce: Callable[[Result], T],
    engine: Engine | None = None,
) -> list[T]: ...


def simulate_many(
    scenarios: Iterable[Given],
    threads: int | None = None,
    controllers: Sequence[Any] | None = None,
    *,
    reduce: Callable[[Result], Any] | None = None,
    engine: Engine | None = None,
) -> list[Any]:
    """Run scenarios on threads inside this process; results come in order.

    On the small-motion engine a thread takes several scenarios at once, and those of equal structure (step, duration,
    mounts, options with states, law but for its numbers) step together.

    Args:
        scenarios: what to simulate, each as `simulate` takes it. They are asked for one by one as threads get free, so
            that a generator need not hold them all.
        threads: how many at once; by default as many as the process has processors.
        controllers: one for each scenario, see `simulate`; None leaves a scenario its own control.
        reduce: makes of each result, on its thread, what is wanted of it. The result is then forgotten, so that memory
            is that of ``threads`` runs (on the small-motion engine of 8 times as many), however many there are.
        engine: runs them instead of the engine that each states.

    Warns:
        DerivedAnew: if scenarios of one control differ in their machines, and the law was derived for each: it knows
            every one exactly, and what comes out is no scatter within tolerances. `Scenario.varied` holds the law.

    Raises:
        InputError: if there are not as many controllers as scenarios, ``threads`` is less than one, or there is no such
            engine.
        As `simulate` or ``reduce``, for the first scenario that fails, which the message names; no further one begins.
    """
    if threads is not None and threads < 1:
        raise InputError(f"threads = {threads}: must be at least 1")
    if engine is not None and engine not in ENGINES:
        raise InputError(f"engine = {engine!r}: must be one of {', '.join(ENGINES)}")
    laws = None if controllers is None else list(controllers)
    if isinstance(scenarios, str):
        raise InputError(f"scenarios = {scenarios!r}: must be several, such as a list; `simulate` runs one")
    if laws is not None and isinstance(scenarios, Sized):
        _check_count(laws, len(scenarios))
    watch = _Watch()

    def result_of(item: _Item, run: Observed, began: float) -> Any:
        result = judged(run, began, item.law)
        return result if reduce is None else reduce(result)

    found = _together(
        _items(scenarios, laws, engine, watch), result_of, threads or processors(), _count_of(scenarios), watch.say
    )
    if laws is not None:
        _check_count(laws, len(found))
    return found


def observe_many(scenarios: Iterable[Scenario], reduce: Callable[[Observed], T], threads: int | None = None) -> list[T]:
    """What is made of the channels of each scenario's run, which nobody judges; else as `simulate_many`."""
    items = (_Item(number, scenario, None) for number, scenario in enumerate(scenarios))

    def checked(item: _Item, run: Observed, began: float) -> T:
        if run.failed is not None:
            judged(run, began, None)  # raises
        return reduce(run)

    return _together(items, checked, threads or processors(), _count_of(scenarios))


class _Item(NamedTuple):
    """One scenario among many, and the law that runs instead of its own."""

    number: int
    scenario: Scenario
    law: Any

    def named(self) -> AbstractContextManager[None]:
        """What fails within says which scenario it was."""
        return _naming(f"scenario {self.number} ({self.scenario.name})")


def _items(
    scenarios: Iterable[Given], laws: Sequence[Any] | None, engine: Engine | None, watch: "_Watch"
) -> Iterator[_Item]:
    """The scenarios one by one, on the engine that is asked for, each with its law."""
    for number, one in enumerate(scenarios):
        with _naming(f"scenario {number}"):
            scenario = as_scenario(one)
        scenario = scenario if engine is None else scenario.model_copy(update={"engine": engine})
        item = _Item(number, scenario, None)
        with item.named():
            if laws is not None:
                _check_count(laws, max(number + 1, len(laws)))
                item = item._replace(law=laws[number])
        if item.law is None:
            watch.see(scenario)
        yield item


def _count_of(scenarios: Iterable[Any]) -> int | None:
    return len(scenarios) if isinstance(scenarios, Sized) else None


def _together(
    items: Iterator[_Item],
    work: Callable[[_Item, Observed, float], T],
    threads: int,
    count: int | None,
    meanwhile: Callable[[], None] = lambda: None,
) -> list[T]:
    """What ``work`` makes of each run, in order; of ``count`` runs, if that is known, each thread gets its share."""
    room = LANES if count is None else max(1, min(LANES, -(-count // threads)))

    def batches() -> Iterator[list[_Item]]:
        batch: list[_Item] = []
        for item in items:
            batch.append(item)
            if len(batch) == room or item.scenario.engine == "mujoco":
                yield batch
                batch = []
        if batch:
            yield batch

    def one(_: int, batch: list[_Item]) -> list[T]:
        found: dict[int, T] = {}
        failures: dict[int, Exception] = {}
        for item, prepared, driven, spent in _driven(batch, failures):
            began = clock.perf_counter() - spent
            try:
                with item.named():
                    found[item.number] = work(item, seen(prepared, driven), began)
            except Exception as error:
                failures[item.number] = error
        if failures:
            raise failures[min(failures)]
        return [found[item.number] for item in batch]

    with hydraulics():
        return [each for batch in worked_through(batches(), one, threads, meanwhile) for each in batch]


def _driven(batch: Sequence[_Item], failures: dict[int, Exception]) -> Iterator[tuple[_Item, Prepared, Driven, float]]:
    """Runs as their engines leave them, those of one structure on the small-motion engine side by side; and how long
    each took, of what it took together its share [s].

    The first that cannot be prepared goes to ``failures`` by its number: those before it may fail too, and run.
    """
    blocks: dict[Hashable, list[tuple[_Item, Prepared, Simulation, float]]] = {}
    floors = Floors(1)  # those of one floor build it once, and a block samples it once
    for item in batch:
        began = clock.perf_counter()
        try:
            with item.named():
                law = None if item.law is None else as_controller(item.law)
                prepared = prepare(item.scenario, law, None if item.scenario.engine == "mujoco" else floors)
                # A Python function may remember: it is reset before each run, and then runs.
                alone = item.scenario.engine == "mujoco" or bool(prepared.loop.functions)
                own = None if alone else small(prepared)
                driven = driven_alone(prepared) if alone else None
        except Exception as error:
            failures[item.number] = error
            break
        spent = clock.perf_counter() - began
        if own is None:
            assert driven is not None
            yield item, prepared, driven, spent
        else:
            blocks.setdefault(shape(prepared, own), []).append((item, prepared, own, spent))
    for block in blocks.values():
        taken, runs, simulations, before = zip(*block, strict=True)
        began, ended = clock.perf_counter(), drive_block(runs, simulations)
        numbers = ", ".join(str(item.number) for item in taken)
        with _naming(f"scenario {numbers}" if len(taken) == 1 else f"scenarios {numbers}, which step together"):
            first = next(ended)
        share = (clock.perf_counter() - began) / len(block)
        for number, (item, prepared, spent) in enumerate(zip(taken, runs, before, strict=True)):
            with item.named():  # its last rows go to a file of its own
                driven = next(ended) if number else first
            yield item, prepared, driven, spent + share


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
            warn_derived(self.first.control, self.found, 6)
