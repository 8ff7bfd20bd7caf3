"""Scalar signals of time with their first two derivatives; ground motion and commands are made of these."""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array

SLACK = 5e-10
"""Half a nanosecond: the times of steps are multiples of the step with rounding, and a jump belongs to one of them."""


class Sample(NamedTuple):
    """A signal at some times, shape (n,) each: value, first and second derivative by time."""

    value: Array
    slope: Array
    curvature: Array


class Signal(Protocol):
    """Anything that can be sampled; ``left`` asks for the limit from the left where the signal jumps."""

    def sample(self, time: Array, left: bool = False) -> Sample:
        """Value and derivatives at ``time`` [s], shape (n,)."""
        ...


@dataclass(frozen=True)
class Zero:
    """Nothing moves."""

    def sample(self, time: Array, left: bool = False) -> Sample:
        zero = np.zeros_like(time)
        return Sample(zero, zero, zero)


@dataclass(frozen=True)
class Multisine:
    """Sum of ``amplitudes``·sin(2π ``frequencies`` t + ``phases``), frequencies in Hz, phases in rad."""

    amplitudes: Array
    frequencies: Array
    phases: Array

    @classmethod
    def of(cls, amplitudes: ArrayLike, frequencies: ArrayLike, phases: ArrayLike | None = 0.0) -> "Multisine":
        """Broadcast the three against each other; phases None: Schroeder's."""
        phases = schroeder_phases(np.size(frequencies)) if phases is None else phases
        parts = (np.atleast_1d(np.asarray(part, float)) for part in (amplitudes, frequencies, phases))
        return cls(*np.broadcast_arrays(*parts))

    def sample(self, time: Array, left: bool = False) -> Sample:
        omega = 2.0 * np.pi * self.frequencies
        angle = np.multiply.outer(time, omega) + self.phases
        sine, cosine = np.sin(angle), np.cos(angle)
        value, slope = sine @ self.amplitudes, cosine @ (omega * self.amplitudes)
        curvature = -(sine @ (omega**2 * self.amplitudes))
        return Sample(value, slope, curvature)


def schroeder_phases(lines: int) -> Array:
    """Phases that keep the peak of a sum of sines low, −πk(k + 1)/n [rad] (Schroeder 1970)."""
    k = np.arange(lines)
    return -np.pi * k * (k + 1) / lines


@dataclass(frozen=True)
class Step:
    """A jump by ``height`` at ``start`` [s]."""

    height: float
    start: float

    def sample(self, time: Array, left: bool = False) -> Sample:
        after = time > self.start + SLACK if left else time >= self.start - SLACK
        zero = np.zeros_like(time)
        return Sample(np.where(after, self.height, 0.0), zero, zero)


@dataclass(frozen=True)
class Chirp:
    """Exponential sine sweep from ``first`` to ``last`` [Hz] in ``duration`` [s] from ``start``; zero outside."""

    amplitude: float
    first: float
    last: float
    duration: float
    start: float = 0.0

    def sample(self, time: Array, left: bool = False) -> Sample:
        growth = np.log1p((self.last - self.first) / self.first) / self.duration
        since = time - self.start
        edge = since - SLACK if left else since + SLACK
        inside = (edge > 0.0) & (edge < self.duration)
        since = np.clip(since, 0.0, self.duration)
        omega = 2 * np.pi * self.first * np.exp(growth * since)
        turns = since if growth == 0.0 else np.expm1(growth * since) / growth
        angle = 2 * np.pi * self.first * turns
        sine, cosine = np.where(inside, np.sin(angle), 0.0), np.where(inside, np.cos(angle), 0.0)
        curvature = self.amplitude * (growth * omega * cosine - omega**2 * sine)
        return Sample(self.amplitude * sine, self.amplitude * omega * cosine, curvature)


@dataclass(frozen=True)
class Product:
    """The product of two signals, such as a vibration and its envelope."""

    one: Signal
    other: Signal

    def sample(self, time: Array, left: bool = False) -> Sample:
        (a, a1, a2), (b, b1, b2) = self.one.sample(time, left), self.other.sample(time, left)
        return Sample(a * b, a1 * b + a * b1, a2 * b + 2.0 * a1 * b1 + a * b2)


def rise(s: Array) -> Sample:
    """The quintic 10 s³ − 15 s⁴ + 6 s⁵ from 0 at s ≤ 0 to 1 at s ≥ 1, smooth to the second derivative; by s."""
    s = np.clip(s, 0.0, 1.0)
    return Sample(
        s**3 * (10.0 - 15.0 * s + 6.0 * s * s), 30.0 * s**2 * (1.0 - s) ** 2, 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)
    )


@dataclass(frozen=True)
class Faded:
    """A signal that fades in over ``duration`` [s] from ``begin`` [s] (a quintic, smooth to the second derivative)."""

    signal: Signal
    duration: float
    begin: float = 0.0

    def sample(self, time: Array, left: bool = False) -> Sample:
        plain = self.signal.sample(time, left)
        if time.size and time.min() >= self.begin + self.duration:
            return plain
        value, slope, curvature = plain
        w, w1, w2 = rise((time - self.begin) / self.duration)
        w1, w2 = w1 / self.duration, w2 / self.duration**2
        return Sample(w * value, w1 * value + w * slope, w2 * value + 2.0 * w1 * slope + w * curvature)


def faded(signal: Signal, duration: float, begin: float = 0.0) -> Signal:
    """`Faded`, or the signal itself where it is to fade in at once."""
    return Faded(signal, duration, begin) if duration > 0.0 else signal


@dataclass(frozen=True)
class Total:
    """The sum of several signals."""

    signals: tuple[Signal, ...]

    def sample(self, time: Array, left: bool = False) -> Sample:
        parts = [signal.sample(time, left) for signal in self.signals]
        return Sample(*(np.sum(column, axis=0) for column in zip(*parts, strict=True)))
