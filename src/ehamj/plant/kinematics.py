"""Motion of points of the rigid machine from its six degrees of freedom; exact, and without loss at 1e-9 rad."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array


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


def rotations(angles: ArrayLike) -> tuple[Array, Array, Array]:
    """The machine's rotation R at angles (…, 3), rx, ry, rz [rad], in the order of `points_motion`, and how it changes.

    Returns:
        R − 1 (…, 3, 3); its derivatives (…, 3, 3, 3) and second derivatives (…, 3, 3, 3, 3), the angles first.
    """
    given = np.asarray(angles, float)
    turns = [_turn(axis, given[..., axis].ravel()) for axis in range(3)]
    whole = [np.eye(3) + turns[axis][0] for axis in range(3)]
    factors = [(whole[axis], *turns[axis][1:]) for axis in range(3)]

    def product(*derivatives: int) -> Array:
        times = [derivatives.count(axis) for axis in range(3)]
        return np.asarray(factors[2][times[2]] @ factors[0][times[0]] @ factors[1][times[1]])

    a, b, c = (turns[axis][0] for axis in (2, 0, 1))
    excess = a + b + c + a @ b + a @ c + b @ c + a @ b @ c
    first = np.stack([product(j) for j in range(3)], axis=1)
    second = np.stack([np.stack([product(j, k) for k in range(3)], axis=1) for j in range(3)], axis=1)
    lead = given.shape[:-1]
    return excess.reshape(*lead, 3, 3), first.reshape(*lead, 3, 3, 3), second.reshape(*lead, 3, 3, 3, 3)


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
    one = np.eye(3)
    turns = [_turn(axis, displacement[:, 3 + axis]) for axis in range(3)]
    order = (2, 0, 1)
    rotations = {axis: one + turns[axis][0] for axis in order}
    # R − 1 = A + B + C + AB + … keeps the small parts small.
    a, b, c = (turns[axis][0] for axis in order)
    excess = a + b + c + a @ b + a @ c + b @ c + a @ b @ c

    def product(**derivatives: int) -> Array:
        factors = []
        for axis in order:
            times = derivatives.get("xyz"[axis], 0)
            factors.append(rotations[axis] if times == 0 else turns[axis][times])
        return factors[0] @ factors[1] @ factors[2]

    first = {axis: product(**{"xyz"[axis]: 1}) for axis in range(3)}
    rates, accelerations = velocity[:, 3:], acceleration[:, 3:]
    spin = sum(rates[:, axis, None, None] * first[axis] for axis in range(3))
    gain = sum(accelerations[:, axis, None, None] * first[axis] for axis in range(3))
    for axis in range(3):
        gain = gain + (rates[:, axis] ** 2)[:, None, None] * product(**{"xyz"[axis]: 2})
        for other in range(axis):
            both = product(**{"xyz"[axis]: 1, "xyz"[other]: 1})
            gain = gain + 2.0 * (rates[:, axis] * rates[:, other])[:, None, None] * both
    bases = (displacement, velocity, acceleration)
    turned = (excess, spin, gain)
    found = []
    for point in points:
        r = np.asarray(point, float)
        x, y, z = (base[:, :3] + turn @ r for base, turn in zip(bases, turned, strict=True))
        found.append((x, y, z))
    return found
