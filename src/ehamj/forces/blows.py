"""Blows, as of an instrumented hammer."""

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.forces.force import PER_PERIOD, ForceSettings
from ehamj.settings import Positive
from ehamj.signals import SLACK, Array, Sample, Signal


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
