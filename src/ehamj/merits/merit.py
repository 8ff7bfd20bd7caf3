"""What a figure of merit is, where it comes from, and what a design is that has it."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Final

from ehamj.errors import InputError, did_you_mean
from ehamj.registry import Registry
from ehamj.scenario.model import Scenario
from ehamj.scenario.variation import LawChoice


@dataclass(frozen=True)
class Merit:
    """A figure of merit: its ``name`` (dotted, as study files have it), ``unit`` (SI, dB or "1") and what it is."""

    name: str
    unit: str
    text: str


@dataclass(frozen=True)
class Design:
    """One design: its ``number`` in its study, and what it has that is not the scenario's, by dotted key.

    ``known`` are the values that a law derived for each design knows of it; None: all. A machine within tolerances of a
    design has the law of that design.
    """

    number: int
    values: Mapping[str, Any]
    known: Mapping[str, Any] | None = None


@dataclass(frozen=True)
class Failed:
    """Why a design has no merits, in one line."""

    reason: str


Found = Mapping[str, float] | Failed
"""A design's merits by name (NaN where one is not defined), or why it has none."""


@dataclass(frozen=True)
class Machine:
    """What designs differ from: a ``scenario``, and whether its ``law`` is held or derived anew for each design."""

    scenario: Scenario
    law: LawChoice = "held"


class Source(ABC):
    """One way to merits. Register an instance in `SOURCES` under the first word of the names of its merits."""

    block: ClassVar[int] = 64
    """Designs that are computed together. Studies cut their designs into such blocks, the same however the work is
    split, so that results are equal to the bit."""

    @abstractmethod
    def merits(self, machine: Machine) -> Mapping[str, Merit]:
        """All merits that a machine's designs can have, by name."""

    @abstractmethod
    def evaluate(self, machine: Machine, designs: Sequence[Design], names: Sequence[str]) -> list[Found]:
        """Merits of each design, in order. A design that is impossible, or whose run fails, is `Failed` by itself.

        Args:
            machine: what they differ from.
            designs: at most `block` of them.
            names: of the merits that are wanted; all of this source.
        """

    def why_not(self, machine: Machine, name: str) -> str:
        """Why this machine has no merit of a name that others have, in words; nothing where there is nothing to say."""
        return ""

    def notes(self, machine: Machine) -> list[str]:
        """What a reader of its merits must know of this machine: how they were computed, and what they leave out."""
        return []


SOURCES: Final[Registry[Source]] = Registry("source of merits")
"""All ways to merits by name; `ehamj.merits.catalogue` fills it."""


def source_of(name: str) -> str:
    """Name of the source that a merit belongs to: its first word.

    Raises:
        InputError: if there is no such source.
    """
    first = name.partition(".")[0]
    if first not in SOURCES:
        near = did_you_mean(first, SOURCES)
        raise InputError(f"merit {name!r}: {near}must begin with one of {', '.join(SOURCES)}")
    return first


def merit(machine: Machine, name: str) -> Merit:
    """A merit that a user named.

    Raises:
        InputError: if there is none for this machine; near ones are named.
    """
    found = SOURCES[source_of(name)].merits(machine)
    if name not in found:
        said = SOURCES[source_of(name)].why_not(machine, name) or did_you_mean(name, found).strip()
        if not said and found:
            said = f"there are {', '.join(list(found)[:12])}{', …' if len(found) > 12 else ''}"
        none = f"under control of kind {machine.scenario.control.name()!r} it has none that begins so"
        raise InputError(f"merit {name!r}: no such merit of this machine; {said or none}")
    return found[name]
