"""Drawings of the machine to scale, with its mounts and centre of gravity."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.plots import style
from ehamj.plots.style import Artist, Axes, Figure

Vector = tuple[float, float, float]

ACROSS: Final = style.WIDTH - style.LEFT - 14.0
"""Width of the drawing itself [pt]."""
BODY: Final = "#F3F4F6"


UP: Final = (0.0, 0.0, 1.0)
NAME_SIZE: Final = 9.5
SMALL: Final = 7.5
"""Of the mounts' names, where there is room, and where there is little [pt]."""


@dataclass(frozen=True)
class Foot:
    """One mount of the drawing: its name, position [m], what stands there, and along what unit vector it acts."""

    name: str
    x: float
    y: float
    kind: str
    z: float = 0.0
    along: Vector = UP

    @property
    def upright(self) -> bool:
        """Whether it stands below the machine."""
        return self.along[2] > 1.0 - 1e-9


@dataclass(frozen=True)
class Mark:
    """A point of the machine that is reported: its name and place [m]."""

    name: str
    place: Vector


@style.styled()
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
        feet: the mounts.
        waves: label and direction of travel, from +x towards +y [deg], of each wave in the floor.
        points: points of the machine that are reported.
    """
    length, width, _ = size
    room, side = _measures(size)
    figure, axes = _view("The machine from above", size, (-0.5 * width - room, 0.5 * width + room))
    _box(axes, (-length / 2, -width / 2), length, width, facecolor=BODY, edgecolor=style.INK)
    colors = _foot_colors(feet)
    for foot in feet:
        _isolator(axes, foot, side, (0, 1), colors[foot.kind])
    _names(axes, feet, size)
    across, along = ([getattr(foot, name) for foot in feet] for name in "xy")
    _dimension(axes, (min(across), max(across)), -width / 2 - side, "x")
    _dimension(axes, (min(along), max(along)), length / 2 + side, "y")
    _dimension(axes, (-length / 2, length / 2), width / 2 + side, "x")
    _waves(axes, waves[:3], room)
    return _finished(figure, axes, "y", size, cg, feet, points)


@style.styled()
def machine_side(size: Vector, cg: Vector, feet: Sequence[Foot], points: Sequence[Mark] = ()) -> Figure:
    """The machine from its right side, at the scale of `machine_plan` [m]; mounts are drawn of some height."""
    length, _, height = size
    room, side = _measures(size)
    lowest = min(0.0, *(foot.z - 1.2 * side for foot in feet if not foot.upright or foot.z < 0.0), 0.0)
    figure, axes = _view("The machine from the right", size, (lowest - 2.2 * side, height + 0.5 * room))
    _box(axes, (-length / 2, 0.0), length, height, facecolor=BODY, edgecolor=style.INK)
    colors = _foot_colors(feet)
    for foot in sorted(feet, key=lambda foot: -foot.y):
        _isolator(axes, foot, side, (0, 2), colors[foot.kind])
        if foot.upright and foot.z != 0.0:
            axes.plot((foot.x - side, foot.x + side), [foot.z - side] * 2, color=style.GREY, linewidth=1.4)
    left, right = axes.get_xlim()
    hatched = {"linewidth": 0.0, "hatch": "////", "facecolor": "white", "edgecolor": style.GREY}
    _box(axes, (left, -1.6 * side), right - left, 0.6 * side, **hatched)
    axes.plot((left, right), [-side] * 2, color=style.GREY, linewidth=1.4)
    _dimension(axes, (0.0, height), length / 2 + side, "y")
    if cg[2] > 1.5 * side:
        _dimension(axes, (0.0, cg[2]), -length / 2 - side, "y")
    return _finished(figure, axes, "z", size, cg, feet, points)


def _measures(size: Vector) -> tuple[float, float]:
    """The room beside the machine, and the side of a mount's square [m]."""
    larger = max(size[:2])
    return 0.2 * larger, 0.08 * larger


def _view(title: str, size: Vector, ends: tuple[float, float]) -> tuple[Figure, Axes]:
    """An empty drawing of a machine; ``ends`` of its vertical axis [m]."""
    length, width, height = size
    room, _ = _measures(size)
    scale = min(ACROSS / (length + 2.0 * room), 300.0 / (max(width, height) + 2.0 * room))
    figure, (axes,) = style.new_figure(title)
    axes.set(xlim=(-0.5 * ACROSS / scale, 0.5 * ACROSS / scale), ylim=ends, xlabel="x [m], front to the right")
    axes.grid(False)
    return figure, axes


def _finished(
    figure: Figure, axes: Axes, up: str, size: Vector, cg: Vector, feet: Sequence[Foot], points: Sequence[Mark]
) -> Figure:
    """The drawing with tripod, centre of gravity, points and legend; ``up`` is the axis that points up."""
    side = _measures(size)[1]
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    _tripod(axes, up, 2.2 * side)
    entries = {f"mount: {style.shown(kind)}": style.patch_key(color=hue) for kind, hue in _foot_colors(feet).items()}
    entries[f"centre of gravity {_in_metres(cg)}"] = _cg(axes, (cg[0], cg["xyz".index(up)]), 0.4 * side)
    entries |= _points(axes, points, "xyz".index(up))
    axes.set_ylabel(f"{up} [m]")
    style.arrange(figure, [(axes, ACROSS / (right - left) * (top - bottom))], entries)
    return figure


def _isolator(axes: Axes, foot: Foot, side: float, seen: tuple[int, int], color: str) -> None:
    """An isolator behind its foot, seen along an axis: a cube below it of an upright one; of others a slim box, with an
    arrow along which it acts and the wall that it stands on."""
    from matplotlib.patches import Polygon

    if foot.upright:
        low = foot.z - side if seen[1] == 2 else foot.y - side / 2
        _box(axes, (foot.x - side / 2, low), side, side, color=color)
        return
    along, foot_at = np.array(foot.along), np.array([foot.x, foot.y, foot.z])
    long, wide = 1.5 * side, 0.6 * side
    across = np.linalg.svd(along[None])[2][1:]
    ends = [foot_at - share * long * along for share in (0.0, 1.0)]
    corners = [
        end + 0.5 * wide * (a * across[0] + b * across[1])
        for end, a, b in itertools.product(ends, (-1, 1), (-1, 1))
    ]  # fmt: skip
    axes.add_patch(Polygon(_hull(np.array(corners)[:, seen]), facecolor=color, edgecolor=color, zorder=2))
    flat = along[list(seen)]
    if np.hypot(*flat) < 0.3:
        return
    base, tip = ends[1][list(seen)], (foot_at + 0.8 * side * along)[list(seen)]
    wall = 0.5 * side * np.array([-flat[1], flat[0]]) / np.hypot(*flat)
    axes.plot(*np.array([base - wall, base + wall]).T, color=style.GREY, linewidth=1.8, zorder=2)
    look = {"arrowstyle": "-|>", "color": style.INK, "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0}
    middle = (ends[0] - 0.5 * long * along)[list(seen)]
    axes.annotate("", tuple(tip.tolist()), tuple(middle.tolist()), arrowprops=look, zorder=3)


def _hull(points: Array) -> Array:
    """Corners of the convex outline of points in a plane, (n, 2)."""
    from scipy.spatial import ConvexHull

    return np.asarray(points[ConvexHull(points).vertices])


def _names(axes: Axes, feet: Sequence[Foot], outline: Vector) -> None:
    """The feet's names beside them; where there is no room for all, their numbers in the table of mounts."""
    scale = ACROSS / float(np.ptp(axes.get_xlim()))
    names, numbers = [foot.name for foot in feet], [str(k) for k in range(1, len(feet) + 1)]
    for size, words in ((NAME_SIZE, names), (SMALL, names), (NAME_SIZE, numbers), (SMALL, numbers)):
        width, height = 0.62 * size / scale, 1.2 * size / scale
        places = _free_places(feet, [width * len(word) for word in words], height, outline)
        if None not in places or (size, words) == (SMALL, numbers):
            break
    for foot, word, place in zip(feet, words, places, strict=True):
        at = place or (foot.x, foot.y)
        axes.text(*at, word, ha="center", va="center", fontsize=size, zorder=5)


def _free_places(
    feet: Sequence[Foot], widths: Sequence[float], height: float, outline: Vector
) -> list[tuple[float, float] | None]:
    """Middle of the first free place for each foot's name: towards the machine's middle, else beside; None where
    there is none within the machine's outline."""
    (length, across, _), (_, side) = outline, _measures(outline)
    taken = [_extent(foot, side) for foot in feet]
    found: list[tuple[float, float] | None] = []
    for k, (foot, width) in enumerate(zip(feet, widths, strict=True)):
        inward, outer = (-1 if foot.y > 0 else 1), (1 if foot.x > 0 else -1)
        left, low, right, high = taken[k]
        flush = right - width / 2 if outer > 0 else left + width / 2
        beside = (left - 0.6 * width, right + 0.6 * width)
        above, below = high + 0.7 * height, low - 0.7 * height
        rows = (below, above) if inward < 0 else (above, below)
        choices = [(flush, rows[0]), (flush, rows[1]), *((x, 0.5 * (low + high)) for x in beside)]
        choices += [(0.5 * (left + right), row) for row in rows]
        free = None
        for x, y in choices:
            box = (x - width / 2, y - height / 2, x + width / 2, y + height / 2)
            inside = max(-box[0], box[2]) <= length / 2 and max(-box[1], box[3]) <= across / 2
            if inside and not any(_overlap(box, other) for j, other in enumerate(taken) if j != k):
                free = (x, y)
                taken.append(box)
                break
        found.append(free)
    return found


def _extent(foot: Foot, side: float) -> tuple[float, float, float, float]:
    """What a foot's drawing covers from above: left, low, right, high."""
    at, along = np.array([foot.x, foot.y]), np.array(foot.along[:2])
    if foot.upright:
        return (foot.x - side / 2, foot.y - side / 2, foot.x + side / 2, foot.y + side / 2)
    ends = np.array([at + share * side * along for share in (-1.5, 0.8)])
    low, high = ends.min(axis=0) - 0.3 * side, ends.max(axis=0) + 0.3 * side
    return (*low.tolist(), *high.tolist())


def _overlap(one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether two boxes (left, low, right, high) lie on each other."""
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]


def _foot_colors(feet: Sequence[Foot]) -> dict[str, str]:
    kinds = dict.fromkeys(foot.kind for foot in feet)
    return dict(zip(kinds, itertools.cycle((style.BLUE, style.GREEN, style.PURPLE, style.ORANGE)), strict=False))


def _box(axes: Axes, corner: tuple[float, float], across: float, up: float, **look: Any) -> None:
    from matplotlib.patches import Rectangle

    axes.add_patch(Rectangle(corner, across, up, **look))


def _in_metres(place: Vector) -> str:
    return f"({', '.join(f'{part:.3g}' for part in place)}) m".replace("-", "−")


def _cg(axes: Axes, place: tuple[float, float], radius: float) -> Artist:
    """The draughtsman's mark of a centre of gravity. Returns what stands for it in the legend."""
    from matplotlib.patches import Circle, Wedge

    axes.add_patch(Circle(place, radius, facecolor="white", edgecolor=style.INK, zorder=4))
    for first in (0.0, 180.0):
        axes.add_patch(Wedge(place, radius, first, first + 90.0, facecolor=style.INK, zorder=4))
    look = {"marker": "o", "markersize": 8, "fillstyle": "left", "markerfacecoloralt": "white"}
    return style.line_key(linestyle="none", color=style.INK, **look)


def _points(axes: Axes, points: Sequence[Mark], up: int) -> dict[str, Artist]:
    """A numbered cross at each point; ``up`` is the axis that points up. Returns the legend."""
    entries: dict[str, Artist] = {}
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    look: dict[str, Any] = {"linestyle": "none", "marker": "x", "markersize": 7, "markeredgewidth": 1.8}
    look["color"] = style.PURPLE
    for number, point in enumerate(points, start=1):
        at = (point.place[0], point.place[up])
        if not (left < at[0] < right and bottom < at[1] < top):
            continue  # an arm or a workpiece outside of the drawing
        sign = str(number) if len(points) > 1 else ""
        (cross,) = axes.plot(*at, zorder=5, **look)
        axes.annotate(sign, at, (5, 5), textcoords="offset points", color=style.PURPLE, fontsize=8.8, zorder=5)
        entries[style.shown(f"{sign} {point.name} {_in_metres(point.place)}".strip())] = cross
    return entries


def _tripod(axes: Axes, up: str, length: float) -> None:
    for tip, name in (((length, 0.0), "x"), ((0.0, length), up)):
        look = {"arrowstyle": "-|>", "color": style.LIMIT_COLOR, "linewidth": 1.2, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", tip, (0.0, 0.0), arrowprops=look)
        beyond = (5, 7) if name == "x" else (0, 6)
        axes.annotate(name, tip, beyond, textcoords="offset points", color=style.LIMIT_COLOR, ha="center", va="center")


def _dimension(axes: Axes, ends: Sequence[float], at: float, along: str) -> None:
    """A dimension line from end to end, at a distance, with its length [m]."""
    look = {"arrowstyle": "<|-|>", "color": "#4B5563", "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
    box = {"boxstyle": "square,pad=0.15", "facecolor": "white", "edgecolor": "none"}
    first, middle, last = ((x, at) if along == "x" else (at, x) for x in (ends[0], 0.5 * (ends[0] + ends[1]), ends[1]))
    axes.annotate("", last, first, arrowprops=look)
    turned, text = 90.0 if along == "y" else 0.0, f"{abs(ends[1] - ends[0]):.4g}"
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
