"""What the model looks like: the machine at its size, feet, plates and the ground's pads, each along its action."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from ehamj.mujoco.plates import HALF_HEIGHT, below
from ehamj.plant.plant import Plant
from ehamj.settings import Vector3

FOOT_HEIGHT = 0.08
PAD_HALF_HEIGHT = 0.12
PAD_DEPTH = 2 * HALF_HEIGHT + PAD_HALF_HEIGHT
PAD_RADIUS = 0.17
POST_RADIUS = 0.07
"""Lengths of the drawing, along a mount's action [m]."""

SLIDE_COLOUR = (0.20, 0.55, 0.45, 1.0)

FLOOR = -(PAD_DEPTH + PAD_HALF_HEIGHT)
"""Height of the floor of the drawing [m] where all mounts are upright and in the mount plane."""


def floor_height(plant: Plant) -> float:
    """Height of the floor of the drawing [m]: below the lowest pad."""
    return min(FLOOR, *(round(centre - reach, 9) for centre, reach in _pads(plant).values()))


def _pads(plant: Plant) -> dict[str, tuple[float, float]]:
    """Of each mount's pad: height of its centre, and how far it reaches below [m]."""
    return {
        name: (
            below(place, along, PAD_DEPTH)[2],
            PAD_HALF_HEIGHT * abs(along[2]) + PAD_RADIUS * float(np.hypot(*along[:2])),
        )
        for name, place, along in zip(plant.mounts, plant.positions, plant.directions, strict=True)
    }


def upright_to(along: Vector3) -> list[float]:
    """The quaternion that turns up into a direction."""
    found = np.zeros(4)
    mujoco.mju_quatZ2Vec(found, np.array(along))
    return [float(entry) for entry in found]


def draw(spec: mujoco.MjSpec, plant: Plant) -> None:
    """Stretch the drawing to the machine's size; add feet, plates, ground pads that can be moved, and slides."""
    machine = spec.body("machine")
    stretch: NDArray[np.float64] = np.array(plant.machine.size) / (2.2, 1.6, 1.9)
    for geom in machine.geoms:
        geom.pos = geom.pos * stretch
        geom.size = geom.size * (stretch if geom.type == mujoco.mjtGeom.mjGEOM_BOX else stretch[[0, 2, 2]])
    for slide in plant.slides:
        spec.body(f"slide {slide.name}").add_geom(
            spec.find_default("steel"),
            name=f"slide {slide.name}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[0.5 * side for side in slide.size],
            rgba=list(SLIDE_COLOUR),
        )
    for name, place, along in zip(plant.mounts, plant.positions, plant.directions, strict=True):
        turned = upright_to(along)
        machine.add_geom(
            spec.find_default("steel"),
            name=f"foot {name}",
            type=mujoco.mjtGeom.mjGEOM_CYLINDER,
            size=[0.06, FOOT_HEIGHT / 2, 0.0],
            pos=below(place, along, -FOOT_HEIGHT / 2),
            quat=turned,
        )
        tied = plant.plates == "tied"
        carrier = machine if tied else spec.body(f"plate {name}")
        offset = below(place, along, HALF_HEIGHT) if tied else [0.0, 0.0, 0.0]
        carrier.add_geom(spec.find_default("plate"), name=f"plate {name}", pos=offset, quat=turned)
        pad = spec.worldbody.add_body(name=f"pad {name}", pos=below(place, along, PAD_DEPTH), quat=turned, mocap=True)
        pad.add_geom(spec.find_default("pad"), name=f"pad {name}")
    _lay_floor(spec, plant)


def _lay_floor(spec: mujoco.MjSpec, plant: Plant) -> None:
    """Lay the floor below the lowest pad; pads that do not reach it stand on posts, which move with them."""
    floor = spec.geom("floor")
    floor.size = [0.8 * plant.machine.size[0], 0.8 * plant.machine.size[1], floor.size[2]]
    top = floor_height(plant)
    floor.pos = floor.pos - [0.0, 0.0, FLOOR - top]
    for name, (centre, reach) in _pads(plant).items():
        height = centre - top
        if height - reach < 1e-6:
            continue
        pad, up, back = spec.body(f"pad {name}"), np.zeros(3), np.zeros(4)
        mujoco.mju_negQuat(back, pad.quat)
        mujoco.mju_rotVecQuat(up, np.array([0.0, 0.0, 1.0]), back)
        pad.add_geom(
            spec.find_default("pad"),
            name=f"post {name}",
            size=[POST_RADIUS, height / 2, 0.0],
            pos=(-height / 2 * up).tolist(),
            quat=back.tolist(),
        )
