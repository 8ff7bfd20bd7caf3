"""Lateral membranes of all mounts together, as joint properties and fixed tendons."""

from typing import Final

import mujoco
import numpy as np

from ehamj.arrays import Array
from ehamj.plant.axes import DOFS
from ehamj.plant.plant import Plant
from ehamj.plant.statics import assembled

NOTHING: Final = 1e-12
"""Share of the largest stiffness below which a direction has none."""


def put(element: object, **linear: float) -> None:
    """Set linear coefficients of the polynomials of stiffness or damping."""
    for kind, value in linear.items():
        polynomial = getattr(element, kind).copy()
        polynomial[0] = value
        setattr(element, kind, polynomial)


KINDS: Final = ("stiffness", "damping")


def add_lateral_membranes(spec: mujoco.MjSpec, plant: Plant) -> None:
    """Stiffness and damping of the membranes across the mounts' actions, about the machine at rest."""
    values = {kind: np.array([getattr(actuator, f"lateral_{kind}") for actuator in plant.actuators]) for kind in KINDS}
    there = {kind: k for kind, k in values.items() if k.sum() > 0.0}
    if plant.level_enough:
        for kind, k in there.items():
            _add_level(spec, plant, kind, k)
    elif there:
        _add_general(spec, plant, there)


def _add_level(spec: mujoco.MjSpec, plant: Plant, kind: str, k: Array) -> None:
    """Of upright mounts in the mount plane, about their elastic centre (exact for small yaw).

    Σk[(x − y_i·rz)² + (y + x_i·rz)²] = K(x − ȳ·rz)² + K(y + x̄·rz)² + (Σk r_i² − K r̄²)·rz²
    """
    r, total = np.array(plant.positions)[:, :2], float(k.sum())
    centre = k @ r / total
    yaw = float(k @ (r**2).sum(axis=1)) - total * float(centre @ centre)
    put(spec.joint("rz"), **{kind: yaw})
    if np.abs(centre).max() < 1e-12:
        for axis in "xy":
            put(spec.joint(axis), **{kind: total})
        return
    for axis, share in (("x", -centre[1]), ("y", centre[0])):
        tendon = spec.add_tendon(name=f"lateral {kind} {axis}")
        tendon.wrap_joint(axis, 1.0)
        tendon.wrap_joint("rz", float(share))
        put(tendon, **{kind: total})


def _add_general(spec: mujoco.MjSpec, plant: Plant, values: dict[str, Array]) -> None:
    """At most six tendons, which have stiffness and damping both.

    Two symmetric matrices of which no sum is negative are diagonal in the same coordinates, though not in orthogonal
    ones: K = Σ k w wᵀ, C = Σ c w wᵀ. Rotations count times a length, so that all entries are of one size.
    """
    scale = np.repeat([1.0, plant.layout.span], 3)
    lateral = {kind: assembled(plant, [(0.0, each) for each in k]) for kind, k in values.items()}
    matrices = {kind: matrix / np.outer(scale, scale) for kind, matrix in lateral.items()}
    total = {kind: float(np.trace(matrix)) for kind, matrix in matrices.items()}
    matrices = {kind: matrix / total[kind] for kind, matrix in matrices.items()}
    sizes, vectors = np.linalg.eigh(sum(matrices.values()))
    held = sizes > NOTHING * sizes[-1]
    root, vectors = np.sqrt(sizes[held]), vectors[:, held]
    _, turn = np.linalg.eigh(vectors.T @ next(iter(matrices.values())) @ vectors / np.outer(root, root))
    unit = vectors / root @ turn
    shares = {kind: np.maximum(np.einsum("ji,jk,ki->i", unit, matrices[kind], unit), 0.0) for kind in values}
    for number, row in enumerate((vectors * root @ turn).T):
        tendon = spec.add_tendon(name=f"lateral {number + 1}")
        for joint, share in zip(DOFS, row * scale, strict=True):
            tendon.wrap_joint(joint, float(share))
        put(tendon, **{kind: float(total[kind] * share[number]) for kind, share in shares.items()})
