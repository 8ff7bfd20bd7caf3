"""Parameters → MjSpec → MjModel.

The machine has three slides and three hinges in the mount plane. Its plates are bodies on slide joints along their
actions (``sliding``), or inertia and weight on the stroke coordinates themselves (``tied``): with rigid feet the same
equations. Membranes are plain joint and tendon properties, so that the model stands by itself in any viewer; the
callbacks of `ehamj.mujoco` add the oil and the ground's share.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco

from ehamj.errors import InputError
from ehamj.memory import ISOLATOR, MACHINE_BODY, Row, rows, size, userdata_size
from ehamj.mujoco.drawing import draw
from ehamj.mujoco.membranes import add_lateral_membranes
from ehamj.mujoco.plates import add_plate, check_plates
from ehamj.mujoco.slides import add_slides, put_body, scaled_as_without
from ehamj.plant.plant import Plant

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


@cache
def _begun(drawn: bool) -> mujoco.MjSpec:
    """The template, with its geometry or without; read once, as a copy takes less. Nobody is to change it."""
    spec = mujoco.MjSpec.from_file(str(template()))
    if not drawn:
        for geom in list(spec.geoms):
            spec.delete(geom)
    return spec


def build_spec(plant: Plant, timestep: float, drawn: bool = False) -> mujoco.MjSpec:
    """The model as an editable MjSpec.

    Args:
        plant: what is simulated.
        timestep: integration step [s]; the rigid-foot constraint is tuned to it.
        drawn: with geometry and movable ground pads, to look at; without, for speed. The physics is the same.

    Raises:
        InputError: if the plant cannot be built with these plates.
    """
    check_plates(plant)
    spec = _begun(drawn).copy()
    spec.option.timestep = timestep
    spec.option.gravity = [0.0, 0.0, -plant.gravity]
    spec.nuserdata = userdata_size(len(plant.mounts), len(plant.slides))
    spec.nuser_actuator = size(ISOLATOR)
    put_body(spec.body("machine"), (plant.carrier or plant.machine).body)
    add_slides(spec, plant)
    add_lateral_membranes(spec, plant)
    table = rows(plant)
    isolators, others = table[: len(plant.mounts)], table[len(plant.mounts) :]
    for mount, row in enumerate(isolators):
        _add_actuator(spec, row, add_plate(spec, plant, mount, timestep), biastype=mujoco.mjtBias.mjBIAS_USER)
    for row in others:  # states without a force of their own: an actuator on the heave joint with no gear
        _add_actuator(spec, row, ("z", mujoco.mjtTrn.mjTRN_JOINT), gear=[0.0] * 6)
    if plant.plates == "tied" or not any(actuator.rigid_foot for actuator in plant.actuators):
        spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    if drawn:
        draw(spec, plant)
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
    """The compiled model; see `build_spec`.

    Raises:
        InputError: as `build_spec`, and if the engine refuses masses or inertias.
    """
    spec = build_spec(plant, timestep, drawn)
    try:
        model = spec.compile()
    except ValueError as error:
        said = str(error).splitlines()[0].removeprefix("Error: ")
        raise InputError(f"machine, part, slide, mount, actuators: the engine cannot build them, {said}") from error
    if model.body("machine").id != MACHINE_BODY:
        raise RuntimeError(f"the machine is body {model.body('machine').id} of the model, not {MACHINE_BODY}")
    model.tendon_invweight0[:] *= CONSTRAINT_SOFTENING
    scaled_as_without(model, plant)
    return model


def reduced(plant: Plant) -> Plant:
    """The plant with its plates tied if all feet are rigid: the same equations without the constraint's own modes."""
    rigid = all(actuator.rigid_foot for actuator in plant.actuators)
    return replace(plant, plates="tied") if rigid else plant


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
