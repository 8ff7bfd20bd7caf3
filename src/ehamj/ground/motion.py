"""What ground motion is: a function of time that gives every mount its motion."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ehamj.plant.axes import DOFS
from ehamj.signals import Signal

Array = NDArray[np.float64]


class GroundSample(NamedTuple):
    """Motion of the ground below each mount, shape (n, mount, axis): [m], [m/s], [m/s²]."""

    displacement: Array
    velocity: Array
    acceleration: Array


class Motion(Protocol):
    """Ground motion of all mounts."""

    def sample(self, time: Array) -> GroundSample:
        """The motion at ``time`` [s], shape (n,)."""
        ...

    @property
    def at_rest(self) -> bool:
        """Whether the ground never moves."""
        ...

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader of the result must know: processing steps and limits, in plain words."""
        ...

    @property
    def usable_to(self) -> float:
        """Frequency above which the motion is not known, and no statement about the machine holds [Hz]."""
        ...


@dataclass(frozen=True)
class Start:
    """What a ground needs to know to become motion: where the mounts are, how long, from which seed and folder."""

    positions: Array
    """Mount positions x, y, shape (mount, 2) [m]."""
    duration: float
    """Simulated time that the motion must cover [s]."""
    seed: int
    folder: Path
    """Folder that relative file names refer to."""
    part: tuple[int, ...] = ()
    """Number of the part of a combined ground, so that random parts differ."""


@dataclass(frozen=True)
class Slab:
    """A rigid slab with up to six degrees of freedom, small rotations about the mount plane's centre.

    ``signals`` maps a degree of freedom (x, y, z [m], rx, ry, rz [rad]) to its signal; the others rest.
    """

    positions: Array
    signals: dict[str, Signal]
    notes: tuple[str, ...] = ()
    usable_to: float = float("inf")

    @property
    def at_rest(self) -> bool:
        return not self.signals

    @cached_property
    def lever(self) -> Array:
        """Displacement of each mount and axis per degree of freedom, p + θ × r, shape (mount, axis, dof)."""
        x, y = self.positions.T
        one, zero = np.ones_like(x), np.zeros_like(x)
        rows = [[one, zero, zero, zero, zero, -y], [zero, one, zero, zero, zero, x], [zero, zero, one, y, -x, zero]]
        return np.array(rows).transpose(2, 0, 1)

    def sample(self, time: Array) -> GroundSample:
        dofs = np.zeros((3, time.size, len(DOFS)))
        for name, signal in self.signals.items():
            dofs[:, :, DOFS.index(name)] = signal.sample(time)
        mounts = dofs @ self.lever.reshape(-1, len(DOFS)).T  # many times faster than einsum
        return GroundSample(*mounts.reshape(3, time.size, len(self.positions), 3))
