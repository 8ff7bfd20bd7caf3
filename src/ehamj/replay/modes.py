"""Replay of modes: the machine swings in each of them, exaggerated, about a ghost of itself at rest.

One page shows all modes at once, swinging steadily; on a page of its own each mode is let go and rings down, the
variants of the machine beside each other and on one clock.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import mujoco
import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import ArrayLike

from ehamj.arrays import ComplexArray
from ehamj.errors import InputError
from ehamj.linear.modes import Mode
from ehamj.linear.shapes import in_phase
from ehamj.mujoco.drawing import floor_height
from ehamj.mujoco.model import build_spec
from ehamj.plant.levers import lever, levers
from ehamj.plant.machine import Machine
from ehamj.plant.plant import Plant
from ehamj.replay.about import table
from ehamj.replay.blueprint import laid_out, scene_view
from ehamj.replay.recording import Array, Color, entity, fixed, moving, recorded, result_color
from ehamj.replay.scene import GHOST, Pose, log_poses, log_shapes, on_rail, quaternion
from ehamj.scenario.model import Scenario

TIMELINE: Final = "viewing_time"
"""Time of the viewer [s]: every mode is slowed to the same pace, and its frequency stands in its title."""

LENGTH: Final = 8.0
"""Duration of the recording [s]."""
TIMES: Final = np.arange(0.0, LENGTH + 0.01, 0.02)
"""Viewing times of the poses [s]."""
RINGINGS: Final = "ringing"
"""Where the curves of the ring-downs are logged."""
SWINGS: Final = 4
"""Whole swings of the steady picture in the recording."""
RINGING: Final = 1.0
"""Pace of a ring-down: swings of the first variant's mode per second [Hz]."""

LARGEST, FOOT_LARGEST = 0.28, 0.16
"""Largest motion drawn of any corner of the machine, and along its mount of a foot, whose plate dips into its pad
[m]."""

HEAD: Final = 0.11
"""Length of the arrows' heads [m]."""

NEAR: Final = 3.0
"""Distance of an axis from the machine's middle [m] up to which it is drawn; beyond, the machine all but translates."""

PATH_COLOR: Final[Color] = (255, 214, 64)
AXIS_COLOR: Final[Color] = (255, 72, 72)
PARTS: Final = ("bed", "column")
"""Parts of the drawing whose upper corners show their paths."""


@dataclass(frozen=True)
class Swing:
    """One mode to draw: its name, natural frequency [Hz] and damping ratio [-], and how the machine moves in it.

    ``shape`` is the complex motion of the mount plane's centre (6,) [m, rad], largest at t = 0; ``axis`` the point [m]
    and direction of the axis that it turns about, None where it translates.
    """

    name: str
    frequency: float
    damping_ratio: float
    shape: ComplexArray
    axis: tuple[Array, Array] | None

    @property
    def title(self) -> str:
        """Name, frequency and damping as a person reads them."""
        return f"{self.name}: {self.frequency:.4g} Hz, damping {100 * self.damping_ratio:.2g} %"


def swing(machine: Machine, mode: Mode) -> Swing:
    """A mode as it is drawn: turned in phase so that most of it is largest at once, at the beginning."""
    part, _ = in_phase(machine, mode.shape)
    phase = np.vdot(mode.shape, part.astype(complex))
    axis = None if mode.centre is None else (mode.centre.point, mode.centre.direction)
    return Swing(mode.name, mode.frequency, mode.damping_ratio, mode.shape * phase / abs(phase), axis)


def _swings(machine: Machine, modes: Sequence[Mode]) -> list[Swing]:
    """Those modes in which the machine moves; where two have one name, the later ones are numbered."""
    found: list[Swing] = []
    for mode in modes:
        if mode.machine_moves:
            one = swing(machine, mode)
            same = sum(other.name.split(" (")[0] == one.name for other in found)
            found.append(replace(one, name=f"{one.name} ({same + 1})") if same else one)
    return found


def replay_modes(path: Path, scenario: Scenario, variants: Mapping[str, Sequence[Mode]]) -> None:
    """Write the recording of those modes in which the machine itself moves.

    Args:
        path: file to write, ``*.rrd``; it appears when it is whole.
        scenario: the machine.
        variants: its modes by variant (``valves held``, ``closed loop``, …); those of one name are shown beside each
            other, variants without a swinging machine are left out.

    Raises:
        InputError: if the machine swings in none of them, or the file cannot be written.
    """
    found = {label: swings for label, modes in variants.items() if (swings := _swings(scenario.machine, modes))}
    if not found:
        raise InputError("modes: the machine does not swing (all its motions are overdamped, or it tips over)")
    try:
        _write(path, scenario.name, scenario.plant, found)
    except OSError as error:
        raise InputError(f"--replay {str(path)!r}: cannot be written ({error.strerror or error})") from error


def _write(path: Path, title: str, plant: Plant, variants: Mapping[str, Sequence[Swing]]) -> None:
    model = build_spec(plant.locked(), 1e-4, drawn=True).compile()
    first, swings = next(iter(variants.items()))
    names = [swing.name for swing in swings]
    beside = {name: {label: s for label, own in variants.items() for s in own if s.name == name} for name in names}
    application = f"ehamj modes {re.sub(r'[^A-Za-z0-9]+', '-', title).strip('-')}"
    with recorded(path, application, f"{title}: modes", lambda: _blueprint(plant, first, beside)) as recording:
        fixed(recording, "table", rr.TextDocument(_table(title, variants), media_type="text/markdown"))
        for name, shown in beside.items():
            _log_swing(recording, entity_of("all", name), plant, model, shown[first])
            pace = RINGING / shown[first].frequency
            for index, (label, swing) in enumerate(shown.items()):
                _log_swing(recording, entity_of(label, name), plant, model, swing, pace)
                _log_ringing(recording, entity(RINGINGS, name, f"{index}-{label}"), label, swing, pace, index)


def entity_of(page: str, name: str) -> str:
    """Label of a scene: the first part of all its paths."""
    return f"{page} - {name}"


def drawn_scale(plant: Plant, swing: Swing, points: Array) -> float:
    """Factor on a shape that draws it as large as `LARGEST` and `FOOT_LARGEST` allow."""
    reach = float(np.abs(_displacement(swing.shape, points)).max())
    feet = _displacement(swing.shape, plant.positions)
    lift = float(np.abs((feet * np.array(plant.directions)).sum(axis=1)).max())
    return min(LARGEST / reach, FOOT_LARGEST / lift if lift > 0.0 else math.inf)


def motion_of(swing: Swing, pace: float | None = None) -> Array:
    """Motion of the mount plane's centre at `TIMES`, (n, 6) [m, rad], of the shape as it is.

    The free decay Re(v e^{λ t·pace}), ``pace`` being machine seconds per viewing second; None: `SWINGS` steady ones.
    """
    if pace is None:
        turn = np.exp(2j * np.pi * SWINGS / LENGTH * TIMES)
    else:
        zeta, omega = swing.damping_ratio, 2 * np.pi * swing.frequency
        turn = np.exp(complex(-zeta * omega, omega * math.sqrt(max(0.0, 1 - zeta**2))) * pace * TIMES)
    return np.asarray((turn[:, None] * swing.shape).real)


def _displacement(shape: ComplexArray, points: Sequence[ArrayLike] | Array) -> ComplexArray:
    """Complex displacement of points in a small motion of the mount plane's centre, (n, 3)."""
    return np.asarray(levers(points) @ shape).reshape(-1, 3)


def _corners(model: mujoco.MjModel) -> Array:
    """Upper corners of the parts that show their paths, (n, 3) [m]."""
    around = np.array([(1, 1, 1), (1, -1, 1), (-1, -1, 1), (-1, 1, 1)])
    return np.concatenate([model.geom(name).pos + model.geom(name).size * around for name in PARTS])


def _log_swing(
    recording: rr.RecordingStream,
    label: str,
    plant: Plant,
    model: mujoco.MjModel,
    swing: Swing,
    pace: float | None = None,
) -> None:
    """Log one scene: shapes and ghost, the moving machine, the paths of its corners, the axis it turns about."""
    log_shapes(recording, label, model)
    points = _corners(model)
    drawn = replace(swing, shape=drawn_scale(plant, swing, points) * swing.shape)
    motion = motion_of(drawn, pace)
    poses = {"machine": Pose(motion[:, :3], quaternion(motion[:, 3:]))}
    for mount, position in zip(plant.mounts, plant.positions, strict=True):
        pad = model.body(f"pad {mount}")
        turned = rr.Quaternion(xyzw=pad.quat[[1, 2, 3, 0]])
        fixed(recording, entity(label, "world", f"pad {mount}"), rr.Transform3D(translation=pad.pos, rotation=turned))
        if plant.plates == "sliding":
            upright = np.tile([0.0, 0.0, 0.0, 1.0], (len(TIMES), 1))
            poses[f"plate {mount}"] = Pose(model.body(f"plate {mount}").pos + motion @ lever(position).T, upright)
    for slide in plant.slides:
        poses[f"slide {slide.name}"] = on_rail(slide, slide.begins, poses["machine"])
    log_poses(recording, label, poses, TIMES, TIMELINE)
    _log_paths(recording, label, drawn, points)
    _log_axis(recording, label, plant, model, drawn)


def _log_paths(recording: rr.RecordingStream, label: str, drawn: Swing, points: Array) -> None:
    """The closed path of each corner in the steady motion, with an arrow's head where it turns back."""
    phase = np.exp(2j * np.pi * np.linspace(0.0, 1.0, 49))
    moved = _displacement(drawn.shape, points)
    paths = [points[k] + (phase[:, None] * moved[k]).real for k in range(len(points))]
    fixed(recording, entity(label, "world", "paths"), rr.LineStrips3D(paths, radii=0.012, colors=[PATH_COLOR]))
    origins, vectors = [], []
    for point, move in zip(points, moved, strict=True):
        far = move * np.exp(-0.5j * np.angle(np.sum(move**2)))  # the ellipse's longer half axis
        length = float(np.linalg.norm(far.real))
        if length > 0.02:
            for sign in (1.0, -1.0):
                origins.append(point + sign * (1.0 - HEAD / max(length, HEAD)) * far.real)
                vectors.append(sign * min(HEAD, length) / length * far.real)
    if origins:
        heads = rr.Arrows3D(origins=origins, vectors=vectors, radii=0.03, colors=[PATH_COLOR])
        fixed(recording, entity(label, "world", "turning"), heads)


def drawn_axis(plant: Plant, swing: Swing) -> tuple[Array, Array] | None:
    """Middle [m] and direction of the axis as it is drawn; None where it is too far away, or there is none."""
    if swing.axis is None:
        return None
    point, direction = swing.axis
    middle = np.array([0.0, 0.0, 0.5 * plant.machine.size[2]])
    nearest = point + direction * float(direction @ (middle - point))
    return (nearest, direction) if float(np.linalg.norm(nearest - middle)) <= NEAR else None


def _log_axis(recording: rr.RecordingStream, label: str, plant: Plant, model: mujoco.MjModel, swing: Swing) -> None:
    """The axis that the machine turns about, sticking out of it, with balls at its ends.

    Where it lies below the floor, the floor is drawn as lines, so that it shows.
    """
    axis = drawn_axis(plant, swing)
    if axis is None:
        return
    nearest, direction = axis
    reach = 0.5 * float(np.abs(direction) @ np.array(plant.machine.size)) + 0.3
    ends = np.array([nearest - reach * direction, nearest + reach * direction])
    path = entity(label, "world", "axis")
    fixed(recording, path, rr.LineStrips3D([ends], radii=0.022, colors=[AXIS_COLOR]))
    fixed(recording, f"{path}/ends", rr.Points3D(ends, radii=0.07, colors=[AXIS_COLOR]))
    if ends[:, 2].min() < floor_height(plant) and abs(direction[2]) < 0.5:
        floor = model.geom("floor")
        lines = rr.Boxes3D(half_sizes=[floor.size], centers=[floor.pos], colors=[GHOST], fill_mode="majorwireframe")
        fixed(recording, entity(label, "world", "floor", "geoms", "floor"), lines)


def _log_ringing(recording: rr.RecordingStream, path: str, label: str, swing: Swing, pace: float, index: int) -> None:
    """The ring-down as a curve: motion over its beginning."""
    largest = int(np.argmax(np.abs(swing.shape)))
    curve = motion_of(swing, pace)[:, largest] / abs(swing.shape[largest])
    fixed(recording, path, rr.SeriesLines(names=[label], colors=[result_color(index)], widths=[2.0]))
    moving(recording, path, TIMES, rr.Scalars.columns(scalars=curve), TIMELINE)


def _blueprint(plant: Plant, first: str, beside: Mapping[str, Mapping[str, Swing]]) -> rrb.Blueprint:
    together = [
        _view(plant, entity_of("all", name), shown[first].title, shown[first]) for name, shown in beside.items()
    ]
    columns = 3 if len(together) > 4 else 2
    pages: list[rrb.Container | rrb.View] = [rrb.Grid(*together, grid_columns=columns, name=f"all modes, {first}")]
    for name, shown in beside.items():
        views = [
            _view(plant, entity_of(label, name), f"{label}, {swing.title}", swing, away=1.2)
            for label, swing in shown.items()
        ]
        curves = rrb.TimeSeriesView(
            origin=entity(RINGINGS, name),
            name="ring-down, over its beginning",
            plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop),
        )
        pages.append(rrb.Vertical(rrb.Horizontal(*views), curves, row_shares=[3, 1], name=name))
    pages.append(rrb.TextDocumentView(origin="/table", name="table"))
    return laid_out(rrb.Tabs(*pages, active_tab=0), 1.0, TIMELINE)


def _view(plant: Plant, label: str, title: str, swing: Swing, away: float = 1.08) -> rrb.Spatial3DView:
    """A scene, seen from where its motion shows best."""
    size = np.array(plant.machine.size)
    turn = np.abs(swing.shape[3:]) * 0.5 * math.hypot(*size)
    shift = np.abs(swing.shape[:3])
    kind = int(np.argmax([max(turn[0], shift[1]), max(turn[1], shift[0]), turn[2], shift[2]]))
    eye = np.array([(0.95, -0.34, 0.22), (0.34, -0.95, 0.22), (0.55, -0.55, 0.85), (0.80, -0.62, 0.16)][kind])
    axis = drawn_axis(plant, swing)
    floor = floor_height(plant)
    lowest = min(floor, axis[0][2] - 0.1) if axis is not None and kind < 2 else floor
    away *= 1.0 + 0.6 * (floor - lowest) / math.hypot(*size)
    return scene_view(label, title, plant.machine, eye, away, 0.5 * (floor - lowest))


def _table(title: str, variants: Mapping[str, Sequence[Swing]]) -> str:
    """The page beside the pictures, as Markdown."""
    rows = [
        [label, swing.name, f"{swing.frequency:.2f}", f"{100 * swing.damping_ratio:.2f}"]
        for label, swings in variants.items()
        for swing in swings
    ]
    parts = [
        f"# {title}: modes",
        table(["variant", "mode", "natural frequency [Hz]", "damping ratio [%]"], rows),
        "Motions are drawn far larger than they are, and slowed. On the first page every mode swings at the same pace; "
        "on the others a mode is let go and rings down, all variants on one clock.",
        "Yellow: paths of corners. Red: the axis that the machine turns about. Grey lines: the machine at rest.",
    ]
    return "\n\n".join(parts) + "\n"
