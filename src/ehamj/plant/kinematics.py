"""Motion of points of the rigid machine from its six degrees of freedom; exact, and without loss at 1e-9 rad."""

from collections.abc import Callable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array

TOGETHER: Final = 1000
"""Rows of points that are moved at once: of a few rows, all points; of many, one after the other."""
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
    return list(points_moved((displacement,), points)[0])


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
    return list(zip(*points_moved((displacement, velocity, acceleration), points), strict=True))


def points_moved(motions: Sequence[Array], points: Sequence[ArrayLike]) -> list[Array]:
    """As many derivatives of the points' displacement as there are of the machine's motion, (point, n, 3) each.

    Args:
        motions: displacement (n, 6), as of `points_motion`, and its derivatives, two at most.
        points: as of `points_motion`.
    """
    rest = np.array(points, float).reshape(-1, 3).T[:, :, None]  # (axis, point, 1)
    angles = np.stack([np.ascontiguousarray(motion[:, 3:].T) for motion in motions])  # (derivative, axis, n)
    turns = {axis: (*_sines(angles[0, axis]), angles[1:, axis]) for axis in ORDER}
    found = np.empty((len(motions), rest.shape[1], len(motions[0]), 3))
    every = max(1, TOGETHER // max(1, len(motions[0])))
    for first in range(0, rest.shape[1], every):
        part = slice(first, first + every)
        # Each turn is applied to all derivatives of what the ones before it made of the points.
        moved: list[list[Any]] = [[0.0, 0.0, 0.0] for _ in motions]
        for axis in reversed(ORDER):
            _turn_all(axis, turns[axis], rest[:, part], moved)
        for derivative, (motion, own) in enumerate(zip(motions, moved, strict=True)):
            for axis in range(3):
                found[derivative, part, :, axis] = motion[:, axis] + own[axis]
    return list(found)


def _sines(angle: Array) -> tuple[Array, Array, Array]:
    """Sine and cosine of an angle, and cosine − 1 as −2 sin²(φ/2): the difference of two numbers near one would lose
    what small angles do."""
    return np.sin(angle), np.cos(angle), -2.0 * np.sin(0.5 * angle) ** 2


def _turn_all(axis: int, turn: tuple[Array, Array, Array, Array], points: Array, moved: list[list[Any]]) -> None:
    """Turn p = points + moved[0], (point, n) along each axis, and its derivatives moved[1:] about one by an angle φ:

    p → R p, ṗ → φ̇ R′p + R ṗ, p̈ → φ̈ R′p + φ̇² R″p + 2 φ̇ R′ṗ + R p̈.
    """
    (sine, cosine, excess, rates), (i, j) = turn, ((axis + 1) % 3, (axis + 2) % 3)

    def turned(x: Any, y: Any) -> tuple[Any, Any]:
        """(R − 1) of the two components that the turn changes."""
        return excess * x - sine * y, sine * x + excess * y

    def swept(x: Any, y: Any) -> tuple[Any, Any]:
        """R′; R″ is it twice."""
        return -sine * x - cosine * y, cosine * x - sine * y

    at = (i, j)
    x, y = points[i] + moved[0][i], points[j] + moved[0][j]
    by_angle = swept(x, y)
    if len(moved) > 2:
        by_rate = swept(moved[1][i], moved[1][j])
        more, bent = turned(moved[2][i], moved[2][j]), (-cosine * x + sine * y, -sine * x - cosine * y)  # R″p
        for number, k in enumerate(at):
            spin = rates[1] * by_angle[number] + rates[0] ** 2 * bent[number] + 2.0 * (rates[0] * by_rate[number])
            moved[2][k] = moved[2][k] + more[number] + spin
    if len(moved) > 1:
        more = turned(moved[1][i], moved[1][j])
        for number, k in enumerate(at):
            moved[1][k] = moved[1][k] + more[number] + rates[0] * by_angle[number]
    more = turned(x, y)
    for number, k in enumerate(at):
        moved[0][k] = moved[0][k] + more[number]
