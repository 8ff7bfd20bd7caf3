"""Mass, springs, dampers and oil of the machine as matrices from closed forms, for many designs at once.

Every array may have leading axes, one element per design. Coordinates are the model's joints
(`ehamj.plant.axes.JOINTS`) at the mount plane's centre, then the plates of flexible feet along their mounts; deviations
from a static equilibrium. Feet turn with the machine, and their strokes are projections on the mounts' directions; as
it is simulated, those of upright mounts in the mount plane are linear, and so are the plates' inertia and flexible
feet.
Sources: docs/physics.md, sections 2 and 3.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.arrays import Array
from ehamj.isolator.fluid import ATMOSPHERE
from ehamj.plant.axes import AXES, DOFS, JOINTS
from ehamj.plant.bodies import Body
from ehamj.plant.kinematics import rotations
from ehamj.plant.mounts import UPRIGHT
from ehamj.plant.plant import STANDARD_GRAVITY, STIFF, Plant

NEWTON_STEPS = 3
"""From level to the static equilibrium; micro-radians need one."""

_SHIFTS = [JOINTS.index(dof) for dof in DOFS[:3]]
_TURNS = [JOINTS.index(dof) for dof in DOFS[3:]]
"""Columns of x, y, z and of rx, ry, rz."""

MACHINE_VALUES = ("mass", "inertia.0", "inertia.1", "inertia.2", "cg.0", "cg.1", "cg.2")
"""Values of the machine (`ehamj.plant.machine.Machine`), entries of vectors by number; of a tensor its moments."""

PRODUCTS = {"product.xy": (0, 1), "product.xz": (0, 2), "product.yz": (1, 2)}
"""Products of inertia, and where they stand in the tensor."""

ACTUATOR_VALUES = (
    "piston_area", "chamber_volume", "bulk_modulus", "vapour_pressure", "area_ratio", "volume_share", "air_fraction",
    "polytropic_exponent", "wall_modulus", "membrane_stiffness", "membrane_damping", "lateral_stiffness",
    "lateral_damping", "plate_mass", "foot_stiffness", "foot_damping", "flow_gain", "flow_pressure",
    "edge_leakage_share", "laminar_ratio", "valve_gain", "valve_frequency", "valve_damping", "spool_stroke",
    "rated_flow", "rated_drop",
)  # fmt: skip
"""Values of an actuator (`ehamj.isolator.actuator.Actuator`) that the linear machine depends on."""


@dataclass(frozen=True)
class Values:
    """Physical values, each an array over the designs; those of the mounts with a last axis (mount,).

    ``common`` holds `MACHINE_VALUES`, `PRODUCTS` [kg m²], ``gravity``, ``pressure`` and ``tank_pressure``;
    ``mounts`` holds `ACTUATOR_VALUES`, the positions ``x``, ``y`` and ``z``, the shims ``height`` [m] and
    ``moving_volume`` (0 or 1). SI, spools in mA.
    """

    common: Mapping[str, Array]
    mounts: Mapping[str, Array]
    frames: Array
    """Axes of each mount in rows, two across it and the one along it, (mount, 3, 3): x, y, z of upright ones."""

    @classmethod
    def of(cls, plant: Plant) -> "Values":
        """The values of one plant, shapes () and (mount,)."""
        common = {"gravity": np.asarray(plant.gravity), **of_body(plant.machine.body)}
        common["pressure"] = np.asarray(plant.supply.pressure)
        common["tank_pressure"] = np.asarray(plant.supply.tank_pressure)
        own = plant.actuators
        mounts: dict[str, Sequence[float]] = {name: [getattr(a, name) for a in own] for name in ACTUATOR_VALUES}
        mounts |= {axis: [position[k] for position in plant.positions] for k, axis in enumerate(AXES)}
        mounts |= {"height": plant.heights, "moving_volume": [float(a.moving_volume) for a in own]}
        return cls(
            {name: np.asarray(value, float) for name, value in common.items()},
            {name: np.asarray(value, float) for name, value in mounts.items()},
            np.array([_frame(direction) for direction in plant.directions]),
        )

    @property
    def middle(self) -> Array:
        """Pressure of all chambers at rest, (P_s + P_t)/2 [Pa]: both edges of a port leak alike."""
        return 0.5 * (self.common["pressure"] + self.common["tank_pressure"])

    @property
    def flat(self) -> Array:
        """Designs (…,) whose mounts are all upright and in the mount plane (`ehamj.plant.plant.Plant.flat`)."""
        upright = bool((self.frames[:, 2, 2] > 1.0 - UPRIGHT).all())
        return np.asarray((self.mounts["z"] == 0.0).all(axis=-1) & upright)

    @property
    def level_enough(self) -> Array:
        """Designs (…,) whose feet move as when the machine is level (`ehamj.plant.plant.Plant.level_enough`)."""
        own = self.mounts
        oil = 4.0 * own["bulk_modulus"] * own["piston_area"] ** 2 / own["chamber_volume"]
        spring = own["membrane_stiffness"] + np.where(own["flow_pressure"] == 0.0, oil, 0.0)
        share = 1.0 / (1.0 + spring / own["foot_stiffness"])
        weight = (self.common["mass"] + own["plate_mass"].sum(axis=-1)) * STANDARD_GRAVITY
        return np.asarray(self.flat & (weight < STIFF * (spring * share).sum(axis=-1)))


def _frame(direction: ArrayLike) -> Array:
    """Two unit vectors across a direction and the direction itself, (3, 3); x, y, z of the upright one."""
    along = np.asarray(direction, float)
    if along[2] > 1.0 - UPRIGHT:
        return np.eye(3)
    first = np.eye(3)[int(np.argmin(np.abs(along)))]
    first = first - along * float(along @ first)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(along, first), along])


def coordinates(plant: Plant) -> tuple[str, ...]:
    """Names of the coordinates of a plant's `Elements`, as states of the linear model have them."""
    soft = (name for name, a in zip(plant.mounts, plant.actuators, strict=True) if not a.rigid_foot)
    return (*JOINTS, *(f"plate {name}" for name in soft))


def of_body(body: Body) -> dict[str, Array]:
    """Values of the machine, by name, of its mass properties (…,)."""
    moments = {f"inertia.{k}": body.tensor[..., k, k] for k in range(3)}
    products = {name: body.tensor[..., row, column] for name, (row, column) in PRODUCTS.items()}
    return {"mass": body.mass, **moments, **products, **{f"cg.{k}": body.cg[..., k] for k in range(3)}}


def body_of(common: Mapping[str, Array]) -> Body:
    """The other way."""
    shape = np.broadcast_shapes(*(common[name].shape for name in (*MACHINE_VALUES, *PRODUCTS)))
    cg, tensor = np.empty((*shape, 3)), np.empty((*shape, 3, 3))
    for k in range(3):
        cg[..., k], tensor[..., k, k] = common[f"cg.{k}"], common[f"inertia.{k}"]
    for name, (row, column) in PRODUCTS.items():
        tensor[..., row, column] = tensor[..., column, row] = common[name]
    return Body(np.broadcast_to(common["mass"], shape), cg, tensor)


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


@dataclass(frozen=True)
class Oil:
    """The chambers' oil about rest; last axis the mounts."""

    areas: Array
    """Areas of chambers 1 and 2 [m²], (2, …, mount)."""
    compliances: Array
    """Of chambers 1 and 2, (2, …, mount): oil that enters per pressure, walls included, V (w/β + 1/β_w) [m³/Pa]."""
    stretch: Array
    """w = 1 + (p − p₀)/β_w [-]."""
    edge: Array
    """g₀ [m³/s/Pa]."""
    cross: Array
    """c [m³/s/Pa]."""

    @classmethod
    def of(cls, values: Values, strokes: Array, pressures: tuple[Array, Array] | None = None) -> "Oil":
        """The oil with the pistons at ``strokes`` [m], chambers at ``pressures`` [Pa] (without: their middle)."""
        at, wall = values.mounts, values.mounts["wall_modulus"]
        middle = values.middle[..., None]
        areas = np.stack([at["piston_area"], at["piston_area"] * at["area_ratio"]])
        moved = at["moving_volume"] * strokes
        compliances = []
        shares = at["volume_share"], 1.0 - at["volume_share"]
        for share, swept, p in zip(shares, (areas[0], -areas[1]), pressures or (middle, middle), strict=True):
            volume = share * at["chamber_volume"] + swept * moved
            compliances.append(volume * ((1.0 + (p - ATMOSPHERE) / wall) / oil_modulus(values, p) + 1.0 / wall))
        edge = at["edge_leakage_share"] * at["flow_pressure"]
        stretch = 1.0 + (middle - ATMOSPHERE) / wall
        return cls(areas, np.stack(compliances), stretch, edge, at["flow_pressure"] - edge)

    @property
    def empty(self) -> Array:
        """Where a chamber would have no room left (…,), or there is no rest at all."""
        return np.asarray(~(self.compliances > 0.0).all(axis=(0, -1)))


def oil_modulus(values: Values, pressure: Array) -> Array:
    """Bulk modulus of oil with entrained air [Pa], as `ehamj.isolator.fluid.oil_modulus`, (…, mount)."""
    at = values.mounts
    liquid = (1.0 - at["air_fraction"]) * np.exp((ATMOSPHERE - pressure) / at["bulk_modulus"])
    gas = at["air_fraction"] * (ATMOSPHERE / pressure) ** (1.0 / at["polytropic_exponent"])
    compliance = liquid / at["bulk_modulus"] + gas / (at["polytropic_exponent"] * pressure)
    return np.asarray((liquid + gas) / compliance)


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
