"""Forces that last: sine, sum of sines, a random force of a band, and a rotor whose mass is off its axis."""

from dataclasses import dataclass
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.errors import InputError
from ehamj.forces.force import PER_PERIOD, ContinuousForce, ForceSettings
from ehamj.series import Lines, check_lines, parts, room
from ehamj.settings import Positive, SineSum
from ehamj.signals import Array, Multisine, Sample, Signal, rise


class SineForce(ContinuousForce):
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


class MultisineForce(SineSum, ContinuousForce):
    """A sum of sines of one amplitude."""

    kind: Literal["multisine"]
    amplitude: float = Field(description="amplitude of each sine [N]")

    @property
    def _highest(self) -> float:
        return max(self.frequencies)

    def signal(self, duration: float, random: np.random.Generator) -> Signal:
        return Multisine.of(self.amplitude, self.frequencies, self.phases)


class RandomForce(ContinuousForce):
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


def random_force(rms: float, first: float, last: float, duration: float, random: np.random.Generator) -> Lines:
    """A sum of sines of one amplitude and random phase from ``first`` to ``last`` [Hz], of just this ``rms`` [N].

    It repeats after ``duration`` [s] or ten periods of the lowest frequency, whichever is longer.
    """
    period = max(duration, 10.0 / first)
    check_lines(last * period, f"a random force up to last = {last:g} Hz that repeats after {period:g} s")
    lines = room(int(last * period + 1e-6) + 1)
    count = sum(int((np.arange(part.start, part.stop) / period >= first - 1e-9).sum()) for part in parts(0, lines.size))
    if not count:
        raise InputError(
            f"force: no line of a force that repeats after {period:g} s lies from first = {first:g} to "
            f"last = {last:g} Hz; they must be {1.0 / period:g} Hz apart"
        )
    for part in parts(0, lines.size):
        inside = np.arange(part.start, part.stop) / period >= first - 1e-9
        phases = random.uniform(0.0, 2.0 * np.pi, inside.size)
        lines[part] = np.where(inside, np.exp(1j * phases), 0.0) * rms * np.sqrt(2.0 / count)
    return Lines(period, lines)


class Unbalance(ForceSettings):
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


@dataclass(frozen=True)
class Rotating:
    """One direction of the force of an unbalance that runs up: Re or Im of u (ω² − i α) e^(iφ).

    ``moment`` u [kg m] is mass times eccentricity, ``speed`` [Hz] is reached from rest along a quintic in ``run_up``
    [s] from time zero (0: it turns from the beginning), α is the angular acceleration; ``quadrature`` takes the
    imaginary part, a quarter turn behind.
    """

    moment: float
    speed: float
    run_up: float
    quadrature: bool = False

    def angle(self, time: Array) -> tuple[Array, ...]:
        """φ [rad] and its four derivatives."""
        full = 2.0 * np.pi * self.speed
        if self.run_up == 0.0:
            zero = np.zeros_like(time)
            return full * time, zero + full, zero, zero, zero
        s = np.clip(time / self.run_up, 0.0, 1.0)
        turned = self.run_up * s**4 * (2.5 - 3.0 * s + s * s) + np.maximum(time - self.run_up, 0.0)
        third = np.where(s < 1.0, 60.0 * (1.0 - 6.0 * s + 6.0 * s * s), 0.0)
        rate, first, second = rise(s)
        steps = enumerate((turned, rate, first, second, third))
        return tuple(full * part / self.run_up ** max(0, k - 1) for k, part in steps)

    def sample(self, time: Array, left: bool = False) -> Sample:
        phi, w, a, da, dda = self.angle(time)
        turn = self.moment * np.exp(1j * phi)
        parts = (
            (w**2 - 1j * a) * turn,
            (3.0 * w * a + 1j * (w**3 - da)) * turn,
            (3.0 * a**2 + 4.0 * w * da - w**4 + 1j * (6.0 * w**2 * a - dda)) * turn,
        )
        return Sample(*(part.imag if self.quadrature else part.real for part in parts))
