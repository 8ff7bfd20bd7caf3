"""How a rigid body's small motion moves its points: the one lever p + θ × r, and the slab that fits them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array

MOTIONS = ("heave", "roll", "pitch")
"""Motions that upright mounts drive."""


def lever(point: ArrayLike) -> Array:
    """Displacement x, y, z [m] of a point per x, y, z [m] and rx, ry, rz [rad] of the origin: p + θ × r, (3, 6).

    ``point`` is x, y, z [m], or x, y where it lies in the mount plane.
    """
    x, y, z = (*np.asarray(point, float), 0.0)[:3]
    return np.array([[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0]], float)


def levers(points: Sequence[ArrayLike] | Array) -> Array:
    """`lever` of several points below each other, shape (3 points, 6)."""
    return np.concatenate([lever(point) for point in points])


def slab_fit(positions: Sequence[Sequence[float]]) -> Array:
    """Motion of the rigid slab that fits the mounts' displacements best, (6, 3 mounts): the inverse of `levers`."""
    return np.asarray(np.linalg.pinv(levers(positions)))


def cross_axes(along: ArrayLike) -> Array:
    """Two unit vectors at right angles to one and to each other, the first of them level, (2, 3): x and y of up."""
    up = np.asarray(along, float)
    x, y, _ = up
    flat = float(np.hypot(x, y))
    # Numbers near the least that there is have no digits to divide.
    level = np.array([1.0, 0.0, 0.0]) if flat < 1e-150 else np.array([y, -x, 0.0]) / flat
    return np.array([level, np.cross(up, level)])
