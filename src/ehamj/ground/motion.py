"""What ground motion is: a function of time that gives every mount its motion."""

from abc import abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from ehamj.plant.axes import DOFS
from ehamj.plant.levers import levers
from ehamj.settings import Settings
from ehamj.signals import Array, Signal


class GroundSample(NamedTuple):
    """Motion of the ground below each mount, and upstream behind them where a sensor stands there, shape
    (n, mount, axis): [m], [m/s], [m/s²]."""

    displacement: Array
    velocity: Array
    acceleration: Array

    def below(self, mounts: int) -> "GroundSample":
        """The motion below so many mounts alone."""
        return GroundSample(*(part[:, :mounts] for part in self))


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

    @property
    def usable_from(self) -> float:
        """Frequency below which the motion is not known: a high-pass has taken it [Hz]."""
        ...


@dataclass(frozen=True)
class Start:
    """What a ground needs to know to become motion: which mounts stand where, how long, from which seed."""

    mounts: tuple[str, ...]
    """Their names."""
    positions: Array
    """Mount positions x, y, z, shape (mount, 3) [m]; where a sensor stands upstream, last."""
    duration: float
    """Simulated time that the motion must cover [s]."""
    seed: int
    upstream: bool = False
    """Whether the last position is that of a sensor upstream, which is no mount."""
    part: tuple[int, ...] = ()
    """Number of the part of a combined ground, so that random parts differ."""


class GroundSettings(Settings):
    """What a user writes in [ground] of some ``kind``; ``ehamj.ground.kinds`` lists them."""

    kind: str

    def named_mounts(self) -> Iterable[tuple[str, str]]:
        """Mounts that it calls by name, each with the key within [ground] that does."""
        return ()

    @abstractmethod
    def motion(self, start: Start) -> Motion:
        """Build the motion.

        Raises:
            ValueError: naming the key, where a file or a setting does not allow it.
        """


@dataclass(frozen=True)
class Slab:
    """A rigid slab with up to six degrees of freedom, small rotations about the mount plane's centre.

    ``signals`` maps a degree of freedom (x, y, z [m], rx, ry, rz [rad]) to its signal; the others rest.
    """

    positions: Array
    signals: dict[str, Signal]
    notes: tuple[str, ...] = ()
    usable_to: float = float("inf")
    usable_from: float = 0.0

    @property
    def at_rest(self) -> bool:
        return not self.signals

    def sample(self, time: Array) -> GroundSample:
        dofs = np.zeros((3, time.size, len(DOFS)))
        for name, signal in self.signals.items():
            dofs[:, :, DOFS.index(name)] = signal.sample(time)
        mounts = dofs @ levers(self.positions).T  # many times faster than einsum
        return GroundSample(*mounts.reshape(3, time.size, len(self.positions), 3))


@dataclass(frozen=True)
class Combined:
    """The sum of several motions, ``factor`` times as large; ``note`` says what it is."""

    parts: tuple[Motion, ...]
    factor: float = 1.0
    note: str | None = None

    @property
    def at_rest(self) -> bool:
        return all(part.at_rest for part in self.parts)

    @property
    def notes(self) -> tuple[str, ...]:
        said = tuple(note for part in self.parts for note in part.notes)
        return said if self.note is None else (self.note, *dict.fromkeys(said))

    @property
    def usable_to(self) -> float:
        return min(part.usable_to for part in self.parts)

    @property
    def usable_from(self) -> float:
        return max(part.usable_from for part in self.parts)

    def sample(self, time: Array) -> GroundSample:
        total = self.parts[0].sample(time)
        for part in self.parts[1:]:
            for whole, own in zip(total, part.sample(time), strict=True):
                np.add(whole, own, out=whole)
        return total if self.factor == 1 else GroundSample(*(self.factor * part for part in total))
