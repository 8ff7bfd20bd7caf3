"""Slides as children of the machine's body, each on a joint along its rail that goes as the slide's profile says.

The joint has an armature beside which nothing counts, and a force of armature times the wanted acceleration: gravity,
the reaction on the machine, its changing inertia and the terms of the slide's speed are then the engine's own. The
joint's coordinate counts from where the slide starts.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

import mujoco
import numpy as np

from ehamj.arrays import Array
from ehamj.compiled import kernel
from ehamj.memory import SLIDE
from ehamj.mujoco.unpacking import through
from ehamj.plant.axes import JOINTS
from ehamj.plant.bodies import Body, principal_of
from ehamj.plant.plant import Plant
from ehamj.signals import Signal

ARMATURE: Final = 1e9
"""Armature of a slide's joint over the slide's mass: what pulls at the slide changes its acceleration by 1e-9 of what
it would be, which each step puts right."""

FIRST: Final = len(JOINTS)
"""Place of the first slide's coordinate among those of the model; the plates' follow."""


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


def add_slides(spec: mujoco.MjSpec, plant: Plant) -> None:
    """Add each slide to the machine's body, where it starts."""
    for slide in plant.slides:
        body = spec.body("machine").add_body(name=f"slide {slide.name}", pos=list(slide.place(slide.begins)))
        put_body(body, slide.body(slide.begins)._replace(cg=np.zeros(3)))
        joint = body.add_joint(name=f"slide {slide.name}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=list(slide.along))
        joint.armature = ARMATURE * slide.mass


def scaled_as_without(model: mujoco.MjModel, plant: Plant) -> None:
    """Let the constraint solver's scale be that of a machine whose slides have no armature."""
    if plant.slides:
        armature = sum(ARMATURE * slide.mass for slide in plant.slides)
        model.stat.meaninertia -= armature / model.nv


@kernel
def push_slides(machine, s, force):  # type: ignore[no-untyped-def]
    """Add the forces of the slides' drives at the fraction ``s`` of a step."""
    for k in range(machine.slides.size):
        own = machine.slides[k]
        force[FIRST + k] += through(own.start, own.middle, own.end, s)


@kernel
def place_slides(machine):  # type: ignore[no-untyped-def]
    """Put slides where they are to be at the end of a step."""
    for k in range(machine.slides.size):
        machine.qpos[FIRST + k], machine.qvel[FIRST + k] = machine.slides[k].place, machine.slides[k].speed


@kernel
def write_slides(machine, driven):  # type: ignore[no-untyped-def]
    """Hand a step what drives the slides, (slide, field) as `SLIDE`."""
    for k in range(machine.slides.size):
        own = machine.slides[k]
        own.start, own.middle, own.end = driven[k, 0], driven[k, 1], driven[k, 2]
        own.place, own.speed = driven[k, 3], driven[k, 4]


class Pace(NamedTuple):
    """What lets a slide end each of some steps where its profile is."""

    accelerations: Array
    """At the start, in the middle and at the end of each step (step, 3) [m/s²]."""
    place: Array
    """Coordinate at the end of each step [m]."""
    speed: Array
    """[m/s]"""


def paced(course: Signal, times: Array, timestep: float) -> Pace:
    """The pace of a slide in the steps that begin at each of ``times`` [s] but the last, where the last ends.

    Accelerations at start, middle and end of a step are those that let the integrator, whose weights of velocity are
    1, 4, 1 and of position 1, 2, 0, end where the profile is: so momentum and its moment are exact also in a step
    within which the jerk changes, and the order of the whole is kept.
    """
    x, v, a = course.sample(times)
    place = 6.0 * (np.diff(x) - timestep * v[:-1]) / timestep**2
    speed = 6.0 * np.diff(v) / timestep
    middle = 0.5 * (place - a[:-1])
    return Pace(np.column_stack([a[:-1], middle, speed - a[:-1] - 4.0 * middle]), x[1:], v[1:])


def drives(plant: Plant, courses: Sequence[Signal], first: int, steps: int, timestep: float) -> Array:
    """What drives the slides in some steps, (step, slide, field) as `SLIDE`: forces of their `paced` accelerations."""
    times = np.arange(first, first + steps + 1, dtype=np.float64) * timestep
    found = np.zeros((steps, len(courses), len(SLIDE.names or ())))
    for k, (slide, course) in enumerate(zip(plant.slides, courses, strict=True)):
        accelerations, place, speed = paced(course, times, timestep)
        carried = (1.0 + ARMATURE) * slide.mass
        found[:, k] = np.column_stack([carried * accelerations, place - slide.begins, speed])
    return found
