"""What a user writes in [[force]]."""

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from ehamj.errors import InputError
from ehamj.forces.load import NO_LOAD, Load, pattern
from ehamj.forces.waveforms import Blows, Pieces, Rotating, jerk_limited, random_force
from ehamj.settings import Settings, Vector3
from ehamj.signals import Faded, Multisine, Signal, schroeder_phases

Array = NDArray[np.float64]
Positive = Annotated[float, Field(gt=0)]

PER_PERIOD = 20
"""Steps per period, or per rise, with which a force is still followed to some 1e-4."""

STREAM = 20_000
"""Keeps the random numbers of forces apart from those of the floor."""


class _Force(Settings):
    """What all of these have: a place and a direction."""

    point: str | Vector3 = Field(
        "cg", description="a name in [points], 'cg', or a place from the mount plane's centre [m]"
    )
    direction: Vector3 = Field((0.0, 0.0, 1.0), description="direction of the force (any length)")

    @model_validator(mode="after")
    def _directed(self) -> Self:
        if not any(self.direction):
            raise ValueError("direction = [0, 0, 0] must not be zero")
        return self

    @property
    def axis(self) -> Array:
        """The direction, of length one."""
        axis = np.array(self.direction)
        return np.asarray(axis / np.linalg.norm(axis))

    @property
    @abstractmethod
    def longest_step(self) -> float:
        """Step with which the force is still followed [s]."""

    @abstractmethod
    def parts(self, duration: float, random: np.random.Generator) -> list[tuple[Array, Signal]]:
        """Directions and forces along them [N]."""


class Hammer(_Force):
    """Half-sine blows, as of an instrumented hammer."""

    kind: Literal["hammer"]
    peak: float = Field(description="peak of the force [N]")
    pulse_time: Positive = Field(5e-3, description="duration of a blow [s]")
    begin: float = Field(0.1, ge=0, description="time of the first blow [s]")
    blows: int = Field(1, ge=1, description="number of blows")
    interval: Positive = Field(1.0, description="time from one blow to the next [s]")

    @model_validator(mode="after")
    def _apart(self) -> Self:
        if self.interval < self.pulse_time:
            raise ValueError(f"interval = {self.interval:g} s must be at least pulse_time = {self.pulse_time:g} s")
        return self

    @property
    def longest_step(self) -> float:
        return self.pulse_time / PER_PERIOD

    def parts(self, duration: float, random: np.random.Generator) -> list[tuple[Array, Signal]]:
        return [(self.axis, Blows(self.peak, self.pulse_time, self.begin, self.blows, self.interval))]


class AxisJerk(_Force):
    """Reaction of a moving axis, −m a, that goes back and forth with limited velocity, acceleration and jerk.

    The moving mass is part of the machine's; that its centre of gravity wanders is left out.
    """

    kind: Literal["axis-jerk"]
    moving_mass: Positive = Field(description="mass that moves [kg]")
    travel: Positive = Field(0.2, description="length of a move [m]")
    velocity: Positive = Field(0.5, description="limit of the velocity [m/s]")
    acceleration: Positive = Field(5.0, description="limit of the acceleration [m/s²]")
    jerk: Positive = Field(100.0, description="limit of the jerk [m/s³]")
    begin: float = Field(0.1, ge=0, description="time of the first move [s]")
    moves: int = Field(1, ge=1, description="number of moves; each goes the other way")
    pause: float = Field(0.5, ge=0, description="time between moves [s]")

    @property
    def longest_step(self) -> float:
        times, _ = self._profile
        return float(np.diff(times).min()) / 4.0  # straight pieces: only their corners need steps

    def parts(self, duration: float, random: np.random.Generator) -> list[tuple[Array, Signal]]:
        times, accelerations = self._profile
        length, sign = float(times[-1]) + self.pause, 1.0
        signals: list[tuple[Array, Signal]] = []
        for move in range(self.moves):
            begin = self.begin + move * length
            if begin > duration:
                break
            signals.append((self.axis, Pieces(begin + times, -sign * self.moving_mass * accelerations)))
            sign = -sign
        return signals

    @property
    def _profile(self) -> tuple[Array, Array]:
        return jerk_limited(self.travel, self.velocity, self.acceleration, self.jerk)


class Unbalance(_Force):
    """A rotor whose mass is off its axis; ``direction`` is the axis of rotation."""

    kind: Literal["unbalance"]
    moment: Positive = Field(description="mass times eccentricity [kg m]")
    speed: Positive = Field(description="turns per second [Hz]")
    run_up: float = Field(
        1.0, ge=0, description="time in which it reaches its speed from rest [s]; 0: it turns at once"
    )

    @property
    def longest_step(self) -> float:
        return 1.0 / (self.speed * PER_PERIOD)

    def parts(self, duration: float, random: np.random.Generator) -> list[tuple[Array, Signal]]:
        # Two directions at right angles to the axis and each other; the first is horizontal where that can be.
        upright = abs(self.axis[2]) > 0.999
        first = np.cross((0.0, 1.0, 0.0) if upright else (0.0, 0.0, 1.0), self.axis)
        first = first / np.linalg.norm(first)
        second = np.cross(self.axis, first)
        rotor = (Rotating(self.moment, self.speed, self.run_up, q) for q in (False, True))
        return list(zip((first, second), rotor, strict=True))


class _Continuous(_Force):
    fade_in: float = Field(0.0, ge=0, description="time over which the force fades in [s]")

    @property
    @abstractmethod
    def _highest(self) -> float:
        """Highest frequency [Hz]."""

    @property
    def longest_step(self) -> float:
        return 1.0 / (self._highest * PER_PERIOD)

    @abstractmethod
    def signal(self, duration: float, random: np.random.Generator) -> Signal:
        """Force over time [N], unfaded."""

    def parts(self, duration: float, random: np.random.Generator) -> list[tuple[Array, Signal]]:
        signal = self.signal(duration, random)
        return [(self.axis, Faded(signal, self.fade_in) if self.fade_in > 0.0 else signal)]


class SineForce(_Continuous):
    """amplitude·sin(2πft + phase)."""

    kind: Literal["sine"]
    amplitude: float = Field(description="amplitude [N]")
    frequency: Positive = Field(description="frequency [Hz]")
    phase: float = Field(0.0, description="phase [rad]")

    @property
    def _highest(self) -> float:
        return self.frequency

    def signal(self, duration: float, random: np.random.Generator) -> Signal:
        return Multisine.of(self.amplitude, self.frequency, self.phase)


class MultisineForce(_Continuous):
    """A sum of sines of one amplitude."""

    kind: Literal["multisine"]
    amplitude: float = Field(description="amplitude of each sine [N]")
    frequencies: tuple[Positive, ...] = Field(description="frequencies [Hz]", min_length=1)
    phases: tuple[float, ...] | None = Field(None, description="phases [rad]; without: Schroeder's, of low peak")

    @model_validator(mode="after")
    def _sizes(self) -> Self:
        if self.phases is not None and len(self.phases) != len(self.frequencies):
            raise ValueError(f"phases has {len(self.phases)} values; it must have {len(self.frequencies)}")
        return self

    @property
    def _highest(self) -> float:
        return max(self.frequencies)

    def signal(self, duration: float, random: np.random.Generator) -> Signal:
        phases = schroeder_phases(len(self.frequencies)) if self.phases is None else self.phases
        return Multisine.of(self.amplitude, self.frequencies, phases)


class RandomForce(_Continuous):
    """Random force of a flat spectrum in a band, as of a shaker; of just the stated RMS whatever the seed."""

    kind: Literal["random"]
    rms: Positive = Field(description="RMS of the force [N]")
    first: Positive = Field(5.0, description="lowest frequency [Hz]")
    last: Positive = Field(200.0, description="highest frequency [Hz]")

    @model_validator(mode="after")
    def _band(self) -> Self:
        if self.first >= self.last:
            raise ValueError(f"first = {self.first:g} Hz must be below last = {self.last:g} Hz")
        return self

    @property
    def _highest(self) -> float:
        return self.last

    def signal(self, duration: float, random: np.random.Generator) -> Signal:
        return random_force(self.rms, self.first, self.last, duration, random)


Force = Annotated[Hammer | AxisJerk | Unbalance | SineForce | MultisineForce | RandomForce, Field(discriminator="kind")]


def check_forces(forces: Sequence[_Force], points: Mapping[str, Vector3]) -> None:
    """Refuse forces at places that do not exist.

    Raises:
        ValueError: naming the key, the value and what is allowed.
    """
    for k, force in enumerate(forces):
        if isinstance(force.point, str) and force.point != "cg" and force.point not in points:
            known = ", ".join(map(repr, (*points, "cg")))
            raise ValueError(f"force.{k}.point = {force.point!r} must be one of {known}, or a place [x, y, z]")


def load_of(forces: Sequence[_Force], points: Mapping[str, Vector3], cg: Vector3, duration: float, seed: int) -> Load:
    """All forces together.

    Raises:
        InputError: if a force cannot be made for this duration.
    """
    patterns, signals = [], []
    for k, force in enumerate(forces):
        at = cg if force.point == "cg" else points[force.point] if isinstance(force.point, str) else force.point
        try:
            parts = force.parts(duration, np.random.default_rng([seed, STREAM, k]))
        except MemoryError:
            raise InputError(f"force.{k}: {duration:g} s of it do not fit in memory") from None
        for direction, signal in parts:
            patterns.append(pattern(direction, np.array(at), np.array(cg)))
            signals.append(signal)
    if not signals:
        return NO_LOAD
    return Load(np.array(patterns), tuple(signals), min((force.longest_step for force in forces), default=math.inf))
