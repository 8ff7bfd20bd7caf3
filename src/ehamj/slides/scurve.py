"""Moves from rest to rest with limited speed, acceleration and jerk: the seven pieces of an S-curve."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from ehamj.arrays import Array
from ehamj.signals import SLACK, Sample


def seven_pieces(travel: float, speed: float, acceleration: float, jerk: float) -> tuple[Array, Array]:
    """Durations [s] and jerks [m/s³] of the pieces of a move over ``travel`` [m], in time-optimal order.

    The acceleration rises and falls by ``jerk``; where travel or speed are too small for the stated speed or
    acceleration, these are not reached, and pieces have no duration (Biagiotti and Melchiorri, Trajectory Planning,
    sec. 3.4).
    """
    rise = min(np.sqrt(speed / jerk), acceleration / jerk, np.cbrt(0.5 * travel / jerk))  # of the acceleration
    a = jerk * rise
    # Of speeding up, reaching v = a·up: travel = v (2 rise + hold…) with v ≤ speed.
    up = min(speed / a, 0.5 * (np.sqrt(rise**2 + 4.0 * travel / a) - rise))  # time at a, with half of each ramp
    cruise = max(0.0, travel / (a * up) - up - rise)
    hold = max(0.0, up - rise)
    return np.array([rise, hold, rise, cruise, rise, hold, rise]), jerk * np.array([1.0, 0, -1, 0, -1, 0, 1])


def jerk_limited(travel: float, speed: float, acceleration: float, jerk: float) -> tuple[Array, Array]:
    """Times [s] and accelerations [m/s²] at the corners of such a move."""
    durations, jerks = seven_pieces(travel, speed, acceleration, jerk)
    a = float(durations[0] * jerks[0])
    corners = np.concatenate([[0.0], np.cumsum(durations)])
    values = np.array([0.0, a, a, 0.0, 0.0, -a, -a, 0.0])
    kept = np.concatenate([[True], durations > SLACK])
    return corners[kept], values[kept]


@dataclass(frozen=True)
class Course:
    """Pieces of constant jerk: from ``times`` [s] on with ``states`` (piece, 3) [m, m/s, m/s²] and ``jerks``."""

    times: Array
    states: Array
    jerks: Array

    @classmethod
    def of(cls, start: float, moves: Sequence[tuple[float, float, tuple[Array, Array]]]) -> Self:
        """From ``start`` [m]; of each move its time [s], where it goes [m], and `seven_pieces`."""
        times, states, jerks, at = [-np.inf], [[start, 0.0, 0.0]], [0.0], start
        for begin, to, (durations, pieces) in moves:
            time, x, v, a, sign = begin, at, 0.0, 0.0, float(np.sign(to - at))
            for duration, jerk in zip(durations, sign * pieces, strict=True):
                times.append(time)
                states.append([x, v, a])
                jerks.append(jerk)
                x += duration * (v + duration * (a / 2.0 + duration * jerk / 6.0))
                v += duration * (a + duration * jerk / 2.0)
                a, time = a + duration * jerk, time + duration
            at = to
            times.append(time)
            states.append([to, 0.0, 0.0])
            jerks.append(0.0)
        return cls(np.array(times), np.array(states), np.array(jerks))

    def sample(self, time: Array, left: bool = False) -> Sample:
        piece = np.searchsorted(self.times, time, side="right") - 1
        s = np.where(piece > 0, time - np.where(piece > 0, self.times[piece], 0.0), 0.0)
        (x, v, a), jerk = self.states[piece].T, self.jerks[piece]
        value = x + s * (v + s * (a / 2.0 + s * jerk / 6.0))
        return Sample(value, v + s * (a + s * jerk / 2.0), a + s * jerk)
