"""Do a study: ask for designs, have blocks of them computed, keep each block, tell how far it is."""

import json
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ehamj.campaign.identity import check_same, versions
from ehamj.campaign.named_schedulers import scheduler_of
from ehamj.campaign.plans.plan import Goals, Told, excess
from ehamj.campaign.rows import Column
from ehamj.campaign.schedulers import Computed
from ehamj.campaign.stages import Batch, Search, Stage
from ehamj.campaign.standing import Progress, Watch, silent
from ehamj.campaign.store import STORE_FILE, Store, writing
from ehamj.campaign.threads import one_thread
from ehamj.campaign.work import Block, Work
from ehamj.errors import DerivedAnew, InputError
from ehamj.interruption import Interrupted
from ehamj.merits.merit import Design, merit, source_of
from ehamj.merits.own import Own, owned
from ehamj.plain.text import toml_of

HOUR = 3600.0


@dataclass(frozen=True)
class Conducted:
    """How a study ended."""

    folder: Path
    done: int
    failed: int
    stages: Mapping[str, tuple[int, int]]
    """Number of the first design of each stage, and the one after its last."""
    complete: bool
    """Whether all stages are done; else the time that it may take is used up."""


@one_thread()
def conduct(
    folder: str | Path,
    stages: Sequence[Stage],
    about: Mapping[str, Any] | None = None,
    *,
    scheduler: Any = None,
    resume: bool = False,
    functions: Mapping[str, Any] | None = None,
    progress: Progress = silent,
    hours: float | None = None,
) -> Conducted:
    """Do all stages of a study, one after the other, into the store of a folder.

    Args:
        folder: of the study; made where it is not there.
        stages: in order; numbers of designs go on from one to the next.
        about: the study's file, plain data; another one is another study.
        scheduler: see `ehamj.campaign.named_schedulers.scheduler_of`.
        resume: whether it goes on with what is stored there.
        functions: the user's own merits, see `ehamj.merits.own.owned`.
        progress: called when a block is stored, on this thread.
        hours: beyond which no further block begins [h].

    Raises:
        InputError: if it cannot be done as it is, if the folder holds another study, this one and ``resume`` is not
            asked for, or another process is at work on it. Nothing is written then.
        OSError: if the store cannot be written. What is stored stays, and can be resumed.
        SimulationFailed: if all workers are gone for good; as before.
    """
    folder, own = Path(folder), owned(functions or {})
    works = [Work.of(stage.machine, stage.names, own) for stage in stages]
    columns = columns_of(stages, works)
    identity = identity_of(stages, works, about or {}, own)
    if resume and not (folder / STORE_FILE).is_file():
        raise InputError(f"study {str(folder)!r}: holds no {STORE_FILE} to resume; begin it without resuming")
    goals = next((stage.goals for stage in stages if isinstance(stage, Search)), Goals())
    deadline = None if hours is None else time.monotonic() + HOUR * hours
    total = sum(stage.count() for stage in stages)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DerivedAnew)  # of each of thousands; the study says so once
        watch = Watch(total, goals, progress)
        with (
            scheduler_of(scheduler).running(lambda words: watch.say(waiting=words)) as computed,
            writing(folder, columns, {"identity": identity}) as (store, there),
        ):
            if there:
                _check_resumed(store, identity, resume, folder)
            try:
                doing = _Doing(store, watch, computed, deadline)
                places = _conducted(stages, works, doing)
                if not doing.late:
                    store.say(stages=places)
                return Conducted(folder, store.count(), store.count(failed=True), places, not doing.late)
            except (KeyboardInterrupt, Interrupted):
                watch.say(interrupted=True)  # before workers are waited for
                raise


def _check_resumed(store: Store, identity: Mapping[str, Any], resume: bool, folder: Path) -> None:
    if not resume:
        raise InputError(
            f"study {str(folder)!r}: holds {store.count()} designs already; resume it, or name another folder"
        )
    check_same(store.said("identity"), identity, f"study {str(folder)!r}")


@dataclass
class _Doing:
    """What all stages are done with."""

    store: Store
    watch: Watch
    computed: Computed
    deadline: float | None
    late: bool = False


def _conducted(stages: Sequence[Stage], works: Sequence[Work], doing: _Doing) -> dict[str, tuple[int, int]]:
    """Do the stages; numbers of the designs of each that was begun."""
    first, places = 0, dict[str, tuple[int, int]]()
    for stage, work in zip(stages, works, strict=True):
        doing.watch.say(stage=stage.name)
        began, asked = first, stage.batches(doing.store)
        batch = next(asked, None)
        while batch is not None:
            for rows in doing.computed(work, _missing(doing, stage, work, batch, first)):
                doing.store.append(rows)
                _counted(doing, stage, rows[0].number, rows[-1].number + 1, new=True)
            if doing.late:
                return places | {stage.name: (began, first + batch.count)}
            told = _told(doing.store, first, first + batch.count, stage)
            first += batch.count
            try:
                batch = asked.send(told)
            except StopIteration:
                batch = None
        places[stage.name] = began, first
    return places


def _missing(doing: _Doing, stage: Stage, work: Work, batch: Batch, first: int) -> Iterator[Block]:
    """Blocks that are not stored, one after the other until the time is used up; those that are, are counted."""
    for at in range(0, batch.count, work.block):
        start, stop = first + at, first + min(at + work.block, batch.count)
        there = doing.store.count(start, stop)
        if there == stop - start:
            _counted(doing, stage, start, stop, new=False)
            continue
        if there:
            raise InputError(
                f"{str(doing.store.path)!r}: is damaged: designs {start} to {stop - 1} are stored together, and only "
                f"{there} of them are there"
            )
        doing.late = doing.deadline is not None and time.monotonic() > doing.deadline
        if doing.late:
            return
        numbered = list(enumerate(batch.designs(start - first, stop - first), start))
        designs = tuple(Design(number, one.values, one.known) for number, one in numbered)
        yield Block(stage.name, designs, tuple(one.parent for _, one in numbered))


def _counted(doing: _Doing, stage: Stage, first: int, stop: int, new: bool) -> None:
    """Tell that designs are stored; those of a search compete for the best."""
    merits = doing.store.merits(first, stop, doing.watch.names) if isinstance(stage, Search) else None
    doing.watch.count(first, merits, doing.store.count(first, stop, failed=True), stop - first, new)


def _told(store: Store, first: int, stop: int, stage: Stage) -> Told:
    """What a search is told of a batch."""
    goals = stage.goals if isinstance(stage, Search) else Goals()
    signs = np.array([sign for _, sign in goals.objectives])
    objectives = signs * store.merits(first, stop, [name for name, _ in goals.objectives])
    merits = store.merits(first, stop, [name for name, *_ in goals.constraints])
    bounds = ((at, low, high) for at, (_, low, high) in enumerate(goals.constraints))
    violations = [excess(merits[:, at], low, high) for at, low, high in bounds]
    return Told(objectives, np.stack(violations, axis=1) if violations else merits)


def columns_of(stages: Sequence[Stage], works: Sequence[Work]) -> list[Column]:
    """Columns of all stages' values, then of their merits.

    Raises:
        InputError: if a merit is none of its machine's.
    """
    found: dict[tuple[str, str], Column] = {}
    for stage in stages:
        for column in stage.values():
            found.setdefault(("value", column.name), column)
    for stage, work in zip(stages, works, strict=True):
        sources = work.sources()
        for name in stage.names:
            known = sources[source_of(name)].merits(stage.machine)
            own = known[name] if name in known else merit(stage.machine, name)  # which says what there is
            found.setdefault(("merit", name), Column(name, own.unit, "merit", own.text))
    return list(found.values())


def identity_of(
    stages: Sequence[Stage], works: Sequence[Work], about: Mapping[str, Any], functions: Mapping[str, Own]
) -> dict[str, Any]:
    """All that results depend on, as plain data."""
    named = {
        stage.name: {
            "scenario": toml_of(work.scenario),
            "law": work.law,
            "merits": list(stage.names),
            "parameters": [column.name for column in stage.values()],
            "block": work.block,
            **stage.about(),
        }
        for stage, work in zip(stages, works, strict=True)
    }
    told = {name: own.digest() for name, own in functions.items()}
    own = {"file": about, "stages": named, "functions": told, "versions": versions()}
    return dict(json.loads(json.dumps(own, default=str)))
