"""Run many scenarios on threads, those of equal structure on the small-motion engine side by side."""

import threading
from collections.abc import Callable, Iterable, Iterator, Sequence, Sized
from typing import Any, TypeVar, overload

from ehamj.errors import InputError
from ehamj.result import Result
from ehamj.run.simulate import Observed, judged, seen
from ehamj.run.together import Item, Ran, Refused, called, together
from ehamj.run.workers import processors
from ehamj.scenario.load import Given, as_scenario
from ehamj.scenario.model import ENGINES, Engine, Scenario
from ehamj.scenario.variation import derived_anew, unlike, warn_derived

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
    on_failure: Callable[[int, Exception], T] | None = None,
    engine: Engine | None = None,
) -> list[T]: ...


@overload
def simulate_many(
    scenarios: Iterable[Given],
    threads: int | None = None,
    controllers: Sequence[Any] | None = None,
    *,
    on_failure: Callable[[int, Exception], T],
    engine: Engine | None = None,
) -> list[Result | T]: ...


def simulate_many(
    scenarios: Iterable[Given],
    threads: int | None = None,
    controllers: Sequence[Any] | None = None,
    *,
    reduce: Callable[[Result], Any] | None = None,
    on_failure: Callable[[int, Exception], Any] | None = None,
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
        on_failure: makes of a scenario that fails, of its number and the error, what stands in its place: one that is
            none, that cannot be prepared, whose run stops (`Incomplete` has what there is of it), or of which
            ``reduce`` fails. It stops nothing then, and what comes of the others is the same to the bit.
        engine: runs them instead of the engine that each states.

    Warns:
        DerivedAnew: if scenarios of one control differ in their machines, and the law was derived for each: it knows
            every one exactly, and what comes out is no scatter within tolerances. `Scenario.varied` holds the law.

    Raises:
        InputError: if there are not as many controllers as scenarios, ``threads`` is less than one, or there is no such
            engine.
        Exception: as `simulate` or ``reduce``, for the first scenario that fails, which the message names; no further
            one begins. None of these with ``on_failure``.
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

    def result_of(ran: Ran) -> Any:
        result = judged(seen(ran.prepared, ran.driven), ran.began, ran.item.law)
        return result if reduce is None else reduce(result)

    items = _items(scenarios, laws, engine, watch, on_failure is not None)
    found = together(items, result_of, threads or processors(), _count_of(scenarios), watch.say, on_failure)
    if laws is not None:
        _check_count(laws, len(found))
    return found


def observe_many(scenarios: Iterable[Scenario], reduce: Callable[[Observed], T], threads: int | None = None) -> list[T]:
    """What is made of the channels of each scenario's run, which nobody judges; else as `simulate_many`."""

    def checked(ran: Ran) -> T:
        run = seen(ran.prepared, ran.driven)
        if run.failed is not None:
            judged(run, ran.began, None)  # raises
        return reduce(run)

    items = (Item(number, scenario) for number, scenario in enumerate(scenarios))
    return together(items, checked, threads or processors(), _count_of(scenarios))


def _items(
    scenarios: Iterable[Given], laws: Sequence[Any] | None, engine: Engine | None, watch: "_Watch", alone: bool
) -> Iterator[Item | Refused]:
    """The scenarios one by one, on the engine that is asked for, each with its law; where failures are borne ``alone``,
    what is none is told."""
    for number, one in enumerate(scenarios):
        where = f"scenario {number}"
        try:
            scenario = as_scenario(one)
            scenario = scenario if engine is None else scenario.model_copy(update={"engine": engine})
            item = Item(number, scenario)
            where = item.where
            if laws is not None:
                _check_count(laws, max(number + 1, len(laws)))
                item = item._replace(law=laws[number])
        except Exception as error:
            if not alone:
                raise called(error, where) from error
            yield Refused(number, error)
            continue
        if item.law is None:
            watch.see(scenario)
        yield item


def _count_of(scenarios: Iterable[Any]) -> int | None:
    return len(scenarios) if isinstance(scenarios, Sized) else None


def _check_count(laws: Sequence[Any], scenarios: int) -> None:
    if len(laws) != scenarios:
        raise InputError(f"controllers: are {len(laws)}, they must be one for each of the {scenarios} scenarios")


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
