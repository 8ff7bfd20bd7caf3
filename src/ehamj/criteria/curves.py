"""What the norms share: a limit per class, axis and third-octave band, and the decision which class is met."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ehamj.estimate.bands import Band, bands

Array = NDArray[np.float64]
Quantity = Literal["displacement", "velocity", "acceleration"]

ORDERS: dict[Quantity, int] = {"displacement": -1, "velocity": 0, "acceleration": 1}
"""Order of each quantity as a time derivative of velocity."""

CANDIDATES = bands(0.5, 200.0)
"""Bands in which any norm here has a limit."""


@dataclass(frozen=True)
class Limit:
    """Largest RMS allowed in a band: of displacement [m], velocity [m/s] or acceleration [m/s²]."""

    value: float
    quantity: Quantity = "velocity"

    def as_velocity(self, band: Band) -> float:
        """The same limit for a line at the band's nominal centre [m/s], as charts of criteria draw it."""
        return self.value / float(2 * np.pi * band.nominal) ** ORDERS[self.quantity]


def rounded(value: float) -> float:
    """The double nearest to a limit's decimal value, so that 50e-6·8/5 is the 80e-6 that people write."""
    return float(f"{value:.12g}")


@dataclass(frozen=True)
class Norm:
    """A criterion: its classes, coarsest first, and the limit of each, by class, axis (x, y, z) and band.

    The rule gives None where the norm says nothing.
    """

    title: str
    classes: tuple[str, ...]
    rule: Callable[[str, str, Band], Limit | None]
    base: str | None = None
    """Class whose curve a factor counts from, for a norm that thinks in multiples of one curve."""

    def limit(self, name: str, axis: str, band: Band) -> Limit | None:
        """Limit of a class along an axis in a band, None where the norm says nothing."""
        return _table(self, name, axis).get(band)

    def needed(self, axis: str) -> tuple[Band, ...]:
        """The bands that must be known for a decision: those in which any class has a limit."""
        return tuple(band for band in CANDIDATES if any(self.limit(name, axis, band) for name in self.classes))


@cache
def _table(norm: Norm, name: str, axis: str) -> dict[Band, Limit]:
    found = {band: norm.rule(name, axis, band) for band in CANDIDATES}
    return {band: limit for band, limit in found.items() if limit is not None}


@dataclass(frozen=True)
class Verdict:
    """The strictest class met in the bands that are known (None: not even the coarsest).

    A level exactly at its limit meets the class. ``margin_db`` is what the class met leaves in its deciding band, the
    one with the least; None where nothing moves or no class is met. ``excess_db`` is by how much the next stricter
    class is exceeded at worst, in ``next_band``.
    """

    met: str | None
    deciding_band: str | None
    margin_db: float | None
    undecided: tuple[str, ...]
    """Bands of the criterion in which the level is not known."""
    next_class: str | None = None
    next_band: str | None = None
    excess_db: float | None = None
    factor: float | None = None
    """Largest level over the norm's base curve, for a norm that has one."""


def judge(norm: Norm, axis: str, levels: Mapping[Quantity, Array], measured: tuple[Band, ...]) -> Verdict:
    """The class that band levels meet.

    Args:
        norm: the criterion.
        axis: x, y or z.
        levels: RMS per band of each quantity that the norm limits (SI), NaN where unknown.
        measured: the bands.
    """
    of_band = {
        band: {quantity: float(values[row]) for quantity, values in levels.items() if np.isfinite(values[row])}
        for row, band in enumerate(measured)
    }

    def shares(name: str) -> dict[Band, tuple[bool, float]]:
        """Whether the limit is kept, and the level over it, per band that is known and limited."""
        return {
            band: (known[limit.quantity] <= limit.value, known[limit.quantity] / limit.value)
            for band, known in of_band.items()
            if (limit := norm.limit(name, axis, band)) is not None and limit.quantity in known
        }

    needed = norm.needed(axis)
    undecided = tuple(band.name for band in needed if not of_band.get(band))
    met, deciding, margin = None, None, None
    following, following_band, excess = None, None, None
    for name in norm.classes:
        found = shares(name)
        if not found:
            break
        worst = max(found, key=lambda band: found[band][1])
        kept, share = all(kept for kept, _ in found.values()), found[worst][1]
        if not kept:
            following, following_band, excess = name, worst.name, _decibel(share)
            deciding = deciding or worst.name
            break
        met, deciding = name, worst.name
        margin = -_decibel(share) if share > 0 else None
    base = shares(norm.base) if norm.base else {}
    factor = max((share for _, share in base.values()), default=None)
    return Verdict(met, deciding, margin, undecided, following, following_band, excess, factor)


def _decibel(ratio: float) -> float:
    return float(20 * np.log10(ratio)) + 0.0
