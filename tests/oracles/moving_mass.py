"""A machine in its plane x, z, ry on springs, with a mass that goes along x as it is told: Newton and Euler, SciPy.

Feet move with the finite rotation, springs act along x and z at the feet where these then are. Shares no code with
ehamj; the moving mass is a point with an inertia, at ``place(t)`` = position, speed, acceleration.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

Place = Callable[[float], tuple[float, float, float]]


@dataclass(frozen=True)
class MovingMass:
    """SI; ``feet`` are the x of the feet."""

    place: Place
    feet: tuple[float, ...]
    mass: float = 3000.0
    inertia: float = 3000.0
    height: float = 0.75
    moving: float = 1000.0
    moving_inertia: float = 40.0
    rail: float = 0.9
    stiffness: float = 1e6
    damping: float = 2e4
    lateral_stiffness: float = 3e5
    lateral_damping: float = 5e3
    gravity: float = 9.80665

    def accelerations(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Of x, z and ry."""
        c, s, w = np.cos(q[2]), np.sin(q[2]), v[2]
        at, speed, forward = self.place(t)
        matrix, right = np.zeros((3, 3)), np.zeros(3)
        for mass, inertia, (along, up), (rate, gain) in (
            (self.mass, self.inertia, (0.0, self.height), (0.0, 0.0)),
            (self.moving, self.moving_inertia, (at, self.rail), (speed, forward)),
        ):
            rx, rz = c * along + s * up, -s * along + c * up
            jacobian = np.array([[1.0, 0.0, rz], [0.0, 1.0, -rx]])
            known = np.array([-w * w * rx - 2.0 * w * s * rate + c * gain, -w * w * rz - 2.0 * w * c * rate - s * gain])
            matrix += mass * jacobian.T @ jacobian
            matrix[2, 2] += inertia
            right += mass * jacobian.T @ (np.array([0.0, -self.gravity]) - known)
        for foot in self.feet:
            rx, rz = c * foot, -s * foot
            jacobian = np.array([[1.0, 0.0, rz], [0.0, 1.0, -rx]])
            moved, rate = np.array([q[0] + rx - foot, q[1] + rz]), jacobian @ v
            stiffness, damping = (self.lateral_stiffness, self.stiffness), (self.lateral_damping, self.damping)
            right -= jacobian.T @ (np.array(stiffness) * moved + np.array(damping) * rate)
        return np.linalg.solve(matrix, right)

    def motion(self, times: np.ndarray, start: np.ndarray) -> np.ndarray:
        """x, z, ry at some times from rest at ``start``, (n, 3)."""

        def rates(t: float, state: np.ndarray) -> np.ndarray:
            return np.concatenate([state[3:], self.accelerations(t, state[:3], state[3:])])

        found = solve_ivp(
            rates,
            (times[0], times[-1]),
            np.r_[start, np.zeros(3)],
            "DOP853",
            times,
            rtol=1e-10,
            atol=1e-13,
            max_step=0.01,
        )
        return found.y[:3].T
