"""Marks in the picture: a bar that gives its scale, arrows for the velocities that the isolators act on."""

from collections.abc import Iterable

import numpy as np
import rerun as rr

from ehamj.replay.recording import FAULT_COLOR, GROUND_COLOR, Array, Color, entity, fixed, moving
from ehamj.replay.scene import FLOOR, LARGEST_DRAWN, drawn_rows, nice, pose_rows
from ehamj.result import Result

TYPICAL_ARROW = 0.2
"""Length of an arrow that shows the RMS velocity [m]."""

FAULT_LOG = "faults"
"""Where their words are logged."""

LEAST_VELOCITY = 1e-12
"""RMS velocity below which there are no arrows: rounding [m/s]."""


def arrow_scale(results: Iterable[Result]) -> float:
    """Length of an arrow over velocity [m/(m/s)], one of 1, 2, 5·10ⁿ; 0 where nothing moves vertically."""
    largest = 0.0
    for result in results:
        for vertical in _vertical(result, drawn_rows(result)):
            if vertical.size:
                largest = max(largest, float(np.sqrt(np.mean(vertical**2))))
    return nice(TYPICAL_ARROW / largest) if largest > LEAST_VELOCITY else 0.0


def log_bar(recording: rr.RecordingStream, label: str, result: Result, factor: float) -> None:
    """A bar in front of the machine that says how long a motion is drawn."""
    length = nice(1.5 * LARGEST_DRAWN / factor)
    x, y = 0.5 * result.scenario.machine.size[0] + 0.4, -0.05 * result.scenario.machine.size[1]
    bottom = FLOOR + LARGEST_DRAWN  # the floor moves, the bar does not
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
    """Two arrows outside each mount: vertical velocity of the floor, and beside it of the machine's foot.

    ``scale`` is their length over velocity [m/(m/s)], 0 for none; ``color`` the foot's, the floor's is the floor's own.
    """
    if not scale:
        return
    rows = pose_rows(result)
    corners = np.array(result.scenario.plant.positions)[:, :2]
    away = np.sign(corners) * (0.5 * np.array(result.scenario.machine.size[:2]) + (0.1, 0.1))
    aside = 0.06 * np.array([1.0, 1.0])  # to the right as the eye sees it
    for name, place, shade, velocity in zip(
        ("floor", "foot"), (away - aside, away + aside), (GROUND_COLOR, color), _vertical(result, rows), strict=True
    ):
        path = entity(label, "world", "velocity", name)
        origins = np.column_stack([place, np.zeros(len(place))])
        fixed(recording, path, rr.Arrows3D.from_fields(origins=origins, colors=[shade], radii=0.02))
        vectors = np.zeros((*velocity.shape, 3))
        vectors[..., 2] = scale * velocity
        columns = rr.Arrows3D.columns(vectors=vectors.reshape(-1, 3)).partition([velocity.shape[1]] * len(rows))
        moving(recording, path, result.dataset.time.values[rows], columns)


def log_faults(recording: rr.RecordingStream, label: str, result: Result) -> None:
    """From the time of each fault on: a mark at the mount, or above the machine; and a line of text that names it."""
    for number, one in enumerate(result.summary.fault):
        mounts, size = result.scenario.plant.mounts, result.scenario.machine.size
        place = [0.0, 0.0, 1.15 * size[2]]
        if one.where in mounts:
            x, y, _ = result.scenario.plant.positions[mounts.index(one.where)]
            place = [x + 0.25 * np.sign(x), y + 0.25 * np.sign(y), 0.05]  # outside, where the bed does not hide it
        words = f"fault {number + 1}" if len(result.summary.fault) > 1 else "fault"  # longer ones leave the view
        at = np.array([one.time_s])
        path = entity(label, "world", f"fault {number + 1}")
        columns = rr.Points3D.columns(positions=[place], radii=[0.07], colors=[FAULT_COLOR], labels=[words])
        moving(recording, path, at, columns)
        fixed(recording, path, rr.Points3D.from_fields(show_labels=True))
        text = rr.TextLog.columns(text=[f"{label}, {one.in_words()}"], level=["WARN"])
        moving(recording, FAULT_LOG, at, text)


def _vertical(result: Result, rows: np.ndarray | slice) -> tuple[Array, Array]:
    """Vertical velocity at each mount of floor and foot, (n, mount) each [m/s]."""
    return result.dataset.ground_velocity.values[rows, :, 2], result.dataset.foot_velocity.values[rows, :, 2]


def length_text(length: float) -> str:
    """A length [m] in the unit that keeps it short."""
    for unit, size in (("m", 1.0), ("mm", 1e-3), ("µm", 1e-6)):
        if length >= 0.999 * size:
            return f"{length / size:.4g} {unit}"
    return "0" if length < 1e-12 else f"{length / 1e-9:.3g} nm"
