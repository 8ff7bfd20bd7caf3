"""Mass, springs, dampers and oil of the machine as matrices from closed forms, for many designs at once.

Every array may have leading axes, one element per design. Coordinates are the model's joints
(`ehamj.plant.axes.JOINTS`) at the mount plane's centre, then the plates of flexible feet; deviations from a static
equilibrium at small rotations.
Sources: docs/physics.md, sections 2 and 3.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ehamj.arrays import Array
from ehamj.isolator.fluid import ATMOSPHERE
from ehamj.plant.axes import JOINTS
from ehamj.plant.bodies import Body
from ehamj.plant.plant import Plant

NEWTON_STEPS = 3
"""From level to the static equilibrium; micro-radians need one."""

_X, _Y, _Z, _RX, _RY, _RZ = (JOINTS.index(dof) for dof in ("x", "y", "z", "rx", "ry", "rz"))

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
    ``mounts`` holds `ACTUATOR_VALUES`, the positions ``x`` and ``y`` [m] and ``moving_volume`` (0 or 1). SI, spools in
    mA.
    """

    common: Mapping[str, Array]
    mounts: Mapping[str, Array]

    @classmethod
    def of(cls, plant: Plant) -> "Values":
        """The values of one plant, shapes () and (mount,)."""
        common = {"gravity": np.asarray(plant.gravity), **of_body(plant.machine.body)}
        common["pressure"] = np.asarray(plant.supply.pressure)
        common["tank_pressure"] = np.asarray(plant.supply.tank_pressure)
        mounts = {name: [getattr(a, name) for a in plant.actuators] for name in ACTUATOR_VALUES}
        mounts["x"], mounts["y"] = ([position[k] for position in plant.positions] for k in range(2))
        mounts["moving_volume"] = [float(a.moving_volume) for a in plant.actuators]
        return cls(
            {name: np.asarray(value, float) for name, value in common.items()},
            {name: np.asarray(value, float) for name, value in mounts.items()},
        )

    @property
    def middle(self) -> Array:
        """Pressure of all chambers at rest, (P_s + P_t)/2 [Pa]: both edges of a port leak alike."""
        return 0.5 * (self.common["pressure"] + self.common["tank_pressure"])


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

    Motions per coordinate: ``along``, ``across`` (…, mount, n) of each foot in x and y, ``plate`` (…, mount, n) of each
    plate in z, ``foot`` (…, mount, n) of each machine foot over its plate (zero where it is rigid), ``cg`` (…, 6, n) of
    the centre of gravity and the machine's rotation, in the axes of the ground; ``spin`` (…, 3, n) the rotation in
    those of the machine, which stands tilted where its centre of gravity is off the centre.
    """

    values: Values
    mass: Array
    """Mass matrix (…, n, n)."""
    toppling: Array
    """What gravity takes from the stiffness (…, n, n): m g h on rocking."""
    along: Array
    across: Array
    plate: Array
    foot: Array
    cg: Array
    spin: Array

    @classmethod
    def of(cls, values: Values, tilt: Array | None = None) -> "Elements":
        """Build them about a ``tilt`` (…, 2), rx and ry at rest [rad]; level without.

        A foot is flexible where its stiffness is finite, which must be so in all designs or in none.
        """
        common, at = values.common, values.mounts
        shape = np.broadcast_shapes(*(value.shape for value in common.values()), *(v.shape[:-1] for v in at.values()))
        mounts = at["foot_stiffness"].shape[-1]
        flexible = np.isfinite(at["foot_stiffness"]).reshape(-1, mounts)
        if (flexible != flexible[0]).any():
            raise ValueError("foot_stiffness: must be finite in all designs, or infinite in all")
        soft = np.flatnonzero(flexible[0])
        n = len(JOINTS) + soft.size
        along, across, up, plate = np.zeros((4, *shape, mounts, n))
        x, y = (np.broadcast_to(at[name], (*shape, mounts)) for name in "xy")
        along[..., _X], along[..., _RZ] = 1.0, -y
        across[..., _Y], across[..., _RZ] = 1.0, x
        up[..., _Z], up[..., _RX], up[..., _RY] = 1.0, y, -x
        plate[...] = up
        plate[..., soft, :] = 0.0
        plate[..., soft, len(JOINTS) + np.arange(soft.size)] = 1.0
        cg, spin, lift = _turning(common, shape, n, np.zeros((*shape, 2)) if tilt is None else tilt)
        own = body_of(common)
        carried = np.broadcast_to(own.mass[..., None], (*shape, 3))
        mass = _quadratic(cg[..., :3, :], carried) + np.swapaxes(spin, -1, -2) @ own.tensor @ spin
        mass = mass + _quadratic(plate, at["plate_mass"])
        toppling = np.zeros((*shape, n, n))
        rocking = np.array([_RX, _RY])
        toppling[..., rocking[:, None], rocking] = -(common["mass"] * common["gravity"])[..., None, None] * lift
        return cls(values, mass, toppling, along, across, plate, up - plate, cg, spin)

    @classmethod
    def at_rest(cls, values: Values) -> tuple["Elements", Array]:
        """About the static equilibrium under gravity, and the stroke of each mount there, (…, mount) [m].

        Level, and NaN, where the stiffness is singular.
        """
        found = cls.of(values)
        rest = found._rest(np.zeros(found.mass.shape[:-1]))
        for _ in range(NEWTON_STEPS):
            tilt = np.nan_to_num(rest[..., [_RX, _RY]], nan=0.0, posinf=0.0, neginf=0.0)
            found = cls.of(values, tilt)
            rest = found._rest(rest)
        return found, np.asarray(np.einsum("...in,...n->...i", found.plate, rest))

    def supports(self, kind: str) -> tuple[tuple[str, Array, Array], ...]:
        """Membranes and feet: what resists which motion (…, mount, n), and how much (…, mount) [N/m or N s/m];
        ``kind`` stiffness or damping."""
        at = self.values.mounts
        return (
            ("lateral membranes", self.along, at[f"lateral_{kind}"]),
            ("lateral membranes", self.across, at[f"lateral_{kind}"]),
            ("vertical membranes", self.plate, at[f"membrane_{kind}"]),
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

    def _rest(self, near: Array) -> Array:
        """Static equilibrium under gravity and the oil's mean pressure, (…, n): one step of Newton's from ``near``, at
        whose tilt these elements are."""
        at, common = self.values.mounts, self.values.common
        oil = at["piston_area"] * (1.0 - at["area_ratio"]) * self.values.middle[..., None]
        load = np.einsum("...in,...i->...n", self.plate, oil - at["plate_mass"] * common["gravity"][..., None])
        load = load - (common["mass"] * common["gravity"])[..., None] * self.cg[..., 2, :]
        return solve(self.stiffness, (load - np.einsum("...nm,...m->...n", self.toppling, near))[..., None])[..., 0]


def _turning(common: Mapping[str, Array], shape: tuple[int, ...], n: int, tilt: Array) -> tuple[Array, Array, Array]:
    """``cg`` and ``spin`` of `Elements` at a tilt, and the CG's height over rx and ry in second order, (…, 2, 2).

    The joints turn in the order rz, rx, ry, each about an axis that those before have turned; rz is zero at rest.
    """
    sx, sy = np.sin(tilt[..., 0]), np.sin(tilt[..., 1])
    qx, qy = np.cos(tilt[..., 0]), np.cos(tilt[..., 1])
    one, zero = np.ones(shape), np.zeros(shape)
    cx, cy, cz = (np.broadcast_to(common[f"cg.{k}"], shape) for k in range(3))
    across, up = qy * cx + sy * cz, qy * cz - sy * cx  # after ry
    place = np.stack([across, qx * cy - sx * up, sx * cy + qx * up], axis=-1)
    axes = {_RZ: (zero, zero, one), _RX: (one, zero, zero), _RY: (zero, qx, sx)}
    turned = {_RZ: (-qx * sy, sx, qx * qy), _RX: (qy, zero, sy), _RY: (zero, one, zero)}  # in the machine's axes
    cg, spin = np.zeros((*shape, 6, n)), np.zeros((*shape, 3, n))
    cg[..., range(3), [_X, _Y, _Z]] = 1.0
    for joint, axis in axes.items():
        about = np.stack(axis, axis=-1)
        cg[..., :3, joint], cg[..., 3:, joint] = np.cross(about, place), about
        spin[..., joint] = np.stack(turned[joint], axis=-1)
    mixed = -sx * -across
    lift = np.stack([np.stack([-place[..., 2], mixed], -1), np.stack([mixed, -qx * up], -1)], -2)
    return cg, spin, lift


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
