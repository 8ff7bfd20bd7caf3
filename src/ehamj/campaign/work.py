"""What a worker needs to evaluate a block of designs, and how it does: in a thread, a process, or on a cluster."""

import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import import_module
from typing import Any, Final

from ehamj.campaign.identity import versions
from ehamj.campaign.rows import Row
from ehamj.campaign.threads import stay_on_one_thread
from ehamj.errors import InputError
from ehamj.merits.merit import SOURCES, Design, Failed, Found, Machine, Source, source_of
from ehamj.merits.own import OWN, Own, OwnFunctions, check_owned
from ehamj.plain.text import toml_of
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.variation import LawChoice

LONGEST: Final = 400
"""Letters of a reason that are kept."""


@dataclass(frozen=True)
class Block:
    """Designs of one stage that are computed together and stored together."""

    stage: str
    designs: tuple[Design, ...]
    """Of consecutive numbers."""
    parents: tuple[int | None, ...]

    @property
    def first(self) -> int:
        """Number of the first one."""
        return self.designs[0].number

    def single(self) -> "list[Block]":
        """Each design by itself."""
        own = zip(self.designs, self.parents, strict=True)
        return [Block(self.stage, (design,), (parent,)) for design, parent in own]

    def failed(self, reason: str) -> list[Row]:
        """Rows of designs that nothing was found of."""
        return _rows(self, [Failed(reason)] * len(self.designs), [{}] * len(self.designs), 0.0)


@dataclass(frozen=True)
class Work:
    """What is asked of designs of one machine; plain data, which goes to other processes and computers."""

    scenario: str
    """The machine's, in TOML, with all its keys."""
    law: LawChoice
    names: tuple[str, ...]
    """Of the merits that are wanted."""
    functions: Mapping[str, Own] = field(default_factory=dict)
    """The user's own, by merit."""
    modules: tuple[str, ...] = ()
    """That register the sources of the merits."""
    versions: Mapping[str, str] = field(default_factory=dict)
    """Of what results depend on; other ones would give other results."""

    @classmethod
    def of(cls, machine: Machine, names: Sequence[str], functions: Mapping[str, Own] | None = None) -> "Work":
        """What is asked of a machine's designs.

        Raises:
            InputError: if a merit has no source, or no function.
        """
        functions = functions or {}
        check_owned(names, functions)
        sources = dict.fromkeys(source_of(name) for name in names)
        modules = tuple(sorted({type(SOURCES[one]).__module__ for one in sources}))
        wanted = {name: functions[name] for name in names if name in functions}
        return cls(machine.scenario.to_toml(), machine.law, tuple(names), wanted, modules, versions())

    def sources(self) -> dict[str, Source]:
        """Sources of the merits, by first word, in the order in which they are asked."""
        named = dict.fromkeys(source_of(name) for name in self.names)
        return {name: OwnFunctions(self.functions) if name == OWN else SOURCES[name] for name in named}

    @property
    def block(self) -> int:
        """Designs of one task: the fewest that one of the sources takes together. Slow ones take few, so that little
        is lost where a worker is, and every worker has some."""
        return min(source.block for source in self.sources().values())

    def machine(self) -> Machine:
        """What designs differ from, made once for all blocks of a process."""
        return _machine(self.scenario, self.law)


@lru_cache(maxsize=4)
def _machine(scenario: str, law: LawChoice) -> Machine:
    return Machine(parse_scenario(toml_of(scenario)), law)


def ready(work: Work) -> None:
    """Make this process one that can do the work.

    Raises:
        InputError: if it has other versions than the one that asks, or cannot import what it needs.
    """
    stay_on_one_thread()
    own = versions()
    other = {name: (version, own.get(name)) for name, version in work.versions.items() if own.get(name) != version}
    if other:
        said = ", ".join(
            f"{name} {theirs or 'missing'} (the study has {ours})" for name, (ours, theirs) in other.items()
        )
        raise InputError(f"a worker has {said}: results would differ; give all workers the same versions")
    for name in work.modules:
        if name not in sys.modules:
            try:
                import_module(name)
            except ImportError as error:
                raise InputError(f"a worker cannot import {name!r}, which computes merits: {error}") from error


def evaluate(work: Work, block: Block) -> list[Row]:
    """What the designs of a block come out with, one row each. A design that fails does so by itself.

    Raises:
        InputError: if this process cannot do the work, see `ready`.
    """
    ready(work)
    began = time.perf_counter()
    machine = work.machine()
    merits: list[dict[str, float]] = [{} for _ in block.designs]
    reasons: list[list[str]] = [[] for _ in block.designs]
    for word, source in work.sources().items():
        names = [name for name in work.names if source_of(name) == word]
        for at, found in enumerate(_found(source, machine, block.designs, names)):
            if isinstance(found, Failed):
                reasons[at].append(f"{word}: {found.reason}")
            elif missing := [name for name in names if name not in found]:
                reasons[at].append(f"{word}: {missing[0]} was not found")
            else:
                merits[at] |= {name: float(found[name]) for name in names}
    failures = [Failed(one_line("; ".join(told))) if told else None for told in reasons]
    return _rows(block, failures, merits, time.perf_counter() - began)


def one_line(text: str) -> str:
    """A reason on one line that is not too long."""
    line = " ".join(text.split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 1]}…"


def _found(source: Source, machine: Machine, designs: Sequence[Design], names: Sequence[str]) -> list[Found]:
    """What a source finds of each design, as many at a time as it takes together."""
    found: list[Found] = []
    for first in range(0, len(designs), source.block):
        piece = designs[first : first + source.block]
        try:
            own = source.evaluate(machine, piece, names)
            if len(own) != len(piece):
                raise RuntimeError(f"{len(own)} results of {len(piece)} designs")
        except Exception as error:  # whatever it is, the other designs go on
            own = [_by_itself(source, machine, one, names) for one in piece] if len(piece) > 1 else [_reason(error)]
        found += own
    return found


def _by_itself(source: Source, machine: Machine, design: Design, names: Sequence[str]) -> Found:
    """What a source finds of one design of a block of which one makes it fail."""
    try:
        (found,) = source.evaluate(machine, [design], names)
        return found
    except Exception as error:
        return _reason(error)


def _reason(error: Exception) -> Failed:
    said = str(error)
    return Failed(said if isinstance(error, InputError) and said else f"{type(error).__name__}: {said}".rstrip(": "))


def _rows(block: Block, failures: Sequence[Any], merits: Sequence[Mapping[str, float]], seconds: float) -> list[Row]:
    share = seconds / len(block.designs)
    own = zip(block.designs, block.parents, merits, failures, strict=True)
    return [
        Row(design.number, block.stage, parent, design.values, found, failed, share)
        for design, parent, found, failed in own
    ]
