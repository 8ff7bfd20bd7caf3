"""Plans that fill the space of parameters: at random, in strata, or as evenly as a sequence can."""

from typing import TYPE_CHECKING, Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.campaign.plans.plan import Batches, Goals, Plan

if TYPE_CHECKING:
    from ehamj.campaign.parameters import Space

MOST: Final = 10_000_000
"""Designs that one plan may make."""
LONGEST: Final = 2**20
"""Points of a Sobol sequence that are used."""


class MonteCarlo(Plan):
    """Designs at random, each by itself: the first ones are the same however many there are."""

    drawn = True

    kind: Literal["monte-carlo"]
    number: int = Field(ge=1, le=MOST, description="designs")
    seed: int = Field(0, ge=0, description="seed of the draws")

    def count(self, space: "Space") -> int:
        return self.number

    def batches(self, space: "Space", goals: Goals) -> Batches:
        yield np.random.default_rng(self.seed).random((self.number, len(space.keys)))


class LatinHypercube(Plan):
    """Designs at random of which each has its own stratum of every parameter (McKay, Beckman and Conover, 1979); of
    correlated parameters the first has."""

    drawn = True

    kind: Literal["latin-hypercube"]
    number: int = Field(ge=2, le=MOST, description="designs")
    seed: int = Field(0, ge=0, description="seed of the draws")

    def count(self, space: "Space") -> int:
        return self.number

    def batches(self, space: "Space", goals: Goals) -> Batches:
        from scipy.stats import qmc

        yield qmc.LatinHypercube(len(space.keys), rng=np.random.default_rng(self.seed)).random(self.number)


def power_of_two(number: int, key: str) -> int:
    """A number that is a power of two, as a Sobol sequence needs to be even.

    Raises:
        ValueError: naming the powers next to it.
    """
    if number & (number - 1):
        below = 1 << (number.bit_length() - 1)
        raise ValueError(f"{key} = {number}: must be a power of two, such as {below} or {2 * below}")
    return number


class SobolSequence(Plan):
    """Designs as even as a Sobol sequence, scrambled by the seed (Owen); so many as a power of two."""

    drawn = True

    kind: Literal["sobol-sequence"]
    number: int = Field(ge=2, le=LONGEST, description="designs, a power of two")
    seed: int = Field(0, ge=0, description="seed of the scrambling")

    @model_validator(mode="after")
    def _even(self) -> Self:
        power_of_two(self.number, "number")
        return self

    def count(self, space: "Space") -> int:
        return self.number

    def batches(self, space: "Space", goals: Goals) -> Batches:
        from scipy.stats import qmc

        yield qmc.Sobol(len(space.keys), rng=np.random.default_rng(self.seed)).random(self.number)
