"""Inputs at start, middle and end of many steps at once, and what they do there."""

from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.memory import Cubic
from ehamj.mujoco.unpacking import hermite

STAGES: Final = (0.0, 0.5, 1.0)
"""Fractions of a step at which the integrator asks."""


def staged(start: Array, end: Array) -> tuple[Array, Array]:
    """Value and slope·step of cubics at start, middle and end of each step, (step, 3, …) each; given are value and
    slope·step at both ends, (step, …, 2 or more) each."""
    both: Any = (part[..., order] for part in (start, end) for order in range(2))
    cubic = Cubic(*both)
    value, slopes = zip(*(hermite.py_func(cubic, s) for s in STAGES), strict=True)
    return np.stack(value, axis=1), np.stack(slopes, axis=1)


def weights(by_value: Array, by_rate: Array, orders: int) -> Array:
    """What value and slope·step of cubics at each end of a step do at the two stages that the end reaches, middle
    among them: (end, cubic·order, stage·effect), as `acting` takes them.

    Args:
        by_value: effect of each cubic per value (…, effect).
        by_rate: per slope·step.
        orders: how many values each cubic has at an end: more than two act on nothing.
    """
    value, rate = (part.reshape(-1, part.shape[-1]) for part in (by_value, by_rate))
    units = np.eye(4).reshape(4, 2, 2).swapaxes(0, 1)
    # Of unit value and slope (order) at start and end: their shares at the stages.
    values, rates = (part.reshape(2, 2, 3) for part in staged(*units))
    found = np.zeros((2, value.shape[0], orders, 2, value.shape[1]))
    for end, stages in enumerate((slice(0, 2), slice(1, 3))):
        of_value, of_rate = values[end][:, stages], rates[end][:, stages]
        found[end, :, :2] = np.einsum("os,ke->kose", of_value, value) + np.einsum("os,ke->kose", of_rate, rate)
    return found.reshape(2, value.shape[0] * orders, 2 * value.shape[1])


def acting(start: Array, end: Array, weighed: Array) -> Array:
    """What cubics do at start, middle and end of each step, (step, 3, effect), as products of whole arrays.

    Args:
        start: value, slope·step and more of each cubic at the start of each step, (step, …, order).
        end: the same at its end.
        weighed: their `weights`.
    """
    steps, effects = start.shape[0], weighed.shape[-1] // 2
    found = np.empty((steps, 3, effects))
    ahead, behind = (part.reshape(steps, -1) @ own for part, own in zip((start, end), weighed, strict=True))
    found[:, 0], found[:, 2] = ahead[:, :effects], behind[:, effects:]
    np.add(ahead[:, effects:], behind[:, :effects], out=found[:, 1])
    return found
