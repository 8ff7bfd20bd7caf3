"""What a study does one after the other: a search, the best designs within tolerances, once more on another engine."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ehamj.arrays import Array
from ehamj.campaign.plans.plan import Goals, Plan, Told
from ehamj.campaign.rows import Column
from ehamj.merits.merit import Machine
from ehamj.scenario.keys import plain

if TYPE_CHECKING:
    from ehamj.campaign.parameters import Space
    from ehamj.campaign.store import Store

Values = Mapping[str, Any]
"""What a design has that is not the scenario's, by dotted key."""
Parent = tuple[int | None, Values]
"""A design to go on from: its number, None where it is none of the study's, and its values."""


class Wanted(NamedTuple):
    """A design that is asked for: the number of its parent, if it has one, its values, and those of them that a law
    derived for it knows; None: all."""

    parent: int | None
    values: Values
    known: Values | None = None


@dataclass(frozen=True)
class Batch:
    """Designs that a stage asks for before it is told what any of them came out with."""

    count: int
    designs: Callable[[int, int], Sequence[Wanted]]
    """Those from the first number up to the second, counted within the batch; asked for block by block, so that memory
    does not grow with their number."""


Asked = Generator[Batch, Told, None]


@dataclass(frozen=True)
class Stage(ABC):
    """One part of a study: a ``name``, the ``machine`` that its designs differ from and the ``names`` of the merits
    that are wanted of them."""

    name: str
    machine: Machine
    names: tuple[str, ...]

    @abstractmethod
    def values(self) -> Sequence[Column]:
        """What its designs may differ in."""

    @abstractmethod
    def count(self) -> int:
        """How many designs it makes, at most."""

    @abstractmethod
    def batches(self, store: "Store") -> Asked:
        """Its designs, the same whenever it is asked; those of earlier stages are in the store."""

    @abstractmethod
    def about(self) -> dict[str, Any]:
        """What its designs depend on, beside machine and merits, as plain data."""


@dataclass(frozen=True)
class Search(Stage):
    """All designs of a plan."""

    plan: Plan
    space: "Space"
    goals: Goals = field(default_factory=Goals)

    def values(self) -> Sequence[Column]:
        """The parameters."""
        return columns_of(self.space)

    def count(self) -> int:
        """As the plan says."""
        return self.plan.count(self.space)

    def batches(self, store: "Store") -> Asked:
        """As the plan makes them."""
        asked = self.plan.batches(self.space, self.goals)
        points = next(asked, None)
        while points is not None:

            def designs(first: int, stop: int, own: Array = points) -> Sequence[Wanted]:
                return [Wanted(None, values) for values in self.space.values(own[first:stop])]

            told = yield Batch(len(points), designs)
            try:
                points = asked.send(told)
            except StopIteration:
                return

    def about(self) -> dict[str, Any]:
        """Plan with its seeds."""
        return {"plan": plain(self.plan)}


@dataclass(frozen=True)
class Again(Stage):
    """Chosen designs once more, as they are: on another engine, another floor, for longer."""

    chosen: Callable[["Store"], Sequence[Parent]]
    """Which, once all earlier stages are done; nothing but the store may decide it."""
    keys: Sequence[Column]
    most: int

    def values(self) -> Sequence[Column]:
        """What the chosen ones differ in."""
        return self.keys

    def count(self) -> int:
        """As many as may be chosen."""
        return self.most

    def batches(self, store: "Store") -> Asked:
        """All together."""
        chosen = list(self.chosen(store))
        if chosen:
            yield Batch(len(chosen), lambda first, stop: [Wanted(*one) for one in chosen[first:stop]])

    def about(self) -> dict[str, Any]:
        """How many."""
        return {"most": self.most}


@dataclass(frozen=True)
class Around(Again):
    """Machines around chosen designs, as tolerances make them: for each parent the designs of a plan."""

    plan: Plan
    space: Callable[[Values], "Space"]
    """What may be otherwise, around a design's values."""

    def values(self) -> Sequence[Column]:
        """What the chosen ones differ in, and what their tolerances are of."""
        own = columns_of(self.space({}))
        return [*self.keys, *(one for one in own if one.name not in {key.name for key in self.keys})]

    def count(self) -> int:
        """Designs of all parents."""
        return self.most * self.plan.count(self.space({}))

    def batches(self, store: "Store") -> Asked:
        """All machines of the first parent, then of the next, all together: the same draws around each."""
        chosen = [(number, values, self.space(values)) for number, values in self.chosen(store)]
        if not chosen:
            return
        points = np.concatenate(list(self.plan.batches(chosen[0][2], Goals())))

        def designs(first: int, stop: int) -> Sequence[Wanted]:
            found: list[Wanted] = []
            while first < stop:
                of, at = divmod(first, len(points))
                number, values, space = chosen[of]
                own = points[at : at + stop - first]
                found += [Wanted(number, {**values, **one}, values) for one in space.values(own)]
                first += len(own)
            return found

        yield Batch(len(chosen) * len(points), designs)

    def about(self) -> dict[str, Any]:
        """Plan with its seeds, and how many parents."""
        return {"most": self.most, "plan": plain(self.plan)}


def columns_of(space: "Space") -> list[Column]:
    """A column for each parameter."""
    return [Column(key, unit, "value") for key, unit in zip(space.keys, space.units, strict=True)]
