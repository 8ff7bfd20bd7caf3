"""Plans of which a global sensitivity analysis makes its measures (SALib): paths of Morris, groups of Saltelli."""

from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.arrays import Array
from ehamj.campaign.correlations import check_independent
from ehamj.campaign.plans.draws import LONGEST, power_of_two
from ehamj.campaign.plans.plan import Batches, Goals, Plan

if TYPE_CHECKING:
    from ehamj.campaign.parameters import Space

MOST_PATHS: Final = 100_000


def unit_cube(keys: tuple[str, ...]) -> dict[str, Any]:
    """The unit cube, as SALib describes parameters."""
    return {"num_vars": len(keys), "names": list(keys), "bounds": [[0.0, 1.0]] * len(keys)}


class Morris(Plan):
    """Paths through the space, each of which changes every parameter once (Morris, 1991): which ones matter at all, for
    few designs. A distribution without limits is walked from −3 to 3 standard deviations."""

    kind: Literal["morris"]
    package: ClassVar[str] = "SALib"
    paths: int = Field(20, ge=2, le=MOST_PATHS, description="paths; each has one design more than there are parameters")
    levels: int = Field(4, ge=2, le=100, description="values of each parameter, an even number")
    seed: int = Field(0, ge=0, description="seed of the draws")

    @model_validator(mode="after")
    def _even(self) -> Self:
        if self.levels % 2:
            raise ValueError(f"levels = {self.levels}: must be even, such as {self.levels + 1}")
        return self

    def count(self, space: "Space") -> int:
        return self.paths * (len(space.keys) + 1)

    def batches(self, space: "Space", goals: Goals) -> Batches:
        check_independent(space, self.kind)
        low, high = np.array([one.spread.edges() for one in space.parameters]).T
        yield low + (high - low) * self.points(space.keys)

    def points(self, keys: tuple[str, ...]) -> Array:
        """Its designs (design, parameter) on the unit cube, path by path: what its analysis counts with."""
        from SALib.sample import morris

        rng = np.random.default_rng(self.seed)
        found = morris.sample(unit_cube(keys), self.paths, self.levels, seed=rng)
        return np.clip(np.asarray(found, float), 0.0, 1.0)  # SALib leaves 1 + 2e-16


class Sobol(Plan):
    """Groups of designs that share values with each other (Saltelli): which share of a merit's variance each parameter
    has, alone and with the others."""

    kind: Literal["sobol"]
    package: ClassVar[str] = "SALib"
    groups: int = Field(
        512, ge=2, le=LONGEST, description="groups, a power of two; each has two designs more than parameters"
    )
    second_order: bool = Field(False, description="pairs of parameters as well, for about twice the designs")
    seed: int = Field(0, ge=0, description="seed of the scrambling")

    @model_validator(mode="after")
    def _even(self) -> Self:
        power_of_two(self.groups, "groups")
        return self

    def count(self, space: "Space") -> int:
        return self.groups * self.size(len(space.keys))

    def size(self, parameters: int) -> int:
        """Designs of a group."""
        return (2 * parameters if self.second_order else parameters) + 2

    def batches(self, space: "Space", goals: Goals) -> Batches:
        """Group by group: A, A with one value of B each, (B with one of A each,) B."""
        from SALib.sample import sobol

        check_independent(space, self.kind)
        rng = np.random.default_rng(self.seed)
        yield sobol.sample(unit_cube(space.keys), self.groups, calc_second_order=self.second_order, seed=rng)
