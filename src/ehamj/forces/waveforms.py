"""Forces over time, each with its first two derivatives (`ehamj.signals.Signal`)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ehamj.signals import SLACK, Sample, Sampled

Array = NDArray[np.float64]


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


@dataclass(frozen=True)
class Pieces:
    """Straight pieces through ``values`` at ``times`` [s], zero outside."""

    times: Array
    values: Array

    def sample(self, time: Array, left: bool = False) -> Sample:
        slopes = np.concatenate([[0.0], np.diff(self.values) / np.diff(self.times), [0.0]])
        piece = np.searchsorted(self.times, time + (-SLACK if left else SLACK), side="right")
        return Sample(np.interp(time, self.times, self.values, 0.0, 0.0), slopes[piece], np.zeros_like(time))


def jerk_limited(travel: float, velocity: float, acceleration: float, jerk: float) -> tuple[Array, Array]:
    """Times [s] and accelerations [m/s²] at the corners of a move from rest to rest over ``travel`` [m].

    The usual seven pieces: the acceleration rises and falls by ``jerk``; where travel or velocity are too small for the
    stated velocity or acceleration, these are not reached (Biagiotti and Melchiorri, Trajectory Planning, sec. 3.4).
    """
    rise = min(np.sqrt(velocity / jerk), acceleration / jerk, np.cbrt(0.5 * travel / jerk))  # of the acceleration
    a = jerk * rise
    # Of speeding up, reaching v = a·up: travel = v (2 rise + hold…) with v ≤ velocity.
    up = min(velocity / a, 0.5 * (np.sqrt(rise**2 + 4.0 * travel / a) - rise))  # time at a, with half of each ramp
    v = a * up
    cruise = max(0.0, travel / v - up - rise)
    durations = [rise, up - rise, rise, cruise, rise, up - rise, rise]
    corners = np.concatenate([[0.0], np.cumsum(durations)])
    values = np.array([0.0, a, a, 0.0, 0.0, -a, -a, 0.0])
    kept = np.concatenate([[True], np.diff(corners) > SLACK])
    return corners[kept], values[kept]


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

    def angle(self, time: Array) -> tuple[Array, Array, Array, Array, Array]:
        """φ [rad] and its four derivatives."""
        full = 2.0 * np.pi * self.speed
        if self.run_up == 0.0:
            zero = np.zeros_like(time)
            return full * time, zero + full, zero, zero, zero
        s = np.clip(time / self.run_up, 0.0, 1.0)
        turned = self.run_up * s**4 * (2.5 - 3.0 * s + s * s) + np.maximum(time - self.run_up, 0.0)
        rate = s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        first = 30.0 * s**2 * (1.0 - s) ** 2
        second = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)
        third = np.where(s < 1.0, 60.0 * (1.0 - 6.0 * s + 6.0 * s * s), 0.0)
        return (
            full * turned,
            full * rate,
            full * first / self.run_up,
            full * second / self.run_up**2,
            (full * third / self.run_up**3),
        )

    def sample(self, time: Array, left: bool = False) -> Sample:
        phi, w, a, da, dda = self.angle(time)
        turn = self.moment * np.exp(1j * phi)
        parts = (
            (w**2 - 1j * a) * turn,
            (3.0 * w * a + 1j * (w**3 - da)) * turn,
            (3.0 * a**2 + 4.0 * w * da - w**4 + 1j * (6.0 * w**2 * a - dda)) * turn,
        )
        return Sample(*(part.imag if self.quadrature else part.real for part in parts))


def random_force(rms: float, first: float, last: float, duration: float, random: np.random.Generator) -> Sampled:
    """A sum of sines of one amplitude and random phase from ``first`` to ``last`` [Hz], of just this ``rms`` [N].

    It repeats after ``duration`` [s] or ten periods of the lowest frequency, whichever is longer.
    """
    period = max(duration, 10.0 / first)
    size = int(2 ** np.ceil(np.log2(8.0 * last * period)))
    frequency = np.fft.rfftfreq(size, period / size)
    lines = (frequency >= first - 1e-9) & (frequency <= last + 1e-9)
    phases = random.uniform(0.0, 2.0 * np.pi, frequency.size)
    spectrum = np.where(lines, np.exp(1j * phases), 0.0) * rms / np.sqrt(2.0 * lines.sum()) * size
    values = np.fft.irfft(spectrum, size)
    rate = size / period
    margin = 8  # samples beyond both ends, so that the spline's ends are outside
    kept = np.arange(-margin, int(np.ceil(duration * rate)) + margin + 1)
    return Sampled(rate, values[kept % size], -margin / rate)
