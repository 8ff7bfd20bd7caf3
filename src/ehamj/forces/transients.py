"""Forces that come and go: blows of a hammer, and the reaction of an axis that moves with limited jerk."""

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.forces.force import PER_PERIOD, ForceSettings
from ehamj.settings import Positive
from ehamj.signals import SLACK, Array, Sample, Signal
from ehamj.slides.scurve import jerk_limited


class Hammer(ForceSettings):
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


@dataclass(frozen=True)
class Blows:
    """Half-sines of ``peak`` [N] and ``duration`` [s], the first at ``begin`` [s]; ``count``, ``interval`` [s] apart.

    The impulse of each is 2·peak·duration/π.
    """

    peak: float
    duration: float
    begin: float
    count: int = 1
    interval: float = 1.0

    def sample(self, time: Array, left: bool = False) -> Sample:
        edge = time - self.begin + (-SLACK if left else SLACK)
        number = np.clip(np.floor(edge / self.interval), 0, self.count - 1)
        inside = (edge > number * self.interval) & (edge < number * self.interval + self.duration)
        omega = np.pi / self.duration
        angle = omega * (time - self.begin - number * self.interval)
        sine, cosine = np.where(inside, np.sin(angle), 0.0), np.where(inside, np.cos(angle), 0.0)
        return Sample(self.peak * sine, self.peak * omega * cosine, -self.peak * omega**2 * sine)


class AxisJerk(ForceSettings):
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


@dataclass(frozen=True)
class Pieces:
    """Straight pieces through ``values`` at ``times`` [s], zero outside."""

    times: Array
    values: Array

    def sample(self, time: Array, left: bool = False) -> Sample:
        slopes = np.concatenate([[0.0], np.diff(self.values) / np.diff(self.times), [0.0]])
        piece = np.searchsorted(self.times, time + (-SLACK if left else SLACK), side="right")
        return Sample(np.interp(time, self.times, self.values, 0.0, 0.0), slopes[piece], np.zeros_like(time))
