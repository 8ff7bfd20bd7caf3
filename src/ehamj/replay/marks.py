"""Marks in the picture: a bar that gives its scale, arrows for the velocities that the isolators act on."""

from collections.abc import Iterable

import numpy as np
import rerun as rr

from ehamj.replay.names import GROUND_COLOR, Array, Color, entity
from ehamj.replay.recording import fixed, moving
from ehamj.replay.scene import FLOOR, LARGEST_DRAWN, drawn_rows, nice, pose_rows
from ehamj.result import Result

TYPICAL_ARROW = 0.2
"""Length of an arrow that shows the RMS velocity [m]."""

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


def log_marks(
    recording: rr.RecordingStream, label: str, result: Result, factor: float, arrows: float, color: Color
) -> None:
    """Log the bar of a scene and the arrows beside its mounts.

    Args:
        recording: where to.
        label: the result's name, first part of every path.
        result: what is drawn.
        factor: exaggeration of the motions.
        arrows: length of an arrow over velocity, 0 for none.
        color: of the machine's arrows; the floor's have the floor's colour.
    """
    _log_bar(recording, label, result, factor)
    if arrows > 0.0:
        _log_arrows(recording, label, result, arrows, color)


def _log_bar(recording: rr.RecordingStream, label: str, result: Result, factor: float) -> None:
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
    bar = rr.LineStrips3D(strips, radii=rr.Radius.ui_points(1.5), colors=[(255, 255, 255)])
    fixed(recording, entity(label, "world", "scale"), bar)
    text = rr.Points3D(
        [[x, y, bottom]], radii=0.001, colors=[(255, 255, 255)], labels=[length_text(length)], show_labels=True
    )
    fixed(recording, entity(label, "world", "scale", "text"), text)


def _log_arrows(recording: rr.RecordingStream, label: str, result: Result, scale: float, color: Color) -> None:
    """Two arrows outside each mount: vertical velocity of the floor, and beside it of the machine's foot."""
    rows = pose_rows(result)
    corners = np.array(result.scenario.plant.positions)
    away = np.sign(corners) * (0.5 * np.array(result.scenario.machine.size[:2]) + (0.1, 0.1))
    aside = 0.06 * np.array([1.0, 1.0])  # to the right as the eye sees it
    for name, place, shade, velocity in zip(
        ("floor", "foot"), (away - aside, away + aside), (GROUND_COLOR, color), _vertical(result, rows), strict=True
    ):
        path = entity(label, "world", "velocity", name)
        origins = np.column_stack([place, np.zeros(len(place))])
        style = rr.Arrows3D.from_fields(origins=origins, colors=[shade], radii=0.02)
        fixed(recording, path, style)
        vectors = np.zeros((*velocity.shape, 3))
        vectors[..., 2] = scale * velocity
        columns = rr.Arrows3D.columns(vectors=vectors.reshape(-1, 3)).partition([velocity.shape[1]] * len(rows))
        moving(recording, path, result.dataset.time.values[rows], columns)


def _vertical(result: Result, rows: np.ndarray | slice) -> tuple[Array, Array]:
    """Vertical velocity at each mount of floor and foot, (n, mount) each [m/s]."""
    return result.dataset.ground_velocity.values[rows, :, 2], result.dataset.foot_velocity.values[rows, :, 2]


def length_text(length: float) -> str:
    """A length [m] in the unit that keeps it short."""
    for unit, size in (("m", 1.0), ("mm", 1e-3), ("µm", 1e-6)):
        if length >= 0.999 * size:
            return f"{length / size:.4g} {unit}"
    return "0" if length < 1e-12 else f"{length / 1e-9:.3g} nm"
