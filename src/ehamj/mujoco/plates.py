"""The pressure plates: bodies on slide joints along their actions, or inertia on the stroke coordinates themselves."""

import mujoco
import numpy as np

from ehamj.errors import InputError
from ehamj.mujoco.membranes import put
from ehamj.plant.axes import DOFS
from ehamj.plant.plant import Plant
from ehamj.settings import Vector3

HALF_HEIGHT = 0.03
"""Half the height of a plate [m]."""


def check_plates(plant: Plant) -> None:
    """Refuse plates that the model cannot have.

    Raises:
        InputError: which names the actuator.
    """
    for name, actuator in zip(plant.mounts, plant.actuators, strict=True):
        if plant.plates == "tied" and not actuator.rigid_foot:
            raise InputError(
                f"plates = 'tied' needs rigid feet, but the actuator of {name} has foot_stiffness = "
                f"{actuator.foot_stiffness:g} N/m; use plates = 'sliding'"
            )
        if plant.plates == "sliding" and actuator.plate_mass <= 0:
            raise InputError(
                f"plates = 'sliding' needs plates with mass, but the actuator of {name} has plate_mass = "
                f"{actuator.plate_mass:g} kg; use plates = 'tied'"
            )


def add_plate(spec: mujoco.MjSpec, plant: Plant, mount: int, timestep: float) -> tuple[str, mujoco.mjtTrn]:
    """Add the plate of a mount; what the isolator acts on: the name of a joint or tendon, and which."""
    return (_add_tied if plant.plates == "tied" else _add_sliding)(spec, plant, mount, timestep)


def below(place: Vector3, along: Vector3, distance: float) -> list[float]:
    """The point on the axis of a mount at a distance behind its foot, seen from the machine [m]."""
    return [float(entry) for entry in np.array(place) - distance * np.array(along)]


def _wrap_foot(tendon: object, row: np.ndarray, sign: float = 1.0) -> None:
    """Let a fixed tendon measure the foot along its action, J·q: z + y·rx − x·ry of an upright one."""
    for joint, coefficient in zip(DOFS, row, strict=True):
        if coefficient != 0.0:
            tendon.wrap_joint(joint, sign * float(coefficient))  # type: ignore[attr-defined]


def _add_tied(spec: mujoco.MjSpec, plant: Plant, mount: int, timestep: float) -> tuple[str, mujoco.mjtTrn]:
    actuator = plant.actuators[mount]
    tendon = spec.add_tendon(name=f"stroke {plant.mounts[mount]}", armature=actuator.plate_mass)
    _wrap_foot(tendon, plant.layout.rows[mount])
    put(tendon, stiffness=actuator.membrane_stiffness, damping=actuator.membrane_damping)
    tendon.springlength = [plant.heights[mount]] * 2
    return tendon.name, mujoco.mjtTrn.mjTRN_TENDON


def _add_sliding(spec: mujoco.MjSpec, plant: Plant, mount: int, timestep: float) -> tuple[str, mujoco.mjtTrn]:
    name, along, actuator = plant.mounts[mount], plant.directions[mount], plant.actuators[mount]
    m = actuator.plate_mass
    at = below(plant.positions[mount], along, HALF_HEIGHT)
    plate = spec.worldbody.add_body(name=f"plate {name}", pos=at, mass=m)
    # It cannot turn: the inertia has no effect. Without ipos the inertia is lost when the spec is written as XML.
    plate.inertia, plate.ipos, plate.explicitinertial = [m * 0.01] * 3, [0.0, 0.0, 0.0], True
    joint = plate.add_joint(name=f"plate {name}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=list(along))
    joint.springref = plant.heights[mount]
    put(joint, stiffness=actuator.membrane_stiffness, damping=actuator.membrane_damping)
    foot = spec.add_tendon(name=f"foot {name}")
    foot.wrap_joint(joint.name, 1.0)
    _wrap_foot(foot, plant.layout.rows[mount], sign=-1.0)
    if actuator.rigid_foot:
        tie = spec.add_equality(name=f"foot {name}", type=mujoco.mjtEq.mjEQ_TENDON, name1=foot.name)
        tie.objtype = mujoco.mjtObj.mjOBJ_TENDON
        tie.solref, tie.solimp = [timestep, 1.0], [0.9999, 0.9999, 0.001, 0.5, 2.0]
    else:
        put(foot, stiffness=actuator.foot_stiffness, damping=actuator.foot_damping)
        foot.springlength = [0.0, 0.0]
    return joint.name, mujoco.mjtTrn.mjTRN_JOINT
