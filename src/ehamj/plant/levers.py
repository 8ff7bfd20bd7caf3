"""How a rigid body's small motion moves its points: the one lever p + θ × r, the plane of the mounts, and its fit."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array

MOTIONS = ("heave", "roll", "pitch")
"""Motions of the plane of the mounts, in the order of the columns of `plane`."""


def lever(point: ArrayLike) -> Array:
    """Displacement x, y, z [m] of a point per x, y, z [m] and rx, ry, rz [rad] of the origin: p + θ × r, (3, 6).

    ``point`` is x, y, z [m], or x, y where it lies in the mount plane.
    """
    x, y, z = (*np.asarray(point, float), 0.0)[:3]
    return np.array([[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0]], float)


def levers(points: Sequence[ArrayLike] | Array) -> Array:
    """`lever` of several points below each other, shape (3 points, 6)."""
    return np.concatenate([lever(point) for point in points])


def plane(positions: Sequence[Sequence[float]]) -> Array:
    """Height of each mount [m] per heave [m], roll and pitch [rad]: columns 1, y, −x, shape (mount, 3)."""
    return np.array([[1.0, y, -x] for x, y, *_ in positions])


def plane_fit(positions: Sequence[Sequence[float]]) -> Array:
    """Heave [m], roll and pitch [rad] of the plane that fits the mounts' heights best, per height, (3, mount)."""
    return np.asarray(np.linalg.pinv(plane(positions)))


def warp(positions: Sequence[Sequence[float]]) -> Array:
    """Pattern of forces at four mounts that moves nothing, (mount,), of length two: + − − + on a rectangle."""
    pattern = np.linalg.svd(plane(positions).T)[2][-1]
    return np.asarray(2.0 * pattern * np.sign(pattern[0]))


def slab_fit(positions: Sequence[Sequence[float]]) -> Array:
    """Motion of the rigid slab that fits the mounts' displacements best, (6, 3 mounts): the inverse of `levers`."""
    return np.asarray(np.linalg.pinv(levers(positions)))
