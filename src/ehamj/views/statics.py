"""The machine at rest: where it stands, what each mount carries, and the shims that level it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import mujoco
import numpy as np

from ehamj.arrays import Array
from ehamj.errors import InputError, did_you_mean
from ehamj.memory import activations
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import EquilibriumError, Inputs, equilibrium
from ehamj.mujoco.model import build_model, reduced
from ehamj.plant.axes import AXES, DOF_OF_JOINT, DOFS
from ehamj.plant.kinematics import points_motion
from ehamj.plant.plant import Plant
from ehamj.plant.statics import check_standing, level_shims
from ehamj.scenario.load import Given, as_scenario

GOALS: Final = {
    "level": "as thin as may be",
    "equal": "mounts carry loads as equal as may be, and the machine stands where it was built",
}
"""What shims are to do, beside that the machine stands without tilt."""


@dataclass(frozen=True)
class StaticLoads:
    """What each mount carries at rest, valves centred and ground at zero; arrays have one row per mount."""

    plant: Plant
    displacement: Array
    """Of the mount plane's centre from unloaded membranes (6,): x, y, z [m], rx, ry, rz [rad]."""
    along: Array
    """Force of membrane and oil along each mount's direction [N]; positive carries."""
    oil: Array
    """What of it the oil carries [N]."""
    across: Array
    """Force of the lateral membranes on the machine (mount, axis) [N]."""
    guided: Array
    """What of each plate's weight its guide carries, across the mount (mount, axis) [N]."""
    stroke: Array
    """[m]."""

    @property
    def weight(self) -> float:
        """Of machine and plates [N]."""
        return self.plant.total_mass * self.plant.gravity

    @property
    def tilt(self) -> float:
        """Angle between the mount plane and the level [rad]."""
        rx, ry = self.displacement[[DOFS.index("rx"), DOFS.index("ry")]]
        across = math.hypot(math.sin(rx), math.cos(rx) * math.sin(ry))  # of the third row of the turn: no loss near 0
        return math.atan2(across, math.cos(rx) * math.cos(ry))

    def shims(self, goal: str = "level") -> Array:
        """Heights of shims (mount,) [m], in place of those that are there, that make the machine stand without tilt.

        Args:
            goal: one of `GOALS`; loads as equal as may be are those of the pseudo-inverse of Jᵀ.

        Raises:
            InputError: if no shims do.
        """
        if goal not in GOALS:
            raise InputError(f"shims {goal!r}: {did_you_mean(goal, GOALS)}must be one of {', '.join(GOALS)}")
        try:
            return level_shims(self.plant, self.oil, goal == "equal")
        except ValueError as error:
            raise InputError(f"shims: {error}") from error

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        mounts = {
            name: {
                "along_n": float(self.along[k]),
                "oil_n": float(self.oil[k]),
                "across_n": dict(zip(AXES, self.across[k].tolist(), strict=True)),
                "guided_n": dict(zip(AXES, self.guided[k].tolist(), strict=True)),
                "stroke_m": float(self.stroke[k]),
                "shim_m": self.plant.heights[k],
            }
            for k, name in enumerate(self.plant.mounts)
        }
        layout = self.plant.layout
        return {
            "weight_n": self.weight,
            "displacement": dict(zip(DOFS, self.displacement.tolist(), strict=True)),
            "tilt_rad": self.tilt,
            "mounts": mounts,
            "actuated": list(layout.motions),
            "self_stress": list(layout.stress_names),
        }


def static_loads(scenario: Given, places: Mapping[str, float] | None = None) -> StaticLoads:
    """What each mount of a scenario's machine carries at rest, over-determined layouts included.

    It is the equilibrium that a run starts from, with valves centred: membranes and oil side by side, finite rotations.
    Each mount's loads and the weight balance: Σ (along·d + across + guided) = weight.

    Args:
        scenario: a scenario; a shipped name or a file serves too.
        places: where slides stand, coordinates by name [m]; without, where they start.

    Raises:
        InputError: if the machine cannot stand, or a slide not there.
    """
    plant = replace(reduced(as_scenario(scenario).plant.locked(places)), bookkeeping=False)
    model = build_model(plant, 1e-4)
    data = mujoco.MjData(model)
    try:
        check_standing(plant, gravity=True)
        with hydraulics():
            state = equilibrium(model, data, Inputs.rest(model))
    except (ValueError, EquilibriumError) as error:
        raise InputError(str(error)) from error
    displacement = state[list(DOF_OF_JOINT)]
    isolators = activations(model, state[model.nq + model.nv :]).isolators
    least = [actuator.vapour_pressure for actuator in plant.actuators]
    return loads_at(plant, displacement, *(np.maximum(isolators[name], least) for name in ("pressure_1", "pressure_2")))


def loads_at(plant: Plant, displacement: Array, pressure_1: Array, pressure_2: Array) -> StaticLoads:
    """Loads of mounts whose machine is moved by ``displacement`` (6,) [m, rad] and whose chambers have pressures [Pa].

    The foot of a plate that is bound with stiffness gives way beside it: its stroke is found from what both carry.
    """
    still = np.zeros((1, 6))
    feet = np.array([x[0] for x, _, _ in points_motion(displacement[None], still, still, plant.positions)])
    directions, actuators = np.array(plant.directions), plant.actuators
    down = np.array([[a.plate_mass * -plant.gravity] for a in actuators]) * [[0.0, 0.0, 1.0]]
    oil = np.array([
        a.piston_area * one - a.piston_area_2 * two
        for a, one, two in zip(actuators, pressure_1, pressure_2, strict=True)
    ])  # fmt: skip
    lift = (feet * directions).sum(axis=1)
    heavy = (down * directions).sum(axis=1)
    stroke = lift - np.array(plant.heights)
    for k, a in enumerate(actuators):
        if not a.rigid_foot:  # K (plate − h) = oil + weight + k_f (foot − plate)
            push = oil[k] + heavy[k] + a.foot_stiffness * stroke[k]
            stroke[k] = push / (a.membrane_stiffness + a.foot_stiffness)
    along = oil - np.array([a.membrane_stiffness for a in actuators]) * stroke
    sideways = feet - lift[:, None] * directions
    across = -np.array([[a.lateral_stiffness] for a in actuators]) * sideways
    return StaticLoads(plant, displacement, along, oil, across, heavy[:, None] * directions - down, stroke)
