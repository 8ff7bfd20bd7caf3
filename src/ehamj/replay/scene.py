"""The moving machine: the drawn model's shapes, and poses with the motion exaggerated about the equilibrium."""

import itertools
import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import mujoco
import numpy as np
import rerun as rr
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from ehamj.estimate.remembered import remembered
from ehamj.mujoco.model import build_spec
from ehamj.plant.kinematics import points_displaced
from ehamj.plant.levers import slab_fit
from ehamj.plant.plant import Plant
from ehamj.plant.slide import Slide
from ehamj.replay.recording import TIMELINE, Array, entity, fixed, moving
from ehamj.result import Result

LARGEST_DRAWN = 0.12
"""Largest motion in the picture with automatic exaggeration [m]: a pad's half height, so that nothing collides."""

POSE_RATE = 200.0
"""Poses per second [Hz], unless the motion needs more."""

POSES_PER_PERIOD = 20.0
MOST_POSES = 120_000

GHOST = (235, 240, 245, 70)


class Pose(NamedTuple):
    """Motion of one body in the picture: translation (n, 3) [m], quaternion xyzw (n, 4), or None if it never turns."""

    translation: Array
    quaternion: Array | None = None


def exaggeration_for(results: Iterable[Result]) -> float:
    """The factor, one of 1, 2, 5·10ⁿ, that draws the largest motion of any result about `LARGEST_DRAWN` high."""
    largest = max((_largest_motion(result) for result in results), default=0.0)
    return nice(LARGEST_DRAWN / largest) if largest > 0.0 else 1.0


def nice(value: float) -> float:
    """The nearest of 1, 2, 5·10ⁿ, by ratio."""
    exponent = math.floor(math.log10(value))
    candidates = [float(f"{digit}e{exponent + up}") for up, digits in ((0, (1, 2, 5)), (1, (1,))) for digit in digits]
    return min(candidates, key=lambda candidate: abs(math.log(candidate / value)))


def main_frequency(results: Iterable[Result]) -> float:
    """Frequency of the vertical motion [Hz]: RMS velocity over RMS displacement of feet and ground.

    Where hardly anything moves vertically, that of all motion; 0 at rest.
    """
    squares = np.zeros((2, 3))  # of displacement and velocity, per axis
    for result in results:
        rows = drawn_rows(result)
        for name in ("ground", "foot"):
            moved = result.dataset[f"{name}_displacement"].values[rows]
            rate = result.dataset[f"{name}_velocity"].values[rows]
            if len(moved):
                squares += _squares(moved, rate)
    displacement, velocity = squares[:, 2] if squares[0, 2] > 1e-4 * squares[0].sum() else squares.sum(axis=1)
    return math.sqrt(velocity / displacement) / (2 * math.pi) if displacement > 0.0 else 0.0


@remembered(16)
def _squares(moved: Array, rate: Array) -> Array:
    """Sums over mounts of the mean squares of a displacement about its mean and of a velocity, (2, axis)."""
    about = moved - moved.mean(axis=0)
    return np.array([np.einsum("tma,tma->a", part, part) for part in (about, rate)]) / len(moved)


def log_scene(recording: rr.RecordingStream, label: str, result: Result, factor: float) -> None:
    """Log one result's machine: shapes once, a ghost of it at rest, and poses over time, ``factor`` times exaggerated.

    The result's ``label`` is the first part of every path.
    """
    model = drawn_model(result)
    log_shapes(recording, label, model)
    rows = pose_rows(result)
    log_poses(recording, label, poses(result, model, factor, rows), result.dataset.time.values[rows])


def log_poses(
    recording: rr.RecordingStream, label: str, found: Mapping[str, Pose], time: Array, timeline: str = TIMELINE
) -> None:
    """Log the poses of bodies at each time [s]."""
    for body, pose in found.items():
        columns = rr.Transform3D.columns(translation=pose.translation, quaternion=pose.quaternion)
        moving(recording, entity(label, "world", body), time, columns, timeline)


def drawn_model(result: Result) -> mujoco.MjModel:
    """The model that ran, with its drawing; built again from the scenario where the stored one cannot be read."""
    try:
        return mujoco.MjModel.from_xml_string(result.model_xml)
    except ValueError:
        return build_spec(result.scenario.plant, 1e-4, drawn=True).compile()


def poses(result: Result, model: mujoco.MjModel, factor: float, rows: np.ndarray) -> dict[str, Pose]:
    """Pose of every drawn body at some rows: rest position plus ``factor`` times the motion about the equilibrium;
    slides go along their rails as far as they do."""

    def moved(name: str) -> Array:
        values = result.dataset[name].values
        return factor * (values[rows] - values[:1])

    machine, ground, foot, stroke = (
        moved(name) for name in ("machine_displacement", "ground_displacement", "foot_displacement", "stroke")
    )
    plant = result.scenario.plant
    slab = fitted_slab(ground, plant)
    found = {
        "machine": Pose(machine[:, :3], quaternion(machine[:, 3:])),
        "floor": Pose(slab[:, :3], quaternion(slab[:, 3:])),
    }
    for k, slide in enumerate(plant.slides):
        # It goes as far as it goes, on a machine whose motion is exaggerated.
        coordinate = result.dataset["slide"].values[rows, k]
        found[f"slide {slide.name}"] = on_rail(slide, coordinate, found["machine"])
    for mount, (name, direction) in enumerate(zip(plant.mounts, plant.directions, strict=True)):
        found[f"pad {name}"] = Pose(model.body(f"pad {name}").pos + ground[:, mount], pad_turn(model, name, len(rows)))
        if plant.plates == "sliding":
            # The model's plate has its stroke only; drawn, it goes sideways with the foot that stands on it.
            along = np.array(direction)
            ahead = ground[:, mount] @ along + stroke[:, mount] - foot[:, mount] @ along
            plate = foot[:, mount] + ahead[:, None] * along
            found[f"plate {name}"] = Pose(model.body(f"plate {name}").pos + plate)
    return found


def on_rail(slide: Slide, coordinate: ArrayLike, machine: Pose) -> Pose:
    """A slide at coordinates (n,) [m] on a machine that moves."""
    places = np.array(slide.position) + np.multiply.outer(np.asarray(coordinate, float), slide.along)
    turns = machine.quaternion
    return Pose(machine.translation + Rotation.from_quat(turns).apply(places), turns)


def pad_turn(model: mujoco.MjModel, mount: str, rows: int) -> Array | None:
    """Quaternion xyzw (rows, 4) of a pad that stands on its side; None of an upright one."""
    turn = model.body(f"pad {mount}").quat[[1, 2, 3, 0]]
    return None if turn[3] == 1.0 else np.tile(turn, (rows, 1))


def quaternion(angles: Array) -> Array:
    """Rotation by yaw rz, then rx, then ry about the turned axes, as quaternion xyzw, shape (n, 4).

    Args:
        angles: rx, ry, rz [rad], shape (n, 3); the order of turns is that of `ehamj.plant.kinematics`.
    """
    (sx, sy, sz), (cx, cy, cz) = np.sin(0.5 * angles.T), np.cos(0.5 * angles.T)
    x, y = cz * sx * cy - sz * cx * sy, cz * cx * sy + sz * sx * cy
    z, w = sz * cx * cy + cz * sx * sy, cz * cx * cy - sz * sx * sy
    return np.column_stack([x, y, z, w])


def fitted_slab(ground: Array, plant: Plant) -> Array:
    """Motion of the rigid slab closest to the ground below the mounts: x, y, z, rx, ry, rz, shape (n, 6)."""
    return ground.reshape(len(ground), 3 * len(plant.mounts)) @ slab_fit(plant.positions).T


def drawn_rows(result: Result) -> slice:
    """Rows that can be drawn: all up to the first that is not finite."""
    names = ("machine_displacement", "ground_displacement", "foot_displacement", "stroke")
    return slice(0, min(_finite_rows(result.dataset[name].values) for name in names))


@remembered(32)
def _finite_rows(values: Array) -> int:
    """Rows before the first that is not finite."""
    finite = np.isfinite(values)
    return len(values) if finite.all() else int(np.argmin(finite.reshape(len(values), -1).all(axis=1)))


def pose_rows(result: Result) -> np.ndarray:
    """Rows at which poses are logged."""
    count = len(range(*drawn_rows(result).indices(result.dataset.time.size)))
    rate = max(POSE_RATE, POSES_PER_PERIOD * main_frequency([result]))
    every = max(1, math.floor(result.scenario.record_rate / rate), math.ceil(count / MOST_POSES))
    return np.arange(0, count, every)


def _largest_motion(result: Result) -> float:
    """Largest displacement from the equilibrium of a corner of the machine or of the ground below a mount [m]."""
    rows = drawn_rows(result)
    machine = result.dataset.machine_displacement.values[rows]
    ground = result.dataset.ground_displacement.values[rows]
    if not len(machine):
        return 0.0
    return _reach(machine, ground, result.scenario.machine.size)


@remembered(16)
def _reach(machine: Array, ground: Array, size: tuple[float, float, float]) -> float:
    """Largest way of a moved box's corners (time, DOFS), and of the ground (time, mount, axis) [m]."""
    length, width, height = size
    corners = list(itertools.product((-length / 2, length / 2), (-width / 2, width / 2), (0.0, height)))
    ways = [path - path[0] for path in (ground, *points_displaced(machine, corners))]
    return math.sqrt(max(float(np.einsum("...a,...a->...", way, way).max()) for way in ways))


def log_shapes(recording: rr.RecordingStream, label: str, model: mujoco.MjModel) -> None:
    """The model's geoms, static, below their bodies; the machine and its plates once more as a ghost that stays."""
    fixed(recording, entity(label, "world"), rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    for geom in range(model.ngeom):
        name = model.geom(geom).name or f"geom {geom}"
        body = model.body(model.geom_bodyid[geom]).name
        owner = name if body == "world" else body  # what stands on the world, the floor, moves as a body of its own
        path = entity(label, "world", owner, "geoms", name)
        color = tuple(np.round(255 * model.geom_rgba[geom]).astype(int))
        fixed(recording, path, _shape(model, geom, color, "solid"))
        if owner in ("machine", "floor") and not name.startswith(("plate", "foot")):  # no ghost of what the bed hides
            fixed(recording, entity(label, "world", "ghost", name), _shape(model, geom, GHOST, "majorwireframe"))


def _shape(model: mujoco.MjModel, geom: int, color: tuple[int, ...], fill: str) -> rr.Boxes3D | rr.Cylinders3D:
    """A geom as a Rerun shape in its body's frame; other kinds than box and cylinder as their bounding box."""
    centre, size = model.geom_pos[geom], model.geom_size[geom]
    turn = model.geom_quat[geom][[1, 2, 3, 0]]  # wxyz → xyzw
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return rr.Cylinders3D(
            radii=[size[0]], lengths=[2 * size[1]], centers=[centre], quaternions=[turn], colors=[color], fill_mode=fill
        )
    half = size if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_BOX else model.geom_aabb[geom, 3:]
    return rr.Boxes3D(half_sizes=[half], centers=[centre], quaternions=[turn], colors=[color], fill_mode=fill)
