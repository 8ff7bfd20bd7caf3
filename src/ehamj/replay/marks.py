"""Marks in the picture: a bar that gives its scale, arrows for the velocities that the isolators act on."""

from collections.abc import Iterable

import numpy as np
import rerun as rr

from ehamj.mujoco.drawing import floor_height
from ehamj.plant.plant import Plant
from ehamj.replay.recording import FAULT_COLOR, GROUND_COLOR, Array, Color, entity, fixed, moving
from ehamj.replay.scene import LARGEST_DRAWN, drawn_rows, nice, pose_rows
from ehamj.result import Result

TYPICAL_ARROW = 0.2
"""Length of an arrow that shows the RMS velocity [m]."""

FAULT_LOG = "faults"
"""Where their words are logged."""

MOST_ARROWS = 8
"""Mounts that have arrows."""

CORNER = 0.6
"""Share of half the outline from which a mount stands at that side."""

LEAST_VELOCITY = 1e-12
"""RMS velocity below which there are no arrows: rounding [m/s]."""


def arrow_scale(results: Iterable[Result]) -> float:
    """Length of an arrow over velocity [m/(m/s)], one of 1, 2, 5·10ⁿ; 0 where nothing moves along the mounts."""
    largest = 0.0
    for result in results:
        for velocity in _along(result, drawn_rows(result)):
            if velocity.size:
                largest = max(largest, float(np.sqrt(np.mean(velocity**2))))
    return nice(TYPICAL_ARROW / largest) if largest > LEAST_VELOCITY else 0.0


def log_bar(recording: rr.RecordingStream, label: str, result: Result, factor: float) -> None:
    """A bar in front of the machine that says how long a motion is drawn."""
    length = nice(1.5 * LARGEST_DRAWN / factor)
    x, y = 0.5 * result.scenario.machine.size[0] + 0.4, -0.05 * result.scenario.machine.size[1]
    bottom = floor_height(result.scenario.plant) + LARGEST_DRAWN  # the floor moves, the bar does not
    top, wing = bottom + factor * length, 0.03
    strips = [
        [[x, y, bottom], [x, y, top]],
        [[x - wing, y - wing, bottom], [x + wing, y + wing, bottom]],
        [[x - wing, y - wing, top], [x + wing, y + wing, top]],
    ]
    path, white = entity(label, "world", "scale"), [(255, 255, 255)]
    fixed(recording, path, rr.LineStrips3D(strips, radii=rr.Radius.ui_points(1.5), colors=white))
    text = rr.Points3D([strips[0][0]], radii=0.001, colors=white, labels=[length_text(length)], show_labels=True)
    fixed(recording, f"{path}/text", text)


def log_arrows(recording: rr.RecordingStream, label: str, result: Result, scale: float, color: Color) -> None:
    """Two arrows outside each mount of `shown_at`: velocity along it of the floor, and beside it of the machine's foot.

    ``scale`` is their length over velocity [m/(m/s)], 0 for none; ``color`` the foot's, the floor's is the floor's own.
    """
    if not scale:
        return
    rows, plant = pose_rows(result), result.scenario.plant
    chosen = list(shown_at(plant))
    places, directions = np.array(plant.positions)[chosen], np.array(plant.directions)[chosen]
    away = outside(places[:, :2], np.array(result.scenario.machine.size[:2]))
    aside = 0.06 * np.array([1.0, 1.0])  # to the right as the eye sees it
    for name, place, shade, velocity in zip(
        ("floor", "foot"), (away - aside, away + aside), (GROUND_COLOR, color), _along(result, rows), strict=True
    ):
        path = entity(label, "world", "velocity", name)
        origins = np.column_stack([place, places[:, 2]])
        fixed(recording, path, rr.Arrows3D.from_fields(origins=origins, colors=[shade], radii=0.02))
        velocity = velocity[:, chosen]
        vectors = scale * velocity[..., None] * directions
        columns = rr.Arrows3D.columns(vectors=vectors.reshape(-1, 3)).partition([velocity.shape[1]] * len(rows))
        moving(recording, path, result.dataset.time.values[rows], columns)


def shown_at(plant: Plant) -> tuple[int, ...]:
    """Mounts that have arrows, by number: all, or of many those farthest out in `MOST_ARROWS` directions."""
    if len(plant.mounts) <= MOST_ARROWS:
        return tuple(range(len(plant.mounts)))
    places = np.array(plant.positions)[:, :2]
    scaled = (places - places.mean(axis=0)) / np.maximum(np.ptp(places, axis=0), 1e-9)
    turns = 2 * np.pi * np.arange(MOST_ARROWS) / MOST_ARROWS
    return tuple(sorted({int(np.argmax(scaled @ (np.cos(turn), np.sin(turn)))) for turn in turns}))


def outside(places: Array, size: Array) -> Array:
    """Where marks of mounts at ``places`` (mount, 2) stand [m]: beside the outline, in front of the side that a mount
    is nearest to, and of both at a corner."""
    half = 0.5 * size
    share = np.abs(places) / half
    pushed = (share >= share.max(axis=1, keepdims=True)) | (share > CORNER)
    return np.asarray(np.where(pushed, np.sign(places) * (half + 0.1), places))


def log_faults(recording: rr.RecordingStream, label: str, result: Result) -> None:
    """From the time of each fault on: a mark at the mount, or above the machine; and a line of text that names it."""
    for number, one in enumerate(result.summary.fault):
        mounts, size = result.scenario.plant.mounts, result.scenario.machine.size
        place = [0.0, 0.0, 1.15 * size[2]]
        if one.where in mounts:
            x, y, z = result.scenario.plant.positions[mounts.index(one.where)]
            place = [x + 0.25 * np.sign(x), y + 0.25 * np.sign(y), z + 0.05]  # outside, where the bed does not hide it
        words = f"fault {number + 1}" if len(result.summary.fault) > 1 else "fault"  # longer ones leave the view
        at = np.array([one.time_s])
        path = entity(label, "world", f"fault {number + 1}")
        columns = rr.Points3D.columns(positions=[place], radii=[0.07], colors=[FAULT_COLOR], labels=[words])
        moving(recording, path, at, columns)
        fixed(recording, path, rr.Points3D.from_fields(show_labels=True))
        text = rr.TextLog.columns(text=[f"{label}, {one.in_words()}"], level=["WARN"])
        moving(recording, FAULT_LOG, at, text)


def _along(result: Result, rows: np.ndarray | slice) -> tuple[Array, Array]:
    """Velocity along each mount of floor and foot, (n, mount) each [m/s]."""
    directions = np.array(result.scenario.plant.directions)
    ground, foot = (result.dataset[f"{what}_velocity"].values[rows] for what in ("ground", "foot"))
    return np.einsum("tmx,mx->tm", ground, directions), np.einsum("tmx,mx->tm", foot, directions)


def length_text(length: float) -> str:
    """A length [m] in the unit that keeps it short."""
    for unit, size in (("m", 1.0), ("mm", 1e-3), ("µm", 1e-6)):
        if length >= 0.999 * size:
            return f"{length / size:.4g} {unit}"
    return "0" if length < 1e-12 else f"{length / 1e-9:.3g} nm"
