"""Ground motion made from formulas: rest, sine, multisine, sweep and shock; of a rigid slab, or as a passing wave."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.ground.motion import GroundSettings, Motion, Slab, Start
from ehamj.ground.waves import Wave, spread
from ehamj.settings import Fade, Positive
from ehamj.signals import Array, Chirp, Multisine, Sample, Signal, rise

Dof = Literal["x", "y", "z", "rx", "ry", "rz"]


class RestGround(GroundSettings):
    """The ground is at rest."""

    kind: Literal["rest"] = "rest"

    def motion(self, start: Start) -> Motion:
        return Slab(start.positions, {})


class OneDof(GroundSettings):
    """What all of these have: one degree of freedom that moves, as a slab or as a wave."""

    dof: Dof = Field("z", description="degree of freedom that moves (a wave: x, y or z)")
    wave: Wave | None = Field(None, description="pass below the machine as a plane wave; without: a rigid slab")
    fade_in: Fade = Field(0.0, description="time over which the motion fades in [s]")

    @abstractmethod
    def signal(self) -> Signal:
        """Displacement [m] or rotation [rad]."""

    def motion(self, start: Start) -> Motion:
        return spread(start, {self.dof: self.signal()}, self.wave, self.fade_in)


class SineGround(OneDof):
    """One sine."""

    kind: Literal["sine"]
    amplitude: float = Field(1e-6, description="amplitude of the displacement [m] or rotation [rad]")
    frequency: Positive = Field(10.0, description="frequency [Hz]")
    phase: float = Field(0.0, description="phase [rad]")

    def signal(self) -> Signal:
        return Multisine.of(self.amplitude, self.frequency, self.phase)


class MultisineGround(OneDof):
    """A sum of sines of given velocity: lines of motors and fans, or a measuring signal."""

    kind: Literal["multisine"]
    frequencies: tuple[Positive, ...] = Field(description="frequencies [Hz]", min_length=1)
    velocities: tuple[float, ...] = Field(description="RMS velocity of each [m/s or rad/s]; one value serves for all")
    phases: tuple[float, ...] | None = Field(None, description="phases [rad]; without: Schroeder's, of low peak")

    @model_validator(mode="after")
    def _sizes(self) -> Self:
        n = len(self.frequencies)
        if len(self.velocities) not in (1, n):
            raise ValueError(f"velocities has {len(self.velocities)} values; it must have 1 or {n}, as frequencies")
        if self.phases is not None and len(self.phases) != n:
            raise ValueError(f"phases has {len(self.phases)} values; it must have {n}, as frequencies")
        return self

    def signal(self) -> Signal:
        frequency = np.array(self.frequencies)
        amplitude = np.sqrt(2.0) * np.array(self.velocities) / (2 * np.pi * frequency)
        return Multisine.of(amplitude, frequency, self.phases)


class SweepGround(OneDof):
    """An exponential sine sweep of constant displacement amplitude."""

    kind: Literal["sweep"]
    amplitude: float = Field(1e-6, description="amplitude of the displacement [m] or rotation [rad]")
    first: Positive = Field(1.0, description="frequency at the beginning [Hz]")
    last: Positive = Field(100.0, description="frequency at the end [Hz]")
    sweep_time: Positive = Field(20.0, description="duration of the sweep [s]")
    begin: float = Field(0.0, ge=0, description="time at which the sweep begins [s]")
    fade_in: Fade = Field(0.0, description="time over which the sweep fades in from its beginning [s]")

    def signal(self) -> Signal:
        return Chirp(self.amplitude, self.first, self.last, self.sweep_time, self.begin)

    def motion(self, start: Start) -> Motion:
        return spread(start, {self.dof: self.signal()}, self.wave, self.fade_in, self.begin)


class ShockGround(OneDof):
    """A half-sine of velocity (a press, something dropped), after which the ground returns to its place; or many."""

    kind: Literal["shock"]
    velocity: float = Field(1e-3, description="peak velocity [m/s or rad/s]")
    pulse_time: Positive = Field(0.02, description="duration of the half-sine [s]")
    return_time: Positive = Field(0.5, description="time in which the ground comes back afterwards [s]")
    begin: float = Field(1.0, ge=0, description="time of the (first) shock [s]")
    repeat: Positive | None = Field(None, description="time from one shock to the next [s]; without: there is one")

    @model_validator(mode="after")
    def _apart(self) -> Self:
        least = self.pulse_time + self.return_time
        if self.repeat is not None and self.repeat < least:
            raise ValueError(
                f"repeat = {self.repeat:g} s must be at least pulse_time + return_time = {least:g} s, so that the "
                "ground is back in its place when the next shock comes"
            )
        return self

    def signal(self) -> Signal:
        return HalfSine(self.velocity, self.pulse_time, self.return_time, self.begin, self.repeat)


@dataclass(frozen=True)
class HalfSine:
    """Displacement whose velocity is a half-sine pulse, followed by a smooth (quintic) way back; repeated or not."""

    velocity: float
    pulse_time: float
    return_time: float
    begin: float
    repeat: float | None = None

    def sample(self, time: Array, left: bool = False) -> Sample:
        omega = np.pi / self.pulse_time
        since = time - self.begin
        if self.repeat is not None:
            since = np.where(since > 0.0, since % self.repeat, since)
        pulse = np.clip(since, 0.0, self.pulse_time)
        inside = (since > 0.0) & (since < self.pulse_time)
        height = self.velocity / omega * (1.0 - np.cos(omega * pulse))
        back, back_1, back_2 = rise((since - self.pulse_time) / self.return_time)
        speed = np.where(inside, self.velocity * np.sin(omega * pulse), height * (-back_1 / self.return_time))
        accelerating = self.velocity * omega * np.cos(omega * pulse)
        curvature = np.where(inside, accelerating, height * (-back_2 / self.return_time**2))
        return Sample(height * (1.0 - back), speed, curvature)
