"""Axes that draw grid, ticks and numbers at once: Matplotlib's five objects for each tick cost more than all lines.

A module of its own, since its classes need Matplotlib: `ehamj.plots.style.new_figure` imports it with the first figure,
which is of a class that stands here for that reason too.
"""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from matplotlib import rcParams
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import XAxis, YAxis
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.ticker import NullFormatter, NullLocator
from matplotlib.transforms import IdentityTransform

from ehamj.arrays import Array

if TYPE_CHECKING:
    from matplotlib.axis import Axis as Base
else:
    Base = object

PLACE: Final = IdentityTransform()
RC: Final[Any] = rcParams
"""The style that is in force."""
LOOKS: Final = {
    "gridOn", "length", "width", "color", "pad", "labelsize", "labelcolor", "grid_color", "grid_linewidth",
    *(f"{label}{side}" for label in ("", "label") for side in ("left", "right", "bottom", "top")),
}  # fmt: skip
"""What `tick_params` may have set of an axis that is drawn here."""


class _Shown(NamedTuple):
    """What an axis shows: its side, looks of its ticks, their places [px] and numbers, places of minor ones [px]."""

    side: str
    look: dict[str, Any]
    places: Array
    numbers: list[str]
    minor: Array


class _AtOnce(Base):
    """An axis that draws what its ticks would, at the same places; it makes none unless somebody asks for them.

    Looks are those that `tick_params` and the style give. What it does not do (numbers at both sides, turned ones, an
    offset of all numbers beside the axis) is left to Matplotlib.
    """

    SIDES: tuple[str, str]
    axis_name: str
    _named: bool = False

    def set_clip_path(self, path: Any, transform: Any = None) -> None:
        """Of the axis alone: its grid ends at the axes by itself."""
        Artist.set_clip_path(self, path, transform)

    def set_tick_params(self, which: Any = "major", reset: bool = False, **look: Any) -> None:
        """Looks of ticks, of those that are there and of those to come."""
        absent = [name for name in ("majorTicks", "minorTicks") if name not in self.__dict__]
        self.__dict__.update({name: [] for name in absent})  # or asking for them would make the first
        super().set_tick_params(which=which, reset=reset, **look)
        for name in absent:
            self.__dict__.pop(name, None)

    def set_label_coords(self, x: float, y: float, transform: Any = None) -> None:
        """Where the axis' name stands, however long its numbers are."""
        self._named = True
        super().set_label_coords(x, y, transform)

    def draw(self, renderer: Any) -> None:
        """Grid, ticks, numbers and name."""
        shown = self._shown() if self.get_visible() else None
        if shown is None:
            super().draw(renderer)
            return
        renderer.open_group("matplotlib.axis", gid=self.get_gid())
        look, (low, high) = shown.look, self._ends(across=True)
        if look.get("gridOn", False):
            color, width = (look.get(f"grid_{name}", RC[f"grid.{name}"]) for name in ("color", "linewidth"))
            self._strokes(renderer, shown.places, (low, high), color, width)
        room = self._ticks(renderer, shown.side, shown.places, "major", look)
        self._ticks(renderer, shown.side, shown.minor, "minor", self.get_tick_params("minor"))
        if look.get(f"label{shown.side}", shown.side == self.SIDES[0]):
            room = self._numbers(renderer, shown, room)
        if self.label.get_text() and not self._named:
            self._put_name(renderer, room)
        self.label.draw(renderer)
        renderer.close_group("matplotlib.axis")
        self.stale = False

    def _shown(self) -> _Shown | None:
        """What there is to draw; None where that is Matplotlib's business."""
        look, (first, second) = self.get_tick_params(), self.SIDES
        side = second if look.get(second, False) or look.get(f"label{second}", False) else first
        if side == second and (look.get(first, True) or look.get(f"label{first}", True)):
            return None
        fine = not isinstance(self.get_minor_locator(), NullLocator)
        if look.keys() - LOOKS or (fine and not isinstance(self.get_minor_formatter(), NullFormatter)):
            return None
        values = np.asarray(self.get_majorticklocs(), float)
        formatter = self.get_major_formatter()
        numbers = formatter.format_ticks(list(values))
        if formatter.get_offset():
            return None
        places, seen = self._places(values)
        minor, inside = self._places(np.asarray(self.get_minorticklocs() if fine else (), float))
        kept = [number for number, one in zip(numbers, seen, strict=True) if one]
        return _Shown(side, look, places[seen], kept, minor[inside])

    def _ends(self, across: bool) -> tuple[float, float]:
        """From where to where the axes reach along the axis, or across it [px]."""
        box = self.axes.bbox
        return (box.y0, box.y1) if (self.axis_name == "x") == across else (box.x0, box.x1)

    def _places(self, values: Array) -> tuple[Array, Array]:
        """Places of values [px], and which of them are in sight."""
        (low, high), (begin, end) = self.get_view_interval(), self._ends(across=False)
        scaled = self.get_transform().transform(np.array([low, high, *values]))
        share = (scaled[2:] - scaled[0]) / (scaled[1] - scaled[0])
        return begin + share * (end - begin), (share > -1e-10) & (share < 1.0 + 1e-10)

    def _strokes(self, renderer: Any, places: Array, ends: tuple[float, float], color: Any, width: float) -> None:
        """Lines across the axis at places, from one end to the other, all one path [px]; their width in pt."""
        if not len(places):
            return
        points = np.empty((2 * len(places), 2))
        along = 0 if self.axis_name == "x" else 1
        points[:, along], points[:, 1 - along] = np.repeat(places, 2), np.tile(ends, len(places))
        gc = renderer.new_gc()
        gc.set_foreground(color)
        gc.set_linewidth(renderer.points_to_pixels(width))
        renderer.draw_path(gc, Path(points, [Path.MOVETO, Path.LINETO] * len(places)), PLACE)
        gc.restore()

    def _ticks(self, renderer: Any, side: str, places: Array, which: str, look: dict[str, Any]) -> float:
        """Draw ticks of one kind outwards; gives their length [px]."""
        if not look.get(side, side == self.SIDES[0]):
            return 0.0
        name, out = f"{self.axis_name}tick", -1.0 if side == self.SIDES[0] else 1.0
        length = renderer.points_to_pixels(look.get("length", RC[f"{name}.{which}.size"]))
        edge = self._ends(across=True)[side != self.SIDES[0]]
        width = look.get("width", RC[f"{name}.{which}.width"])
        self._strokes(renderer, places, (edge, edge + out * length), look.get("color", RC[f"{name}.color"]), width)
        return float(length)

    def _numbers(self, renderer: Any, shown: _Shown, room: float) -> float:
        """Draw the numbers, further out than ``room``; gives how far they reach [px]."""
        out = -1.0 if shown.side == self.SIDES[0] else 1.0
        edge = self._ends(across=True)[shown.side != self.SIDES[0]]
        pad = shown.look.get("pad", RC[f"{self.axis_name}tick.major.pad"])
        room += renderer.points_to_pixels(pad)
        one = self._number(shown)
        box = one.get_window_extent(renderer)  # about its baseline's origin
        places = np.empty((len(shown.places), 2))
        if self.axis_name == "x":
            places[:, 0], places[:, 1] = shown.places, edge - room - box.y1 if out < 0.0 else edge + room - box.y0
            size = box.height
        else:
            places[:, 0], places[:, 1] = edge + out * room, shown.places - 0.5 * box.y1
            size = 0.0 if self._named else self._widest(renderer, one, shown.numbers)
        self._write(renderer, one, shown.numbers, places)
        return float(room + size)

    def _number(self, shown: _Shown) -> Text:
        """A number at the origin, which looks like all of them."""
        name, look = f"{self.axis_name}tick", shown.look
        color = look.get("labelcolor", RC[f"{name}.labelcolor"])
        align: Any = "center" if self.axis_name == "x" else "right" if shown.side == "left" else "left"
        one = Text(0.0, 0.0, "".join(shown.numbers[:1]), verticalalignment="baseline", horizontalalignment=align)
        one.set_color(RC[f"{name}.color"] if color == "inherit" else color)
        one.set_fontsize(look.get("labelsize", RC[f"{name}.labelsize"]))
        one.set_figure(self.axes.figure)
        return one

    def _widest(self, renderer: Any, one: Text, numbers: list[str]) -> float:
        """Width of the widest number [px]."""
        font = one.get_fontproperties()
        return max((renderer.get_text_width_height_descent(text, font, False)[0] for text in numbers), default=0.0)

    def _write(self, renderer: Any, one: Text, numbers: list[str], places: Array) -> None:
        """Write numbers that look like one, at places of their baselines, (n, 2) [px]."""
        gc, font = renderer.new_gc(), one.get_fontproperties()
        gc.set_foreground(one.get_color())
        height = renderer.get_canvas_width_height()[1]
        # An SVG's text is anchored as the Text says; who draws letters begins where he is told.
        svg = type(getattr(renderer, "_renderer", renderer)).__name__ == "RendererSVG"
        anchored = svg and RC["svg.fonttype"] == "none"
        before = 0.0 if anchored else {"left": 0.0, "center": 0.5, "right": 1.0}[one.get_horizontalalignment()]
        for number, (x, y) in zip(numbers, places, strict=True):
            if number:
                one.set_position((x, y))  # which says where it is anchored
                if before:
                    x -= before * self._widest(renderer, one, [number])
                renderer.draw_text(gc, x, height - y if renderer.flipy() else y, number, font, 0.0, mtext=one)
        gc.restore()

    def _put_name(self, renderer: Any, room: float) -> None:
        """Move the axis' name out of the numbers' room [px]."""
        side = self.get_label_position()
        room += renderer.points_to_pixels(self.labelpad)
        at = self._ends(across=True)[side != self.SIDES[0]] + (-room if side == self.SIDES[0] else room)
        self.label.set_y(at) if self.axis_name == "x" else self.label.set_x(at)


class _X(_AtOnce, XAxis):
    """A horizontal one."""

    SIDES = "bottom", "top"


class _Y(_AtOnce, YAxis):
    """A vertical one."""

    SIDES = "left", "right"


class SwiftAxes(Axes):
    """Axes with such axes; all else is Matplotlib's."""

    def _init_axis(self) -> None:
        self.xaxis, self.yaxis = _X(self, clear=False), _Y(self, clear=False)
        for spine, axis in zip(("bottom", "top", "left", "right"), (self.xaxis,) * 2 + (self.yaxis,) * 2, strict=True):
            self.spines[spine].register_axis(axis)

    def clear(self) -> None:
        """As Matplotlib's; its spines find their place when the first tick is made, so here they are told."""
        super().clear()
        for spine in self.spines.values():
            spine.set_position(("outward", 0.0))


class StyledFigure(Figure):
    """A figure that is drawn in its own style by whoever draws it: a notebook, or a user who saves it."""

    within: Callable[[], AbstractContextManager[None]] = staticmethod(nullcontext)

    def draw(self, renderer: Any) -> None:
        """As Matplotlib's, within the style."""
        with self.within():
            super().draw(renderer)

    def get_tightbbox(self, *given: Any, **more: Any) -> Any:
        """As Matplotlib's, within the style."""
        with self.within():
            return super().get_tightbbox(*given, **more)
