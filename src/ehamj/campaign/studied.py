"""A study as far as it has come: its file, its designs, and which of them are good."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.campaign.best import best_of, front_of, losing_nothing
from ehamj.campaign.names import short_names, worded
from ehamj.campaign.plans.plan import excess as bounds_excess
from ehamj.campaign.standing import OWN
from ehamj.campaign.store import cell_of

if TYPE_CHECKING:
    from pandas import DataFrame, Series

    from ehamj.campaign.file import Limit, StudyFile
else:
    DataFrame = Series = Any  # imported with the first design

Row = dict[str, Any]
"""A design by the names of its columns."""
SEARCH, NAMED, TOLERANCE, CONFIRM = "search", OWN, "tolerance", "confirm"
"""Stages of a study's designs."""
AS_IT_IS: Final = "as it is"
"""Name of the scenario's own design."""


@dataclass(frozen=True)
class Studied:
    """The designs of a study, and what they were to be.

    Rows are designs as `ehamj.campaign.tables.frame` has them, the number a column like any other: number, stage,
    parent, status, reason, seconds, a column for each parameter and each merit; NaN where a design has none.
    """

    file: "StudyFile"
    designs: DataFrame
    parameters: tuple[str, ...]
    """Keys of what the plan varies."""
    units: Mapping[str, str]
    """Unit of each value and merit, by name."""
    planned: int
    """Designs that the study makes at most, all stages together."""
    complete: bool = True
    """Whether all that there will be are there."""

    @cached_property
    def merits(self) -> tuple[str, ...]:
        """Names of all merits, whichever stage asks for them."""
        stages = (self.file.tolerances, self.file.confirm)
        more = [name for stage in stages if stage is not None for name in stage.merits or ()]
        return tuple(dict.fromkeys((*self.file.wanted, *more)))

    def stage(self, name: str) -> DataFrame:
        """Designs of one stage, in order of their numbers."""
        return self.designs[self.designs["stage"] == name].sort_values("number").reset_index(drop=True)

    @property
    def first(self) -> int:
        """Number of the plan's first design."""
        return 1 + len(self.file.named)

    @cached_property
    def search(self) -> DataFrame:
        """The plan's own designs."""
        return self.stage(SEARCH)

    @cached_property
    def done(self) -> DataFrame:
        """Those of them that have merits."""
        return self.search[self.search["status"] == "done"].reset_index(drop=True)

    @cached_property
    def named(self) -> dict[str, Row]:
        """Designs with a name of their own, to compare with, as far as they are done."""
        rows = rows_of(self.stage(NAMED))
        names = (AS_IT_IS, *self.file.named)
        return {name: row for name, row in zip(names, rows, strict=False) if row["status"] == "done"}

    @cached_property
    def best(self) -> list[int]:
        """Rows of `search` of the best designs that keep all limits, the best first; none without objectives."""
        return best_of(self.objectives(self.search), self.good(self.search), self.file.best, self._named_objectives)

    @property
    def _named_objectives(self) -> Array:
        """Objectives of the designs that the file names, (named, objective)."""
        return self.objectives(self.stage(NAMED).query("number > 0"))

    @cached_property
    def ahead(self) -> int:
        """How many designs of the front lose nothing beside those that the file names; 0 where it names none."""
        return int(losing_nothing(self.objectives(self.search.iloc[self.front]), self._named_objectives).sum())

    @cached_property
    def front(self) -> list[int]:
        """Rows of `search` on the Pareto front of the designs that keep all limits, by the first objective; none
        without several objectives."""
        if len(self.file.objectives) < 2:
            return []
        objectives = np.where(self.good(self.search)[:, None], self.objectives(self.search), np.nan)
        rows = np.flatnonzero(front_of(objectives))
        return [int(row) for row in rows[np.argsort(objectives[rows, 0], kind="stable")]]

    @cached_property
    def failed(self) -> DataFrame:
        """Designs of any stage that have no merits."""
        return self.designs[self.designs["status"] == "failed"]

    def design(self, row: int) -> Row:
        """A row of `search`."""
        return rows_of(self.search.iloc[[row]])[0]

    def children(self, number: int, stage: str) -> DataFrame:
        """Variations of a design in a stage."""
        found = self.stage(stage)
        return found[found["parent"] == number].reset_index(drop=True)

    def good(self, designs: DataFrame) -> NDArray[np.bool_]:
        """Which designs are done and keep every limit."""
        kept = np.asarray(designs["status"] == "done")
        for name, limit in self.file.limits.items():
            kept = kept & meets(designs[name], limit)
        return kept

    def objectives(self, designs: DataFrame) -> Array:
        """Objectives of designs (design, objective), all to be small; NaN of those that failed."""
        signs = [sign for _, sign in self.file.goals.objectives]
        return np.asarray(designs[list(self.file.objectives)].to_numpy(float) * signs)

    @cached_property
    def short(self) -> dict[str, str]:
        """What each parameter and merit is called on a page."""
        return short_names([*self.parameters, *self.merits])

    @property
    def numeric(self) -> list[str]:
        """Parameters whose values are numbers, and not all the same."""
        return [
            key
            for key in self.parameters
            if self.done[key].map(lambda value: isinstance(value, int | float)).all() and self.done[key].nunique() > 1
        ]

    def unit(self, name: str) -> str:
        """Unit of a parameter or merit."""
        return self.units.get(name, "1")

    def said(self, name: str, value: Any) -> str:
        """A parameter or merit with its value, in words."""
        return f"{self.short[name]} {worded(value, self.unit(name))}"

    def limit_said(self, name: str) -> str:
        """What a merit must keep, in words that begin with its name."""
        return f"{self.short[name]} {self.bounds_said(name)}"

    def bounds_said(self, name: str) -> str:
        """The same without its name."""
        limit, unit = self.file.limits[name], self.unit(name)
        parts = [
            f"{words} {worded(bound, unit, 0)}"
            for words, bound in (("at least", limit.at_least), ("at most", limit.at_most))
            if bound is not None
        ]
        return " and ".join(parts)


def studied_of(
    file: "StudyFile",
    designs: DataFrame,
    nominal: Mapping[str, Any],
    planned: int,
    complete: bool = True,
    named: Mapping[int, Mapping[str, Any]] = MappingProxyType({}),
) -> Studied:
    """A study from the frame of its store (`ehamj.campaign.tables.frame`).

    Args:
        file: the study's file.
        designs: the frame.
        nominal: the scenario's own value of each parameter, which designs have that state no other; None where it has
            none.
        planned: designs that the study makes at most.
        complete: whether all that there will be are there.
        named: the same of designs that differ from the scenario in other keys, and so in these too, such as by a
            preset; by their number.
    """
    units = designs.attrs["units"]
    found = designs.reset_index()
    own = [named.get(number, named.get(parent, nominal)) for number, parent in zip(*_relatives(found), strict=True)]
    for key in nominal:
        known = found[key].notna()
        if not known.all():
            cells = zip(found[key], known, own, strict=True)
            found[key] = [value if there else cell_of(other.get(key)) for value, there, other in cells]
    return Studied(file, found, tuple(nominal), units, planned, complete)


def _relatives(designs: DataFrame) -> tuple[list[int], list[int]]:
    """Numbers of designs and of their parents, −1 where there is none."""
    return designs["number"].tolist(), designs["parent"].fillna(-1).astype(int).tolist()


def rows_of(designs: DataFrame) -> list[Row]:
    """Designs one by one."""
    return [{str(name): value for name, value in row.items()} for row in designs.to_dict("records")]


def meets(values: "Series[Any]", limit: "Limit") -> NDArray[np.bool_]:
    """Which values keep a limit; NaN does not."""
    return excess(np.asarray(values, float), limit) <= 0.0


def excess(values: Array, limit: "Limit") -> Array:
    """By how much values miss a limit, 0 or less where they keep it; endless where there is none."""
    beyond = bounds_excess(values, limit.at_least, limit.at_most)
    return np.where(np.isnan(beyond), np.inf, beyond)
