"""All forces on the machine as one wrench at its centre of gravity."""

from dataclasses import dataclass

import numpy as np

from ehamj.plant.axes import DOFS
from ehamj.plant.levers import lever
from ehamj.signals import Array, Signal


@dataclass(frozen=True)
class Load:
    """Force [N] and moment [N m] at the centre of gravity, in the axes of the ground: a sum of patterns times signals.

    ``patterns`` (forces, 6) per newton of each signal. Directions stay those of the ground; the machine's own turning,
    some µrad, is left out.
    """

    patterns: Array
    signals: tuple[Signal, ...]
    longest_step: float = float("inf")
    """Step with which the shortest of them is still followed [s]."""

    @property
    def absent(self) -> bool:
        """Whether there is none."""
        return not self.signals

    def sample(self, time: Array, left: bool = False) -> tuple[Array, Array]:
        """The wrench and its rate at ``time`` [s], (n, 6) each; ``left``: limit from the left where it jumps."""
        value, slope = np.zeros((2, time.size, len(DOFS)))
        for pattern, signal in zip(self.patterns, self.signals, strict=True):
            sample = signal.sample(time, left)
            value += np.multiply.outer(sample.value, pattern)
            slope += np.multiply.outer(sample.slope, pattern)
        return value, slope


NO_LOAD = Load(np.zeros((0, len(DOFS))), ())


def pattern(direction: Array, point: Array, cg: Array) -> Array:
    """Wrench at the centre of gravity of a unit force at ``point``, (6,): d and (r − r_CG) × d."""
    return np.asarray(lever(point - cg).T @ direction)
