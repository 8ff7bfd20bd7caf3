"""Rigid bodies and what they make together: mass, centre of gravity, tensor of inertia."""

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ehamj.arrays import Array
from ehamj.settings import Vector3

Tensor3 = tuple[Vector3, Vector3, Vector3]
Inertia = Vector3 | Tensor3
"""Moments of inertia about x, y, z, or the whole tensor, row by row [kg m²]."""

ROUNDING: Final = 1e-9
"""Share of the largest entry by which a tensor may miss symmetry, and its principal values the rule of triangles: what
a drawing's nine digits leave."""


def tensor_of(inertia: Inertia) -> Array:
    """The tensor (3, 3) [kg m²] of either form."""
    values = np.array(inertia, float)
    return np.diag(values) if values.ndim == 1 else values


def written_inertia(tensor: ArrayLike) -> Inertia:
    """A tensor as a scenario states it: three numbers where there are no products."""
    rows = np.asarray(tensor, float)
    if np.any(rows - np.diag(np.diag(rows))):
        return tuple(tuple(map(float, row)) for row in rows)  # type: ignore[return-value]
    return tuple(map(float, np.diag(rows)))  # type: ignore[return-value]


def box_inertia(mass: float, size: Vector3) -> Vector3:
    """Principal inertia of a homogeneous box about its centre [kg m²]: m/12 times the other two sides' squares."""
    a, b, c = (side**2 for side in size)
    return (mass / 12 * (b + c), mass / 12 * (a + c), mass / 12 * (a + b))


def check_inertia(name: str, inertia: Inertia, point: bool = False) -> None:
    """Refuse what is the inertia of no rigid body; a ``point`` may have none.

    Raises:
        ValueError: naming the key, the value and what is allowed.
    """
    given, tensor = np.array(inertia, float), tensor_of(inertia)
    text, size = f"{name} = {given.tolist()}", float(np.abs(tensor).max())
    if np.abs(tensor - tensor.T).max() > ROUNDING * size:
        k, j = np.unravel_index(int(np.argmax(np.abs(tensor - tensor.T))), (3, 3))
        raise ValueError(
            f"{text} must be symmetric: the product of inertia in row {k + 1}, column {j + 1} is {tensor[k, j]:g}, "
            f"in row {j + 1}, column {k + 1} it is {tensor[j, k]:g} kg m²"
        )
    if point and size == 0.0:
        return
    principal = np.sort(np.diag(tensor)) if given.ndim == 1 else np.linalg.eigvalsh(tensor)
    if principal[0] <= 0:
        what = "positive in each entry" if given.ndim == 1 else "positive definite; its least principal value is "
        raise ValueError(f"{text} must be {what}" + (f"{principal[0]:g} kg m²" if given.ndim == 2 else ""))
    a, b, c = principal
    # Three numbers as the engine has it, to the last bit; what was turned has rounded.
    if a + b < c * (1.0 if given.ndim == 1 else 1.0 - ROUNDING):
        each = "entry" if given.ndim == 1 else f"principal value ({a:g}, {b:g}, {c:g} kg m²)"
        raise ValueError(f"{text} is of no rigid body: each {each} is at most the sum of the other two")


def principal_of(tensor: Array) -> tuple[Array, Array]:
    """Principal moments (3,) [kg m²] and the right-handed axes that belong to them, in columns (3, 3)."""
    values, axes = np.linalg.eigh(0.5 * (tensor + tensor.T))
    return values, axes * np.sign(np.linalg.det(axes))


class Body(NamedTuple):
    """A rigid body; each entry may have leading axes."""

    mass: Array
    """[kg]"""
    cg: Array
    """Centre of gravity (…, 3) [m]."""
    tensor: Array
    """Inertia about it (…, 3, 3) [kg m²]."""

    @classmethod
    def of(cls, mass: float, cg: ArrayLike, inertia: Inertia) -> "Body":
        """Of plain values."""
        return cls(np.asarray(mass, float), np.asarray(cg, float), tensor_of(inertia))


def joined(bodies: Sequence[Body]) -> Body:
    """The one rigid body that several make: masses add up, tensors about the common centre of gravity (Steiner)."""
    mass = np.asarray(sum(body.mass for body in bodies))
    cg = np.asarray(sum(body.mass[..., None] * body.cg for body in bodies)) / mass[..., None]
    tensor = np.zeros((3, 3))
    for body in bodies:
        d = body.cg - cg
        square = (d * d).sum(axis=-1)[..., None, None]
        moved = body.mass[..., None, None] * (square * np.eye(3) - d[..., :, None] * d[..., None, :])
        tensor = tensor + body.tensor + moved
    return Body(mass, cg, tensor)
