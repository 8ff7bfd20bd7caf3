"""Parameters → MjSpec → MjModel.

The machine has three slides and three hinges in the mount plane. Its plates are bodies on vertical slide joints
(``sliding``), or inertia and weight on the stroke coordinates themselves (``tied``): with rigid feet the same
equations. Membranes are plain joint and tendon properties, so that the model stands by itself in any viewer; the
callbacks of `ehamj.mujoco` add the oil and the ground's share.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np
from numpy.typing import NDArray

from ehamj.isolator.actuator import Actuator
from ehamj.memory import ISOLATOR, MACHINE_BODY, Row, rows, size, userdata_size
from ehamj.plant.bodies import Body, principal_of
from ehamj.plant.plant import Plant
from ehamj.settings import Vector3

FOOT_HEIGHT = 0.08
PLATE_HALF_HEIGHT = 0.03
PAD_HALF_HEIGHT = 0.12
PAD_HEIGHT = -2 * PLATE_HALF_HEIGHT - PAD_HALF_HEIGHT
"""Heights of the drawing [m]."""

CONSTRAINT_SOFTENING = 1e-3
"""Factor on the compliance of the rigid-foot constraint.

MuJoCo's constraint is a spring of about m_plate/((1 − d)τ²) with d ≤ 0.9999, which at a step of 1e-4 s costs 1e-4 of
the response. Its compliance is proportional to the tendon's inverse weight in the compiled model; scaled by this factor
it no longer shows beside the integration error, while the constraint's time constant τ stays.
"""


def template() -> Path:
    """The MJCF that every model starts from: beside the package when installed, ``models/`` in a checkout."""
    candidates = [Path(__file__).parents[1] / "models", Path(__file__).parents[3] / "models"]
    for folder in candidates:
        if (folder / "machine.xml").is_file():
            return folder / "machine.xml"
    raise FileNotFoundError(f"machine.xml is in none of {', '.join(map(str, candidates))}; reinstall ehamj")


def build_spec(plant: Plant, timestep: float, drawn: bool = False) -> mujoco.MjSpec:
    """The model as an editable MjSpec.

    Args:
        plant: what is simulated.
        timestep: integration step [s]; the rigid-foot constraint is tuned to it.
        drawn: with geometry and movable ground pads, to look at; without, for speed. The physics is the same.

    Raises:
        ValueError: if the plant cannot be built with these plates.
    """
    _check_plates(plant)
    spec = mujoco.MjSpec.from_file(str(template()))
    spec.option.timestep = timestep
    spec.option.gravity = [0.0, 0.0, -plant.gravity]
    spec.nuserdata = userdata_size(len(plant.mounts))
    spec.nuser_actuator = size(ISOLATOR)
    body, machine = spec.body("machine"), plant.machine
    put_body(body, machine.body)
    _add_lateral_membranes(spec, plant)
    table = rows(plant)
    isolators, others = table[: len(plant.mounts)], table[len(plant.mounts) :]
    for row, position, actuator in zip(isolators, plant.positions, plant.actuators, strict=True):
        stroke = _add_tied_plate if plant.plates == "tied" else _add_sliding_plate
        target = stroke(spec, row.name, position, actuator, timestep)
        _add_actuator(spec, row, target, biastype=mujoco.mjtBias.mjBIAS_USER)
    for row in others:  # states without a force of their own: an actuator on the heave joint with no gear
        _add_actuator(spec, row, ("z", mujoco.mjtTrn.mjTRN_JOINT), gear=[0.0] * 6)
    if plant.plates == "tied" or not any(actuator.rigid_foot for actuator in plant.actuators):
        spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    if drawn:
        _draw(spec, plant)
    else:
        for geom in list(spec.geoms):
            spec.delete(geom)
    return spec


def drawn_xml(plant: Plant, timestep: float) -> str:
    """The drawn model as MJCF, with the actuators' parameters to the last digit.

    MuJoCo's own writer takes numbers for zero that are small beside others of a row, as a flow gain is beside a bulk
    modulus.
    """
    spec = build_spec(plant, timestep, drawn=True)
    tree = ElementTree.fromstring(spec.to_xml())
    written = {actuator.name: actuator.userdata for actuator in spec.actuators}
    for element in tree.iterfind("actuator/general"):
        element.set("user", " ".join(repr(float(value)) for value in written[element.get("name", "")]))
    return ElementTree.tostring(tree, encoding="unicode")


def build_model(plant: Plant, timestep: float, drawn: bool = False) -> mujoco.MjModel:
    """The compiled model; see `build_spec`."""
    spec = build_spec(plant, timestep, drawn)
    model = spec.compile()
    if model.body("machine").id != MACHINE_BODY:
        raise RuntimeError(f"the machine is body {model.body('machine').id} of the model, not {MACHINE_BODY}")
    model.tendon_invweight0[:] *= CONSTRAINT_SOFTENING
    return model


def reduced(plant: Plant) -> Plant:
    """The plant with its plates tied if all feet are rigid: the same equations without the constraint's own modes."""
    rigid = all(actuator.rigid_foot for actuator in plant.actuators)
    return replace(plant, plates="tied") if rigid else plant


def put_body(element: mujoco.MjsBody, body: Body) -> None:
    """Give a body of the model its mass, centre of gravity and inertia."""
    element.mass, element.ipos, element.explicitinertial = float(body.mass), body.cg.tolist(), True
    if np.any(body.tensor - np.diag(np.diag(body.tensor))):
        moments, axes = principal_of(body.tensor)
        moments[2] = min(moments[2], moments[0] + moments[1])  # a flat body that was turned has rounded
        turn = np.empty(4)
        mujoco.mju_mat2Quat(turn, axes.ravel())
        element.inertia, element.iquat = moments.tolist(), turn.tolist()
    else:
        element.inertia = np.diag(body.tensor).tolist()


def _add_actuator(spec: mujoco.MjSpec, row: Row, target: tuple[str, mujoco.mjtTrn], **others: Any) -> None:
    spec.add_actuator(
        name=row.name,
        target=target[0],
        trntype=target[1],
        dyntype=mujoco.mjtDyn.mjDYN_USER,
        actdim=row.states,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        gainprm=[0.0] * 10,
        userdata=row.values,
        **others,
    )


def _check_plates(plant: Plant) -> None:
    for name, actuator in zip(plant.mounts, plant.actuators, strict=True):
        if plant.plates == "tied" and not actuator.rigid_foot:
            raise ValueError(
                f"plates = 'tied' needs rigid feet, but the actuator of {name} has foot_stiffness = "
                f"{actuator.foot_stiffness:g} N/m; use plates = 'sliding'"
            )
        if plant.plates == "sliding" and actuator.plate_mass <= 0:
            raise ValueError(
                f"plates = 'sliding' needs plates with mass, but the actuator of {name} has plate_mass = "
                f"{actuator.plate_mass:g} kg; use plates = 'tied'"
            )


def _add_lateral_membranes(spec: mujoco.MjSpec, plant: Plant) -> None:
    """Lateral stiffness and damping of all mounts together, about their elastic centre (exact for small yaw).

    Σk[(x − y_i·rz)² + (y + x_i·rz)²] = K(x − ȳ·rz)² + K(y + x̄·rz)² + (Σk r_i² − K r̄²)·rz²
    """
    r = np.array(plant.positions)[:, :2]
    for kind in ("stiffness", "damping"):
        k = np.array([getattr(actuator, f"lateral_{kind}") for actuator in plant.actuators])
        total = float(k.sum())
        if total == 0.0:
            continue
        centre = k @ r / total
        yaw = float(k @ (r**2).sum(axis=1)) - total * float(centre @ centre)
        _put(spec.joint("rz"), **{kind: yaw})
        if np.abs(centre).max() < 1e-12:
            for axis in "xy":
                _put(spec.joint(axis), **{kind: total})
            continue
        for axis, lever in (("x", -centre[1]), ("y", centre[0])):
            tendon = spec.add_tendon(name=f"lateral {kind} {axis}")
            tendon.wrap_joint(axis, 1.0)
            tendon.wrap_joint("rz", float(lever))
            _put(tendon, **{kind: total})


def _put(element: object, **linear: float) -> None:
    """Set linear coefficients of the polynomials of stiffness or damping."""
    for kind, value in linear.items():
        polynomial = getattr(element, kind).copy()
        polynomial[0] = value
        setattr(element, kind, polynomial)


def _foot_height(tendon: object, position: Vector3, sign: float = 1.0) -> None:
    """Let a fixed tendon measure z + y·rx − x·ry."""
    x, y, _ = position
    for joint, coefficient in (("z", 1.0), ("rx", y), ("ry", -x)):
        if coefficient != 0.0:
            tendon.wrap_joint(joint, sign * coefficient)  # type: ignore[attr-defined]


def _add_tied_plate(
    spec: mujoco.MjSpec, name: str, position: Vector3, actuator: Actuator, timestep: float
) -> tuple[str, mujoco.mjtTrn]:
    tendon = spec.add_tendon(name=f"stroke {name}", armature=actuator.plate_mass)
    _foot_height(tendon, position)
    _put(tendon, stiffness=actuator.membrane_stiffness, damping=actuator.membrane_damping)
    tendon.springlength = [0.0, 0.0]
    return tendon.name, mujoco.mjtTrn.mjTRN_TENDON


def _add_sliding_plate(
    spec: mujoco.MjSpec, name: str, position: Vector3, actuator: Actuator, timestep: float
) -> tuple[str, mujoco.mjtTrn]:
    m = actuator.plate_mass
    plate = spec.worldbody.add_body(name=f"plate {name}", pos=[*position[:2], -PLATE_HALF_HEIGHT], mass=m)
    # It cannot turn: the inertia has no effect. Without ipos the inertia is lost when the spec is written as XML.
    plate.inertia, plate.ipos, plate.explicitinertial = [m * 0.01] * 3, [0.0, 0.0, 0.0], True
    joint = plate.add_joint(name=f"plate {name}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0.0, 0.0, 1.0])
    _put(joint, stiffness=actuator.membrane_stiffness, damping=actuator.membrane_damping)
    foot = spec.add_tendon(name=f"foot {name}")
    foot.wrap_joint(joint.name, 1.0)
    _foot_height(foot, position, sign=-1.0)
    if actuator.rigid_foot:
        tie = spec.add_equality(name=f"foot {name}", type=mujoco.mjtEq.mjEQ_TENDON, name1=foot.name)
        tie.objtype = mujoco.mjtObj.mjOBJ_TENDON
        tie.solref, tie.solimp = [timestep, 1.0], [0.9999, 0.9999, 0.001, 0.5, 2.0]
    else:
        _put(foot, stiffness=actuator.foot_stiffness, damping=actuator.foot_damping)
        foot.springlength = [0.0, 0.0]
    return joint.name, mujoco.mjtTrn.mjTRN_JOINT


def _draw(spec: mujoco.MjSpec, plant: Plant) -> None:
    """Stretch the drawing to the machine's size; add feet, plates and ground pads that can be moved."""
    machine = spec.body("machine")
    stretch: NDArray[np.float64] = np.array(plant.machine.size) / (2.2, 1.6, 1.9)
    for geom in machine.geoms:
        geom.pos = geom.pos * stretch
        geom.size = geom.size * (stretch if geom.type == mujoco.mjtGeom.mjGEOM_BOX else stretch[[0, 2, 2]])
    floor = spec.geom("floor")
    floor.size = [0.8 * plant.machine.size[0], 0.8 * plant.machine.size[1], floor.size[2]]
    for name, position in zip(plant.mounts, plant.positions, strict=True):
        machine.add_geom(
            spec.find_default("steel"),
            name=f"foot {name}",
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=[0.06, FOOT_HEIGHT / 2, 0.0],
            pos=[*position[:2], FOOT_HEIGHT / 2],
        )
        carrier, height = (machine, -PLATE_HALF_HEIGHT) if plant.plates == "tied" else (spec.body(f"plate {name}"), 0.0)
        offset = [*position[:2], height] if plant.plates == "tied" else [0.0, 0.0, height]
        carrier.add_geom(spec.find_default("plate"), name=f"plate {name}", pos=offset)
        pad = spec.worldbody.add_body(name=f"pad {name}", pos=[*position[:2], PAD_HEIGHT], mocap=True)
        pad.add_geom(spec.find_default("pad"), name=f"pad {name}")
