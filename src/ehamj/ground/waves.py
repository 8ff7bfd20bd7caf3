"""Floors that differ from mount to mount: plane waves, partial coherence, and a motion of its own for each mount."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from pydantic import Field

from ehamj.ground.motion import GroundSample, Motion, Slab, Start
from ehamj.plant.axes import AXES
from ehamj.settings import Positive, Settings
from ehamj.signals import Array, Sample, Signal, faded


class Wave(Settings):
    """A plane wave that passes below the machine."""

    speed: Positive = Field(200.0, description="apparent wave speed c [m/s]")
    direction: float = Field(0.0, description="direction of travel, from +x towards +y [deg]")

    def delays(self, positions: Array) -> Array:
        """Arrival at each mount after the mount plane's centre, r·n/c [s]."""
        angle = np.radians(self.direction)
        return positions[:, :2] @ np.array([np.cos(angle), np.sin(angle)]) / self.speed


class Coherence(Settings):
    """How alike the floor is at two mounts: the coherency's magnitude is exp(−(γ ω d/V_s)²).

    Luco and Wong, *Response of a rigid foundation to a spatially random ground motion*, Earthquake Eng. Struct. Dyn.
    14 (1986), 891-908. It is a magnitude: `scipy.signal.coherence` estimates its square. A wave adds the phase.
    """

    gamma: float = Field(
        0.2, ge=0, description="incoherence γ [-]; Luco and Wong consider 0.1 to 0.5, 0.2 is assumed; 0: fully coherent"
    )
    shear_speed: Positive = Field(200.0, description="shear wave speed of the soil V_s [m/s] (assumed: stiff soil)")

    def magnitude(self, frequency: Array, distance: Array) -> Array:
        """Coherency magnitude at ``frequency`` [Hz] between points ``distance`` [m] apart, broadcast."""
        return np.exp(-((self.gamma * 2.0 * np.pi * frequency * distance / self.shear_speed) ** 2))

    def factor(self, frequency: Array, positions: Array) -> Array:
        """Factor A of the coherency matrix A·Aᵀ at each frequency, shape (n, mount, mount).

        A times as many independent unit lines as there are mounts gives lines that are coherent as stated. It comes
        from eigenvalues, which stays exact where the matrix is singular (mounts that move as one); the strongest
        pattern, in which all mounts move alike, is the last column, with positive sign.

        Args:
            frequency: shape (n,) [Hz].
            positions: of the mounts, shape (mount, 3) [m].
        """
        distance = np.linalg.norm(positions[:, None] - positions, axis=2)
        values, vectors = np.linalg.eigh(self.magnitude(frequency[:, None, None], distance))
        vectors *= np.where(vectors.sum(axis=1, keepdims=True) < 0, -1.0, 1.0)
        return vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :]


@dataclass(frozen=True)
class PerMount:
    """Translations of the ground, each mount with signals of its own.

    ``signals`` maps x, y, z to the motion [m] at each mount.
    """

    signals: dict[str, tuple[Signal, ...]]
    mounts: int
    notes: tuple[str, ...] = ()
    usable_to: float = float("inf")
    usable_from: float = 0.0

    @property
    def at_rest(self) -> bool:
        return not self.signals

    @cached_property
    def _placed(self) -> list[tuple[int, int, Signal]]:
        return [(m, AXES.index(axis), own) for axis, signals in self.signals.items() for m, own in enumerate(signals)]

    def sample(self, time: Array) -> GroundSample:
        motion = np.zeros((3, self.mounts, len(AXES), time.size))  # written a signal at a time: time last is faster
        # What all mounts share of a long signal is at hand for about the times that are asked for at once.
        seconds = [0, *(np.flatnonzero(np.diff(np.floor(time))) + 1), time.size]
        for part in (slice(begin, end) for begin, end in pairwise(seconds)):
            for mount, axis, signal in self._placed:
                motion[:, mount, axis, part] = signal.sample(time[part])
        return GroundSample(*motion.transpose(0, 3, 1, 2))


@dataclass(frozen=True)
class Delayed:
    """A signal that comes ``delay`` [s] later (earlier, where negative)."""

    signal: Signal
    delay: float

    def sample(self, time: Array, left: bool = False) -> Sample:
        return self.signal.sample(time - self.delay, left)


def spread(
    start: Start,
    signals: Mapping[str, Signal | tuple[Signal, ...]],
    wave: Wave | None,
    fade_in: float,
    begin: float | None = None,
    notes: tuple[str, ...] = (),
    usable_to: float = float("inf"),
    usable_from: float = 0.0,
) -> Motion:
    """Motion of all mounts from signals per degree of freedom: a rigid slab, a plane wave, or motions per mount.

    Args:
        start: where the mounts are.
        signals: one signal for all mounts, or one per mount, by degree of freedom.
        wave: delays the signals from mount to mount; None: they come everywhere at once.
        fade_in: time over which the motion fades in [s], from time 0 at all mounts together, or
        begin: from the time at which a motion that begins then reaches each mount [s] (not before time 0).
        notes: see `Motion`.
        usable_to: see `Motion` [Hz].
        usable_from: likewise.

    Raises:
        ValueError: if a wave is asked to carry rotations; if a sensor stands upstream of a floor that passes as none.
    """
    if wave is None and start.upstream:
        raise ValueError(
            "sensors.upstream: this floor comes from no known side; give it a wave (ground.wave = { speed = 200.0 }, "
            "which recorded and rigid floors cannot have), or leave sensors.upstream out"
        )
    one = {dof: signal for dof, signal in signals.items() if not isinstance(signal, tuple)}
    if wave is None and len(one) == len(signals):
        moved = {dof: faded(signal, fade_in, begin or 0.0) for dof, signal in one.items()}
        return Slab(start.positions, moved, notes, usable_to, usable_from)
    turning = [dof for dof in signals if dof not in AXES]
    if turning:
        raise ValueError(f"ground.dof = {turning[0]!r}: a wave carries x, y or z; leave ground.wave out for a slab")
    delays = np.zeros(len(start.positions)) if wave is None else wave.delays(start.positions)
    placed: dict[str, tuple[Signal, ...]] = {}
    for axis, signal in signals.items():
        own = signal if isinstance(signal, tuple) else (signal,) * delays.size
        late = ((Delayed(part, float(delay)) if delay else part) for part, delay in zip(own, delays, strict=True))
        begins = np.zeros(delays.size) if begin is None else np.maximum(0.0, begin + delays)
        placed[axis] = tuple(faded(part, fade_in, float(at)) for part, at in zip(late, begins, strict=True))
    return PerMount(placed, delays.size, notes, usable_to, usable_from)
