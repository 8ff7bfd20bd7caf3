"""Forces that last: sine, sum of sines, and a random force of a band."""

from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.forces.force import ContinuousForce
from ehamj.settings import Positive
from ehamj.signals import Lines, Multisine, Signal, schroeder_phases


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


class MultisineForce(ContinuousForce):
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
    frequency = np.arange(int(last * period + 1e-6) + 1) / period
    inside = frequency >= first - 1e-9
    phases = random.uniform(0.0, 2.0 * np.pi, frequency.size)
    return Lines(period, np.where(inside, np.exp(1j * phases), 0.0) * rms * np.sqrt(2.0 / inside.sum()))
