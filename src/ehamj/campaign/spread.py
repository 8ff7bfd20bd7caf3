"""What a spread is: settings with a quantile function, and what several of them need."""

from abc import ABC, abstractmethod
from typing import Any, Final

import numpy as np
from pydantic import Field

from ehamj.arrays import Array
from ehamj.settings import Settings

SIGMAS: Final = 3.0
"""Deviations from the mean to a limit of a tolerance that is drawn normally, and to an end of a normal without one."""

TAIL: Final = 1e-15
"""Share of a normal without limits beyond which nothing is drawn (8 deviations): a point of 0 or 1 has a value too."""


class SpreadSettings(Settings, ABC):
    """Base of all spreads: values by their share of the parameter's probability.

    ``own`` is the scenario's own value in all methods; None where the scenario leaves it out.
    """

    each: bool = Field(
        False,
        description="whether every isolator of a key actuators.NAME.QUANTITY has a value by itself (a parameter each)",
    )

    @abstractmethod
    def quantiles(self, points: Array, own: Any) -> Array:
        """Values at shares of the probability in [0, 1], of any shape; they rise with the share."""

    def whole(self, points: Array, own: Any) -> Array:
        """The same for a parameter that is an integer."""
        return np.rint(self.quantiles(points, own))

    def cells(self, own: Any) -> int | None:
        """How many values there are, all equally likely; None where they are too many to count."""
        return None

    def edges(self) -> tuple[float, float]:
        """Shares at which grids and paths end."""
        return 0.0, 1.0

    def check(self, own: Any) -> None:
        """Refuse a scenario's value that this does not suit.

        Raises:
            ValueError: saying what is allowed.
        """


def normal_within(points: Array, mean: float, deviation: float, low: float, high: float) -> Array:
    """Quantiles of a normal within limits, each counted from the tail that is nearer: to 1e-9 of the deviation."""
    from scipy.special import ndtr, ndtri

    a, b = (low - mean) / deviation, (high - mean) / deviation
    points = np.clip(points, TAIL if low == -np.inf else 0.0, 1.0 - TAIL if high == np.inf else 1.0)
    mass = ndtr(-a) - ndtr(-b) if a > 0.0 else ndtr(b) - ndtr(a)
    below, above = ndtr(a) + points * mass, ndtr(-b) + (1.0 - points) * mass
    scores = np.where(below < 0.5, ndtri(below), -ndtri(above))
    return np.clip(mean + deviation * scores, low, high)


def check_rising(low: float, high: float) -> None:
    if not low < high:
        raise ValueError(f"low = {low:g}: must be below high = {high:g}")


def is_whole(own: Any) -> bool:
    return isinstance(own, int) and not isinstance(own, bool)


def check_number(own: Any, instead: str) -> None:
    if not isinstance(own, int | float) or isinstance(own, bool) or not np.isfinite(own):
        value = "leaves it out" if own is None else f"has {own!r}"
        raise ValueError(f"must be about a finite number, and the scenario {value}: state {instead}")
