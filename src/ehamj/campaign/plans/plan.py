"""What a plan is: settings, and a generator of batches of designs that is told what they came out with."""

from abc import ABC, abstractmethod
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from ehamj.arrays import Array
from ehamj.settings import Settings

if TYPE_CHECKING:
    from ehamj.campaign.parameters import Space


@dataclass(frozen=True)
class Goals:
    """What a search looks for: the columns of what it is told.

    ``objectives`` are names of merits with +1 where less is better and −1 where more is; ``constraints`` are
    (merit, at_least, at_most), None where there is no bound.
    """

    objectives: Sequence[tuple[str, float]] = ()
    constraints: Sequence[tuple[str, float | None, float | None]] = ()


@dataclass(frozen=True)
class Told:
    """What a batch came out with: ``objectives`` (design, objective), all to be small, and ``violations``
    (design, constraint), 0 or less where met; NaN of a design that failed."""

    objectives: Array
    violations: Array


def excess(values: Array, at_least: float | None, at_most: float | None) -> Array:
    """By how much values miss bounds, 0 or less where they keep them; NaN of values that are not known."""
    beyond = np.full(np.shape(values), -np.inf)
    if at_least is not None:
        beyond = np.maximum(beyond, at_least - values)
    if at_most is not None:
        beyond = np.maximum(beyond, values - at_most)
    return np.where(np.isnan(values), np.nan, beyond)


Batches = Generator[Array, Told, None]
"""Yields points (design, parameter) of the unit cube, [0, 1], NaN where a value is the scenario's own, and is sent what
they came out with."""


class Plan(Settings, ABC):
    """Base of all plans; each has a ``kind`` of its own and is registered in `ehamj.campaign.plans.kinds`."""

    kind: str
    drawn: ClassVar[bool] = False
    """Whether its designs stand for machines that will be built, so that shares and correlations of them mean
    something."""
    package: ClassVar[str] = ""
    """What it needs of the packages that are extras of ehamj (`ehamj.extras.EXTRAS`)."""

    @abstractmethod
    def count(self, space: "Space") -> int:
        """Designs that it makes, all batches together."""

    @abstractmethod
    def batches(self, space: "Space", goals: Goals) -> Batches:
        """Designs batch by batch, the same whenever it is asked with the same settings: a study resumes by asking
        again and answering from its store.

        Raises:
            InputError: if the parameters or the goals do not suit it.
        """
