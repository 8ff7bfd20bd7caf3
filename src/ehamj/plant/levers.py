"""How a rigid body's small motion moves its points: the one lever p + θ × r, the plane of the mounts, and its fit."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def lever(point: ArrayLike) -> Array:
    """Displacement x, y, z [m] of a point per x, y, z [m] and rx, ry, rz [rad] of the origin: p + θ × r, (3, 6)."""
    x, y, z = np.asarray(point, float)
    return np.array([[1, 0, 0, 0, z, -y], [0, 1, 0, -z, 0, x], [0, 0, 1, y, -x, 0]], float)


def plane(positions: Sequence[Sequence[float]]) -> Array:
    """Height of each mount [m] per heave [m], roll and pitch [rad]: columns 1, y, −x, shape (mount, 3)."""
    return np.array([[1.0, y, -x] for x, y in positions])


def plane_fit(positions: Sequence[Sequence[float]]) -> Array:
    """Heave [m], roll and pitch [rad] of the plane that fits the mounts' heights best, per height, (3, mount)."""
    return np.asarray(np.linalg.pinv(plane(positions)))


def warp(positions: Sequence[Sequence[float]]) -> Array:
    """Pattern of forces at four mounts that moves nothing, (mount,), of length two: + − − + on a rectangle."""
    pattern = np.linalg.svd(plane(positions).T)[2][-1]
    return np.asarray(2.0 * pattern * np.sign(pattern[0]))


def slab(positions: Sequence[Sequence[float]]) -> Array:
    """Displacement of each mount and axis per degree of freedom of a rigid slab [m/m, m/rad], (mount, axis, dof)."""
    return np.array([lever((x, y, 0.0)) for x, y in positions])


def slab_fit(positions: Sequence[Sequence[float]]) -> Array:
    """Motion of the rigid slab that fits the mounts' displacements best, (dof, mount·axis): the inverse of `slab`."""
    return np.asarray(np.linalg.pinv(slab(positions).reshape(-1, 6)))
