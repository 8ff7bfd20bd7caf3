"""Physical values of many designs at once, as arrays: what closed forms of the linear machine are made from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ehamj.arrays import Array
from ehamj.isolator.actuator import hydraulic_stiffness, static_stiffness
from ehamj.plant.axes import AXES
from ehamj.plant.bodies import Body
from ehamj.plant.levers import cross_axes
from ehamj.plant.mounts import UPRIGHT
from ehamj.plant.plant import STANDARD_GRAVITY, STIFF, Plant

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
            np.array([[*cross_axes(direction), direction] for direction in plant.directions]),
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
        oil = hydraulic_stiffness(own["bulk_modulus"], own["piston_area"], own["chamber_volume"])
        springs = own["membrane_stiffness"] + oil * (own["flow_pressure"] == 0.0)
        held = static_stiffness(springs, own["foot_stiffness"]).sum(axis=-1)
        weight = (self.common["mass"] + own["plate_mass"].sum(axis=-1)) * STANDARD_GRAVITY
        return np.asarray(self.flat & (weight < STIFF * held))


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
