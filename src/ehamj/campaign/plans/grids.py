"""Plans that go through values one by one: a grid of all, and one parameter at a time."""

from typing import TYPE_CHECKING, Literal

import numpy as np
from pydantic import Field

from ehamj.arrays import Array
from ehamj.campaign.correlations import check_independent
from ehamj.campaign.plans.plan import Batches, Goals, Plan
from ehamj.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from ehamj.campaign.parameters import Space


class _Levels(Plan):
    levels: int = Field(
        3, ge=2, le=1000, description="values of each parameter, its ends among them; a list has all of its own"
    )
    levels_of: dict[str, int] = Field(default_factory=dict, description="the same for single parameters, by key")

    def points_of(self, space: "Space") -> list[Array]:
        """Points of each parameter's values.

        Raises:
            InputError: if parameters are correlated, or none is what ``levels_of`` names.
        """
        check_independent(space, self.kind)
        for key, number in self.levels_of.items():
            stated = tuple(dict.fromkeys(one.stated for one in space.parameters))
            if key not in stated:
                near = did_you_mean(key, stated)
                raise InputError(f"plan.levels_of: {key!r} does not vary; {near}must be one of {', '.join(stated)}")
            if number < 2:
                raise InputError(f"plan.levels_of.{key} = {number}: must be at least 2")
        return [one.levels(self.levels_of.get(one.stated, self.levels)) for one in space.parameters]


class Grid(_Levels):
    """Every value of every parameter with all values of the others."""

    kind: Literal["grid"]

    def count(self, space: "Space") -> int:
        count = 1
        for points in self.points_of(space):
            count *= len(points)
        return count

    def batches(self, space: "Space", goals: Goals) -> Batches:
        """The last parameter changes fastest."""
        axes = np.meshgrid(*self.points_of(space), indexing="ij")
        yield np.stack([axis.ravel() for axis in axes], axis=1)


class OneAtATime(_Levels):
    """The scenario as it is, and each parameter's values with all others as they are."""

    kind: Literal["one-at-a-time"]

    def count(self, space: "Space") -> int:
        return len(self._designs(space))

    def batches(self, space: "Space", goals: Goals) -> Batches:
        """The scenario's own design first, then parameter by parameter; a value that is the scenario's own makes no
        design beside it."""
        yield self._designs(space)

    def _designs(self, space: "Space") -> Array:
        designs = [np.full(len(space.keys), np.nan)]
        for k, (one, points) in enumerate(zip(space.parameters, self.points_of(space), strict=True)):
            for point, value in zip(points, one.values(points), strict=True):
                if value != one.own:
                    designs.append(designs[0].copy())
                    designs[-1][k] = point
        return np.array(designs)
