"""Drawings of the machine to scale, with its mounts and centre of gravity."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ehamj.plots import style
from ehamj.plots.style import Artist, Axes, Figure

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Foot:
    """One mount of the drawing: its name, position [m] and what stands there."""

    name: str
    x: float
    y: float
    kind: str


@dataclass(frozen=True)
class Mark:
    """A point of the machine that is reported: its name and place [m]."""

    name: str
    place: Vector


def machine_plan(
    size: Vector,
    cg: Vector,
    feet: Sequence[Foot],
    waves: Sequence[tuple[str, float]] = (),
    points: Sequence[Mark] = (),
) -> Figure:
    """The machine from above, to scale, origin at the mount plane's centre [m].

    Args:
        size: outline: length in x, width in y, height [m].
        cg: centre of gravity [m].
        feet: the four mounts.
        waves: label and direction of travel, from +x towards +y [deg], of each wave in the floor.
        points: points of the machine that are reported.
    """
    from matplotlib.patches import Rectangle

    length, width, _ = size
    with style.styled():
        figure = style.new_figure("The machine from above")
        axes, scale, room, foot_size = _view(figure, size)
        high = width + 2.0 * room
        axes.set_ylim(-0.5 * high, 0.5 * high)
        axes.add_patch(Rectangle((-length / 2, -width / 2), length, width, facecolor="#F3F4F6", edgecolor=style.INK))
        colors = _foot_colors(feet)
        for foot in feet:
            _square(axes, foot.x, foot.y - foot_size / 2, foot_size, colors[foot.kind])
            inward, outer = (-1 if foot.y > 0 else 1), (1 if foot.x > 0 else -1)
            place = (foot.x + outer * foot_size / 2, foot.y + inward * 0.7 * foot_size)
            axes.text(*place, foot.name, ha="right" if outer > 0 else "left", va="top" if inward < 0 else "bottom")
        right = sorted(sorted(feet, key=lambda foot: foot.y)[:2], key=lambda foot: foot.x)
        front = sorted(sorted(feet, key=lambda foot: foot.x)[2:], key=lambda foot: foot.y)
        _dimension(axes, (right[0].x, right[1].x), -width / 2 - foot_size, "x")
        _dimension(axes, (front[0].y, front[1].y), length / 2 + foot_size, "y")
        _dimension(axes, (-length / 2, length / 2), width / 2 + foot_size, "x")
        _waves(axes, waves[:3], room)
        _tripod(axes, "y", 2.2 * foot_size)
        entries: dict[str, Artist] = dict([_cg(axes, cg, 1, 0.4 * foot_size)])
        entries |= _points(axes, points, 1)
        axes.set_ylabel("y [m]")
        style.arrange(figure, [(axes, scale * high)], {**_foot_entries(feet), **entries})
    return figure


def machine_side(size: Vector, cg: Vector, feet: Sequence[Foot], points: Sequence[Mark] = ()) -> Figure:
    """The machine from its right side, at the scale of `machine_plan` [m]; mounts are drawn of some height."""
    from matplotlib.patches import Rectangle

    length, _, height = size
    with style.styled():
        figure = style.new_figure("The machine from the right")
        axes, scale, room, foot_size = _view(figure, size)
        low, high = -2.2 * foot_size, height + 0.5 * room
        axes.set_ylim(low, high)
        axes.add_patch(Rectangle((-length / 2, 0.0), length, height, facecolor="#F3F4F6", edgecolor=style.INK))
        colors = _foot_colors(feet)
        for foot in sorted(feet, key=lambda foot: -foot.y):
            _square(axes, foot.x, -foot_size, foot_size, colors[foot.kind])
        ends = axes.get_xlim()
        ground = Rectangle((ends[0], -1.6 * foot_size), ends[1] - ends[0], 0.6 * foot_size, linewidth=0.0, hatch="////")
        ground.set(facecolor="white", edgecolor=style.GREY)
        axes.add_patch(ground)
        axes.plot(ends, [-foot_size] * 2, color=style.GREY, linewidth=1.4)
        _dimension(axes, (0.0, height), length / 2 + foot_size, "y")
        if cg[2] > 1.5 * foot_size:
            _dimension(axes, (0.0, cg[2]), -length / 2 - foot_size, "y")
        _tripod(axes, "z", 2.2 * foot_size)
        entries: dict[str, Artist] = dict([_cg(axes, cg, 2, 0.4 * foot_size)])
        entries |= _points(axes, points, 2)
        axes.set_ylabel("z [m]")
        style.arrange(figure, [(axes, scale * (high - low))], {**_foot_entries(feet), **entries})
    return figure


def _view(figure: Figure, size: Vector) -> tuple[Axes, float, float, float]:
    """Axes of a drawing, its scale [pt/m], the room beside the machine [m], the side of a mount's square [m]."""
    length, width, height = size
    larger = max(length, width)
    room = 0.2 * larger
    across = style.WIDTH - style.LEFT - 14.0
    scale = min(across / (length + 2.0 * room), 300.0 / (max(width, height) + 2.0 * room))
    axes = figure.add_subplot()
    axes.set_xlim(-0.5 * across / scale, 0.5 * across / scale)
    axes.set_xlabel("x [m], front to the right")
    axes.grid(False)
    return axes, scale, room, 0.08 * larger


def _foot_colors(feet: Sequence[Foot]) -> dict[str, str]:
    kinds = dict.fromkeys(foot.kind for foot in feet)
    return dict(zip(kinds, itertools.cycle((style.BLUE, style.GREEN, style.PURPLE, style.ORANGE)), strict=False))


def _foot_entries(feet: Sequence[Foot]) -> dict[str, Artist]:
    from matplotlib.patches import Patch

    return {f"mount: {style.shown(kind)}": Patch(color=color) for kind, color in _foot_colors(feet).items()}


def _square(axes: Axes, x: float, bottom: float, side: float, color: str) -> None:
    from matplotlib.patches import Rectangle

    axes.add_patch(Rectangle((x - side / 2, bottom), side, side, color=color))


def _cg(axes: Axes, cg: Vector, up: int, radius: float) -> tuple[str, Artist]:
    """The draughtsman's mark of a centre of gravity; ``up`` is the axis that points up. Returns its legend entry."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Circle, Wedge

    place = (cg[0], cg[up])
    axes.add_patch(Circle(place, radius, facecolor="white", edgecolor=style.INK, zorder=4))
    for first in (0.0, 180.0):
        axes.add_patch(Wedge(place, radius, first, first + 90.0, facecolor=style.INK, zorder=4))
    mark = Line2D([], [], linestyle="none", marker="o", markersize=8, fillstyle="left", color=style.INK)
    mark.set_markerfacecoloralt("white")
    place_text = ", ".join(f"{part:.3g}" for part in cg).replace("-", "−")
    return f"centre of gravity ({place_text}) m", mark


def _points(axes: Axes, points: Sequence[Mark], up: int) -> dict[str, Artist]:
    """A numbered cross at each point; ``up`` is the axis that points up. Returns the legend."""
    from matplotlib.lines import Line2D

    entries: dict[str, Artist] = {}
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    for number, point in enumerate(points, start=1):
        at = (point.place[0], point.place[up])
        if not (left < at[0] < right and bottom < at[1] < top):
            continue  # an arm or a workpiece outside of the drawing
        axes.plot(*at, marker="x", markersize=7, markeredgewidth=1.8, color=style.PURPLE, zorder=5)
        sign = str(number) if len(points) > 1 else ""
        axes.annotate(sign, at, (5, 5), textcoords="offset points", color=style.PURPLE, fontsize=8.8, zorder=5)
        text = ", ".join(f"{part:.3g}" for part in point.place).replace("-", "−")
        mark = Line2D([], [], linestyle="none", marker="x", markersize=7, markeredgewidth=1.8, color=style.PURPLE)
        entries[style.shown(f"{sign} {point.name} ({text}) m".strip())] = mark
    return entries


def _tripod(axes: Axes, up: str, length: float) -> None:
    for tip, name in (((length, 0.0), "x"), ((0.0, length), up)):
        look = {"arrowstyle": "-|>", "color": style.LIMIT_COLOR, "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", tip, (0.0, 0.0), arrowprops=look)
        beyond = (5, 7) if name == "x" else (0, 6)
        axes.annotate(name, tip, beyond, textcoords="offset points", color=style.LIMIT_COLOR, ha="center", va="center")


def _dimension(axes: Axes, ends: tuple[float, float], at: float, along: str) -> None:
    """A dimension line from end to end, at a distance, with its length [m]."""
    look = {"arrowstyle": "<|-|>", "color": "#4B5563", "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
    first, last = ((end, at) if along == "x" else (at, end) for end in ends)
    axes.annotate("", last, first, arrowprops=look)
    middle = (0.5 * (first[0] + last[0]), 0.5 * (first[1] + last[1]))
    box = {"boxstyle": "square,pad=0.15", "facecolor": "white", "edgecolor": "none"}
    turned = 90.0 if along == "y" else 0.0
    text = f"{abs(ends[1] - ends[0]):.4g}"
    axes.text(*middle, text, ha="center", va="center", rotation=turned, fontsize=8.8, color="#374151", bbox=box)


def _waves(axes: Axes, waves: Sequence[tuple[str, float]], room: float) -> None:
    """Arrows in the margin on the left that show where waves in the floor go."""
    (left, _), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    step = (top - bottom) / (len(waves) + 1)
    for place, (label, direction) in enumerate(waves, start=1):
        x, y = left + 0.5 * room, top - place * step
        reach = 0.3 * room * np.array([math.cos(math.radians(direction)), math.sin(math.radians(direction))])
        look = {"arrowstyle": "-|>", "color": style.GREY, "linewidth": 2.0, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (x + reach[0], y + reach[1]), (x - reach[0], y - reach[1]), arrowprops=look)
        axes.text(x, y - 0.4 * room, label, va="top", ha="center", fontsize=8.8, color="#4B5563")
