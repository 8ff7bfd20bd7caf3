"""Mass, springs and dampers of the machine as matrices from closed forms, for many designs at once.

Every array may have leading axes, one element per design. Coordinates are the model's joints
(`ehamj.plant.axes.JOINTS`) at the mount plane's centre, then the plates of flexible feet along their mounts; deviations
from a static equilibrium. Feet turn with the machine, and their strokes are projections on the mounts' directions; as
it is simulated, those of upright mounts in the mount plane are linear, and so are the plates' inertia and flexible
feet.
Sources: docs/physics.md, sections 2 and 3.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.linear.values import Values, body_of
from ehamj.plant.axes import AXES, DOFS, JOINTS
from ehamj.plant.kinematics import rotations
from ehamj.plant.plant import Plant

NEWTON_STEPS = 3
"""From level to the static equilibrium; micro-radians need one."""

_SHIFTS = [JOINTS.index(dof) for dof in DOFS[:3]]
_TURNS = [JOINTS.index(dof) for dof in DOFS[3:]]
"""Columns of x, y, z and of rx, ry, rz."""


def coordinates(plant: Plant) -> tuple[str, ...]:
    """Names of the coordinates of a plant's `Elements`, as states of the linear model have them."""
    soft = (name for name, a in zip(plant.mounts, plant.actuators, strict=True) if not a.rigid_foot)
    return (*JOINTS, *(f"plate {name}" for name in soft))


@dataclass(frozen=True)
class Elements:
    """What the machine is made of; n coordinates, leading axes are designs.

    Motions per coordinate: ``along`` and ``across`` (…, mount, n) of each foot in the two directions across its mount,
    which are x and y of an upright one; ``plate`` (…, mount, n) of each plate along its mount, ``foot`` (…, mount, n)
    of each machine foot over its plate (zero where it is rigid), ``cg`` (…, 6, n) of the centre of gravity and the
    machine's rotation, in the axes of the ground; ``spin`` (…, 3, n) the rotation in those of the machine, which stands
    tilted where its centre of gravity is off the centre.
    """

    values: Values
    mass: Array
    """Mass matrix (…, n, n)."""
    toppling: Array
    """What gravity takes from the stiffness (…, n, n): m g h on rocking, and loads of mounts off the mount plane."""
    along: Array
    across: Array
    plate: Array
    foot: Array
    cg: Array
    spin: Array
    load: Array
    """Generalised force (…, n) of gravity, membranes and the oil's mean pressure here: zero at rest."""
    stroke: Array
    """Stroke of each mount here [m], (…, mount)."""

    @classmethod
    def of(cls, values: Values, place: Array | None = None) -> "Elements":
        """Build them about a ``place`` (…, n), the coordinates there [m, rad]; level and unloaded without.

        A foot is flexible where its stiffness is finite, which must be so in all designs or in none.
        """
        common, at = values.common, values.mounts
        shape = np.broadcast_shapes(*(value.shape for value in common.values()), *(v.shape[:-1] for v in at.values()))
        soft = _flexible(at["foot_stiffness"])
        n = len(JOINTS) + soft.size
        q = np.zeros((*shape, n)) if place is None else np.broadcast_to(place, (*shape, n))
        angles = np.nan_to_num(q[..., _TURNS], nan=0.0, posinf=0.0, neginf=0.0)
        feet, moved, curved = _feet(values, shape, q, angles)
        along, across, own = np.moveaxis(np.einsum("mkx,...mxn->...mkn", values.frames, feet), -2, 0)
        shifts = np.einsum("mkx,...mx->...mk", values.frames, moved)
        level = np.einsum("mx,...mxn->...mn", values.frames[:, 2], _feet(values, shape, q, np.zeros((*shape, 3)))[0])
        plates = np.zeros((soft.size, n))
        plates[:, len(JOINTS) :] = np.eye(soft.size)
        plate, swung = own.copy(), level.copy()
        swung[..., soft, :] = plates
        plate[..., soft, :] += plates - level[..., soft, :]
        height = shifts[..., 2] + np.einsum("...mn,...n->...m", swung - level, q)
        stroke = height - at["height"]
        cg, spin, lift = _turning(common, shape, n, angles)
        mass = _quadratic(swung, at["plate_mass"]) + _inertia(common, shape, cg, spin)
        oil = at["piston_area"] * (1.0 - at["area_ratio"]) * values.middle[..., None]
        push = oil - at["plate_mass"] * common["gravity"][..., None] * values.frames[:, 2, 2]
        push = push - at["membrane_stiffness"] * stroke
        squeeze = -np.where(np.isinf(at["foot_stiffness"]), 0.0, at["foot_stiffness"]) * (shifts[..., 2] - height)
        on_foot = -at["lateral_stiffness"][..., None] * shifts
        on_foot[..., 2] = push
        weight = -common["mass"] * common["gravity"]
        toppling = np.zeros((*shape, n, n))
        hanging = np.einsum("...mk,mkx,...mxij->...ij", on_foot, values.frames, curved)
        toppling[..., np.array(_TURNS)[:, None], _TURNS] = weight[..., None, None] * lift + hanging
        load = weight[..., None] * cg[..., 2, :]
        sideways = (along, on_foot[..., 0]), (across, on_foot[..., 1])
        for motion, force in (*sideways, (plate, push), (own - plate, squeeze)):
            load = load + np.einsum("...in,...i->...n", motion, force)
        return cls(values, mass, toppling, along, across, plate, own - plate, cg, spin, load, stroke)

    @classmethod
    def at_rest(cls, values: Values) -> "Elements":
        """About the static equilibrium under gravity; level, with strokes NaN, where the stiffness is singular."""
        found = cls.of(values)
        rest = np.zeros(found.load.shape)
        for _ in range(NEWTON_STEPS):
            rest = rest + solve(found.stiffness, found.load[..., None])[..., 0]
            found = cls.of(values, rest)
        return found

    def supports(self, kind: str) -> tuple[tuple[str, Array, Array], ...]:
        """Membranes and feet: what resists which motion (…, mount, n), and how much (…, mount) [N/m or N s/m];
        ``kind`` stiffness or damping."""
        at = self.values.mounts
        return (
            ("lateral membranes", self.along, at[f"lateral_{kind}"]),
            ("lateral membranes", self.across, at[f"lateral_{kind}"]),
            ("axial membranes", self.plate, at[f"membrane_{kind}"]),
            ("feet", self.foot, np.where(np.isfinite(at["foot_stiffness"]), at[f"foot_{kind}"], 0.0)),
        )

    @property
    def stiffness(self) -> Array:
        """Stiffness (…, n, n) of membranes and feet, gravity's toppling included; without oil."""
        return sum(_quadratic(motion, own) for _, motion, own in self.supports("stiffness")) - self.toppling

    @property
    def damping(self) -> Array:
        """Damping (…, n, n) of membranes and feet."""
        return np.asarray(sum(_quadratic(motion, own) for _, motion, own in self.supports("damping")))


def _flexible(stiffness: Array) -> NDArray[np.intp]:
    """Mounts whose feet are flexible."""
    finite = np.isfinite(stiffness).reshape(-1, stiffness.shape[-1])
    if (finite != finite[0]).any():
        raise ValueError("foot_stiffness: must be finite in all designs, or infinite in all")
    return np.flatnonzero(finite[0])


def _feet(values: Values, shape: tuple[int, ...], q: Array, angles: Array) -> tuple[Array, Array, Array]:
    """Motion of the machine's feet at coordinates ``q``, angles (…, 3) among them.

    Returns:
        Per coordinate (…, mount, 3, n); displacement (…, mount, 3) [m]; and second derivatives over the rotations
        (…, mount, 3, 3, 3). Where constant levers serve, feet move as when the machine is level.
    """
    places = np.stack([np.broadcast_to(values.mounts[axis], (*shape, len(values.frames))) for axis in AXES], axis=-1)
    flat = np.broadcast_to(values.level_enough, shape)
    excess, first, second = rotations(np.where(flat[..., None], 0.0, angles))
    motion = np.zeros((*places.shape, q.shape[-1]))
    motion[..., range(3), _SHIFTS] = 1.0
    motion[..., _TURNS] = np.einsum("...jxy,...my->...mxj", first, places)
    linear = np.einsum("...mxj,...j->...mx", motion[..., _TURNS], angles)
    turned = np.where(flat[..., None, None], linear, np.einsum("...xy,...my->...mx", excess, places))
    curved = np.einsum("...jkxy,...my->...mxjk", second, places) * np.logical_not(flat)[..., None, None, None, None]
    return motion, q[..., None, _SHIFTS] + turned, curved


def _inertia(common: Mapping[str, Array], shape: tuple[int, ...], cg: Array, spin: Array) -> Array:
    """Mass matrix (…, n, n) of the machine."""
    own = body_of(common)
    carried = np.broadcast_to(own.mass[..., None], (*shape, 3))
    return np.asarray(_quadratic(cg[..., :3, :], carried) + np.swapaxes(spin, -1, -2) @ own.tensor @ spin)


def _turning(common: Mapping[str, Array], shape: tuple[int, ...], n: int, angles: Array) -> tuple[Array, Array, Array]:
    """``cg`` and ``spin`` of `Elements` at angles (…, 3), and the second derivatives of the CG's height over them,
    (…, 3, 3)."""
    place = np.stack([np.broadcast_to(common[f"cg.{k}"], shape) for k in range(3)], axis=-1)
    excess, first, second = rotations(angles)
    turned = np.swapaxes(np.eye(3) + excess, -1, -2)[..., None, :, :]
    cg, spin = np.zeros((*shape, 6, n)), np.zeros((*shape, 3, n))
    cg[..., range(3), _SHIFTS] = 1.0
    cg[..., :3, _TURNS] = np.einsum("...jxy,...y->...xj", first, place)
    cg[..., 3:, _TURNS] = np.swapaxes(_axis(first @ turned), -1, -2)
    spin[..., _TURNS] = np.swapaxes(_axis(turned @ first), -1, -2)
    return cg, spin, np.einsum("...jky,...y->...jk", second[..., 2, :], place)


def _axis(rate: Array) -> Array:
    """Vector (…, 3) whose cross product a skew matrix (…, 3, 3) is."""
    return np.stack([rate[..., 2, 1], rate[..., 0, 2], rate[..., 1, 0]], axis=-1)


def _quadratic(motion: Array, weight: Array) -> Array:
    """Σ w u uᵀ over the rows u of ``motion`` (…, k, n), weights (…, k)."""
    return np.asarray(np.einsum("...in,...i,...im->...nm", motion, weight, motion))


def solve(matrix: Array, right: Array) -> Array:
    """Batched solution, NaN where a matrix is singular."""
    try:
        return np.asarray(np.linalg.solve(matrix, right), float)
    except np.linalg.LinAlgError:
        shape = np.broadcast_shapes(matrix.shape[:-2], right.shape[:-2])
        matrix, right = (np.broadcast_to(part, (*shape, *part.shape[-2:])) for part in (matrix, right))
        found = np.full(right.shape, np.nan)
        for at in np.ndindex(*shape):
            if np.linalg.matrix_rank(matrix[at]) == matrix.shape[-1]:
                found[at] = np.linalg.solve(matrix[at], right[at])
        return found
