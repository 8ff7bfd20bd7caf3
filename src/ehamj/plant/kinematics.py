"""Motion of points of the rigid machine from its six degrees of freedom; exact, and without loss at 1e-9 rad."""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array

ORDER: Final = (2, 0, 1)
"""Axes in the order of their turns: yaw, then rx, then ry, each about the already turned axis."""


def _turn(axis: int, angle: Array) -> tuple[Array, Array, Array]:
    """R − 1, dR/dφ and d²R/dφ² of a turn about one axis, shape (n, 3, 3) each."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    sine, cosine = np.sin(angle), np.cos(angle)
    excess, first, second = np.zeros((3, angle.size, 3, 3))
    # cos φ − 1 as −2 sin²(φ/2): the difference of two numbers near one would lose what small angles do.
    excess[:, i, i] = excess[:, j, j] = -2.0 * np.sin(0.5 * angle) ** 2
    excess[:, i, j], excess[:, j, i] = -sine, sine
    first[:, i, i] = first[:, j, j] = -sine
    first[:, i, j], first[:, j, i] = -cosine, cosine
    second[:, i, i] = second[:, j, j] = -cosine
    second[:, i, j], second[:, j, i] = sine, -sine
    return excess, first, second


def _turned(angles: Array) -> tuple[Array, Callable[..., Array]]:
    """R − 1 (n, 3, 3) at angles (n, 3) [rad], and R differentiated by any two of them at most, named by number."""
    turns = [_turn(axis, angles[:, axis]) for axis in range(3)]
    factors = [(np.eye(3) + excess, first, second) for excess, first, second in turns]

    def derivative(*axes: int) -> Array:
        z, x, y = (factors[axis][axes.count(axis)] for axis in ORDER)
        return np.asarray(z @ x @ y)

    # R − 1 = A + B + C + AB + … keeps the small parts small.
    a, b, c = (turns[axis][0] for axis in ORDER)
    return a + b + c + a @ b + a @ c + b @ c + a @ b @ c, derivative


def rotations(angles: ArrayLike) -> tuple[Array, Array, Array]:
    """The machine's rotation R at angles (…, 3), rx, ry, rz [rad], in the order of `points_motion`, and how it changes.

    Returns:
        R − 1 (…, 3, 3); its derivatives (…, 3, 3, 3) and second derivatives (…, 3, 3, 3, 3), the angles first.
    """
    given = np.asarray(angles, float)
    excess, derivative = _turned(given.reshape(-1, 3))
    first = np.stack([derivative(j) for j in range(3)], axis=1)
    second = np.stack([np.stack([derivative(j, k) for k in range(3)], axis=1) for j in range(3)], axis=1)
    lead = given.shape[:-1]
    return excess.reshape(*lead, 3, 3), first.reshape(*lead, 3, 3, 3), second.reshape(*lead, 3, 3, 3, 3)


def points_displaced(displacement: Array, points: Sequence[ArrayLike]) -> list[Array]:
    """Displacement of points fixed to the machine, shape (n, 3) each; arguments as of `points_motion`."""
    excess, _ = _turned(displacement[:, 3:])
    turned = (excess.reshape(-1, 3) @ np.asarray(points, float).reshape(-1, 3).T).reshape(len(displacement), 3, -1)
    return [displacement[:, :3] + turned[:, :, k] for k in range(turned.shape[2])]


def points_motion(
    displacement: Array, velocity: Array, acceleration: Array, points: Sequence[ArrayLike]
) -> list[tuple[Array, Array, Array]]:
    """Displacement, velocity and acceleration of points fixed to the machine, shape (n, 3) each.

    Args:
        displacement: of the mount plane's centre, (n, 6): x, y, z [m], rx, ry, rz [rad]; rotations are applied in the
            order yaw, then rx, then ry (each about the already turned axis).
        velocity: its rate, (n, 6).
        acceleration: its second derivative, (n, 6).
        points: positions on the machine at rest, from the mount plane's centre (3,) [m].
    """
    excess, derivative = _turned(displacement[:, 3:])
    rates, accelerations = velocity[:, 3:], acceleration[:, 3:]
    first = [derivative(axis) for axis in range(3)]
    spin = sum(rates[:, axis, None, None] * first[axis] for axis in range(3))
    gain = sum(accelerations[:, axis, None, None] * first[axis] for axis in range(3))
    for axis in range(3):
        gain = gain + (rates[:, axis] ** 2)[:, None, None] * derivative(axis, axis)
        for other in range(axis):
            gain = gain + 2.0 * (rates[:, axis] * rates[:, other])[:, None, None] * derivative(axis, other)
    bases = (displacement, velocity, acceleration)
    turned = (excess, spin, gain)
    found = []
    for point in points:
        r = np.asarray(point, float)
        x, y, z = (base[:, :3] + turn @ r for base, turn in zip(bases, turned, strict=True))
        found.append((x, y, z))
    return found
