"""The way through many runs on threads: each as its engine steps it, those of equal structure side by side."""

import time as clock
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple, Self, TypeVar

from ehamj.control import as_controller
from ehamj.control.noise import Heard
from ehamj.errors import InputError
from ehamj.ground.shared import Floors
from ehamj.mujoco import hydraulics
from ehamj.run.drive import Driven
from ehamj.run.failures import Incomplete
from ehamj.run.prepare import Prepared, prepare
from ehamj.run.side_by_side import LANES, drive_block, shape, small
from ehamj.run.simulate import driven_alone
from ehamj.run.workers import worked_through
from ehamj.scenario.model import Scenario
from ehamj.smallmotion.block import Simulation

T = TypeVar("T")


class Item(NamedTuple):
    """One scenario among many, and the law that runs instead of its own."""

    number: int
    scenario: Scenario
    law: Any = None

    @property
    def where(self) -> str:
        """It in words."""
        return f"scenario {self.number} ({self.scenario.name})"


class Refused(NamedTuple):
    """What should have been a scenario among many, and why it is none."""

    number: int
    error: Exception


class Shared(NamedTuple):
    """What runs of many batches, one after the other, have in common and is made once."""

    floors: Floors
    heard: Heard

    @classmethod
    def lasting(cls) -> Self:
        """Of runs that read no file, which may change."""
        return cls(Floors(None), Heard())


class Ran(NamedTuple):
    """One run among many as the stepping loop left it."""

    item: Item
    prepared: Prepared
    driven: Driven
    began: float
    """When it would have begun, had it run by itself, of what several took together its share [s]."""


def together(
    items: Iterable[Item | Refused],
    work: Callable[[Ran], T],
    threads: int,
    count: int | None = None,
    meanwhile: Callable[[], None] = lambda: None,
    on_failure: Callable[[int, Exception], T] | None = None,
    held: bool = True,
    shared: Shared | None = None,
) -> list[T]:
    """What is made of each run, in order.

    Args:
        items: what to run; asked for as threads get free.
        work: makes of a run, on its thread, what is wanted of it.
        threads: how many; 0: on that of the caller, which has its own memory to come back to.
        count: how many items there are, if that is known: each thread gets its share.
        meanwhile: called now and then on the thread of the caller.
        on_failure: gives, by its number and the error, what stands for one that cannot be run or worked on; without it
            the first failure is raised, named, and no other begins.
        held: whether what is made of a run may hold on to its channels; else runs of one batch share what is the same.
        shared: what they have in common with runs before and after these; with it, channels must not be held.
    """
    room = LANES if count is None else max(1, min(LANES, -(-count // max(threads, 1))))

    def batches() -> Iterator[list[Item | Refused]]:
        batch: list[Item | Refused] = []
        for item in items:
            batch.append(item)
            if len(batch) == room or (isinstance(item, Item) and item.scenario.engine == "mujoco"):
                yield batch
                batch = []
        if batch:
            yield batch

    def one(_: int, batch: list[Item | Refused]) -> list[T]:
        found: dict[int, T] = {}
        failures = Failures({}, alone=on_failure is not None)
        for ran in driven(batch, failures, held, shared):
            with failures.of(ran.item):
                found[ran.item.number] = work(ran)
        if on_failure is None:
            failures.raise_first()
            return [found[item.number] for item in batch]
        errors = failures.errors
        return [
            on_failure(item.number, errors[item.number]) if item.number in errors else found[item.number]
            for item in batch
        ]

    with hydraulics():
        if threads == 0:
            return [each for number, batch in enumerate(batches()) for each in one(number, batch)]
        return [each for batch in worked_through(batches(), one, threads, meanwhile) for each in batch]


class Failures(NamedTuple):
    """What failed, by its number; where that is borne ``alone``, nothing else ends with it."""

    errors: dict[int, Exception]
    alone: bool

    @contextmanager
    def of(self, item: Item) -> Iterator[None]:
        """Keep what fails within; its name is part of it where it is to be raised."""
        try:
            yield
        except Exception as error:
            self.errors[item.number] = error if self.alone else called(error, item.where)

    def raise_first(self) -> None:
        """Raise the first."""
        if self.errors:
            raise self.errors[min(self.errors)]


def driven(
    batch: Sequence[Item | Refused], failures: Failures, held: bool, shared: Shared | None = None
) -> Iterator[Ran]:
    """Runs as their engines leave them, those of one structure on the small-motion engine side by side; for ``held``
    and ``shared`` see `together`.

    Where failures are not borne alone, the first that cannot be prepared is the last: those before it may fail too,
    and run.
    """
    blocks: dict[Hashable, list[_Standing]] = {}
    # Those of one floor build it once, and a block samples it once.
    floors = Floors(1 if held else len(batch)) if shared is None else shared.floors
    for item in batch:
        begun = _begun(item, floors, failures)
        if isinstance(begun, Ran):
            yield begun
        elif begun is not None:
            blocks.setdefault(shape(begun.prepared, begun.own), []).append(begun)
        elif not failures.alone:
            break
    for block in blocks.values():
        yield from _side_by_side(block, failures, held, None if shared is None else shared.heard)


class _Standing(NamedTuple):
    """A simulation that waits for others of its structure, and how long it took to prepare [s]."""

    item: Item
    prepared: Prepared
    own: Simulation
    before: float


def _begun(item: Item | Refused, floors: Floors, failures: Failures) -> _Standing | Ran | None:
    """A scenario made ready to step beside others, or run by itself where it must; None where that failed."""
    if isinstance(item, Refused):
        failures.errors[item.number] = item.error
        return None
    began = clock.perf_counter()
    with failures.of(item):
        law = None if item.law is None else as_controller(item.law)
        prepared = prepare(item.scenario, law, None if item.scenario.engine == "mujoco" else floors)
        # A Python function may remember: it is reset before each run, and then runs.
        if item.scenario.engine == "mujoco" or prepared.loop.functions:
            return Ran(item, prepared, driven_alone(prepared), began)
        return _Standing(item, prepared, small(prepared), clock.perf_counter() - began)
    return None


def _side_by_side(block: Sequence[_Standing], failures: Failures, held: bool, heard: Heard | None) -> Iterator[Ran]:
    began = clock.perf_counter()
    ended = drive_block([one.prepared for one in block], [one.own for one in block], copied=held, heard=heard)
    try:
        first = next(ended)
    except Exception as error:
        if failures.alone and len(block) > 1:  # whichever it is of: who runs alone knows
            for standing in block:
                yield from driven([standing.item], failures, held)
            return
        failures.errors[block[0].item.number] = error if failures.alone else called(error, _all(block))
        return
    share = (clock.perf_counter() - began) / len(block)
    for number, standing in enumerate(block):
        with failures.of(standing.item):  # its last rows go to a file of its own
            own = next(ended) if number else first
        if standing.item.number not in failures.errors:
            yield Ran(standing.item, standing.prepared, own, clock.perf_counter() - standing.before - share)
        elif not failures.alone:
            return


def _all(block: Sequence[_Standing]) -> str:
    """All of a block in words."""
    numbers = ", ".join(str(one.item.number) for one in block)
    return f"scenario {numbers}" if len(block) == 1 else f"scenarios {numbers}, which step together"


def called(error: Exception, where: str) -> Exception:
    """The error of one scenario among many, which says which."""
    if isinstance(error, Incomplete):
        named: Exception = Incomplete(f"{where}: {error}", error.result)
    elif isinstance(error, InputError):
        named = InputError(f"{where}: {error}")
    else:
        error.add_note(f"in {where}")
        return error
    named.__cause__ = error
    return named
