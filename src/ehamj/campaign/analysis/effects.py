"""What one parameter does alone: from designs in which one value differs from a common one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ehamj.arrays import Array


@dataclass(frozen=True)
class Effect:
    """A parameter by itself: its ``values`` in rising order where they are numbers, the common ``own`` among them, and
    the ``merit`` (value,) of each; NaN of a design that failed."""

    key: str
    own: Any
    values: tuple[Any, ...]
    merit: Array

    @property
    def change(self) -> Array:
        """Of the merit against that with the own value (value,), in its unit."""
        return self.merit - self.merit[self.values.index(self.own)]

    @property
    def reach(self) -> float:
        """Largest change less the smallest; NaN where nothing is known."""
        known = self.change[np.isfinite(self.change)]
        return float(np.ptp(known)) if known.size else np.nan

    @property
    def slope(self) -> float:
        """Relative sensitivity d ln f/d ln p at the own value [-]: per cent of the merit by per cent of the parameter.

        Of the next values to both sides, by a difference of second order in the logarithms, or to one side where there
        is no other; where a number is not positive, of the numbers themselves. NaN of what is no number, or zero.
        """
        if not _numbers(self.values):
            return np.nan
        at = self.values.index(self.own)
        near = slice(max(at - 1, 0), at + 2)
        p, f = np.array(self.values[near], float), self.merit[near]
        known, at = np.isfinite(f), min(at, 1)
        if not known[at] or known.sum() < 2 or p[at] == 0.0 or f[at] == 0.0:
            return np.nan
        own_p, own_f, p, f = p[at], f[at], p[known], f[known]
        if (p > 0.0).all() and (f > 0.0).all():
            return _derivative(np.log(p / own_p), np.log(f / own_f))
        return _derivative(p - own_p, f - own_f) * own_p / own_f


def _numbers(values: Sequence[Any]) -> bool:
    return all(isinstance(one, int | float) and not isinstance(one, bool) and np.isfinite(one) for one in values)


def _same(one: Any, other: Any) -> bool:
    """Whether two values are; NaN stands for one that is left out, in both."""
    return bool(one == other or (one != one and other != other))


def _derivative(step: Array, change: Array) -> float:
    """Of values about zero, where both vanish, to one side or to both."""
    step, change = step[step != 0.0], change[step != 0.0]
    if step.size == 1:
        return float(change[0] / step[0])
    ratio = change / step
    return float((step[1] * ratio[0] - step[0] * ratio[1]) / (step[1] - step[0]))


def one_at_a_time(keys: Sequence[str], values: Sequence[Sequence[Any]], merit: Array) -> list[Effect]:
    """The effect of each parameter by itself.

    Args:
        keys: parameters.
        values: of designs, (design, parameter); those of the first are common, and every other differs in one of them
            (plan `ehamj.campaign.plans.grids.OneAtATime`); those that differ in several say nothing here.
        merit: of each design (design,), NaN where it has none.
    """
    common, merit = tuple(values[0]), np.asarray(merit, float)
    differ = [
        [k for k, (one, own) in enumerate(zip(row, common, strict=True)) if not _same(one, own)] for row in values
    ]
    found = []
    for k, key in enumerate(keys):
        rows = [0, *(number for number, where in enumerate(differ) if where == [k])]
        taken = [values[row][k] for row in rows]
        if _numbers(taken):
            order = sorted(range(len(rows)), key=taken.__getitem__)
            rows, taken = [rows[n] for n in order], [taken[n] for n in order]
        found.append(Effect(key, common[k], tuple(taken), merit[rows]))
    return found
