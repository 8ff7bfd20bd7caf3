"""Axes that draw their ticks at once look as Matplotlib's own: the same numbers, grid and ticks at the same places."""

import io
import re
from collections.abc import Callable
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.axis import Tick
from matplotlib.figure import Figure
from matplotlib.ticker import AutoMinorLocator

from ehamj.plots.axes import linear_axis, log_axis
from ehamj.plots.axis import SwiftAxes
from ehamj.plots.style import STYLE

SVG = "{http://www.w3.org/2000/svg}"
LINK = "{http://www.w3.org/1999/xlink}href"


def plain(axes: Axes) -> None:
    axes.set(xlim=(-3.0, 7.0), ylim=(0.0, 1.0), xlabel="time [s]", ylabel="force [N]")
    linear_axis(axes.xaxis)


def logarithmic(axes: Axes) -> None:
    axes.set(xlim=(0.7, 130.0), ylim=(2e-4, 3.0))
    for axis in (axes.xaxis, axes.yaxis):
        log_axis(axis)


def downwards(axes: Axes) -> None:
    axes.set(xlim=(4.0, 0.5), ylim=(3.0, -0.6), ylabel="depth [m]")


def other_sides(axes: Axes) -> None:
    axes.yaxis.set_ticks_position("right")
    axes.yaxis.set_label_position("right")
    axes.xaxis.set_ticks_position("top")
    axes.set(ylabel="level [dB]", ylim=(-1234.0, 20.0))


def special(axes: Axes) -> None:
    axes.tick_params(labelsize=7.5, length=2)
    axes.tick_params(axis="x", labelbottom=False)
    axes.grid(False, axis="y")
    axes.set_yticks([0.1, 0.5], ["low", "high"])
    axes.xaxis.set_minor_locator(AutoMinorLocator(2))


def left_to_matplotlib(axes: Axes) -> None:
    axes.tick_params(axis="x", labelrotation=30)
    axes.tick_params(axis="y", right=True, labelright=True)


CASES = [plain, logarithmic, downwards, other_sides, special, left_to_matplotlib]


def seen(kind: type[Axes], furnish: Callable[[Axes], None]) -> tuple[list[object], list[tuple[float, ...]]]:
    """Texts with their places, and the ends of all thin lines [pt]."""
    with matplotlib.rc_context(STYLE), io.StringIO() as file:
        figure = Figure(figsize=(4.0, 3.0))
        axes = figure.subplots(subplot_kw={"axes_class": kind})
        furnish(axes)
        figure.savefig(file, format="svg")
        root = ElementTree.fromstring(file.getvalue())
    texts = [
        (text.text, *(round(float(text.get(key, "nan")), 3) for key in "xy"), text.get("style"))
        for text in root.iter(f"{SVG}text")
        if text.get("x")
    ]
    shapes = {f"#{path.get('id')}": path.get("d", "") for path in root.iter(f"{SVG}path") if path.get("id")}
    placed = [
        (shapes[use.get(LINK, "")], float(use.get("x", 0)), float(use.get("y", 0))) for use in root.iter(f"{SVG}use")
    ]
    placed += [(path.get("d", ""), 0.0, 0.0) for path in root.iter(f"{SVG}path") if not path.get("id")]
    lines = []
    for shape, x, y in placed:
        for piece in re.findall(r"M ([-\d.]+) ([-\d.]+)\s+L ([-\d.]+) ([-\d.]+)\s+(?!L)", shape):
            a, b, c, d = map(float, piece)
            lines.append(tuple(round(value, 2) for value in (a + x, b + y, c + x, d + y)))
    return sorted(texts, key=repr), sorted(lines)


@pytest.mark.parametrize("furnish", CASES)
def test_numbers_names_grid_and_ticks_are_where_matplotlib_has_them(furnish: Callable[[Axes], None]) -> None:
    (texts, lines), (own_texts, own_lines) = seen(Axes, furnish), seen(SwiftAxes, furnish)
    assert len(texts) >= 2
    assert len(lines) > 4
    assert own_texts == texts
    assert len(own_lines) == len(lines)
    assert np.allclose(own_lines, lines, rtol=0.0, atol=0.02)  # files have six decimals, rounded here to two


def test_no_tick_is_made_for_a_figure(monkeypatch: pytest.MonkeyPatch) -> None:
    made = []
    monkeypatch.setattr(Tick, "__init__", lambda self, *given, **look: made.append(given))
    seen(SwiftAxes, plain)
    assert not made


def test_who_asks_for_ticks_gets_them() -> None:
    with matplotlib.rc_context(STYLE):
        axes = Figure().subplots(subplot_kw={"axes_class": SwiftAxes})
        axes.set_yticks([0.1, 0.5], ["low", "high"])
        axes.tick_params(labelsize=7.5)
        found = axes.get_yticklabels()
    assert [label.get_text() for label in found] == ["low", "high"]
    assert {label.get_fontsize() for label in found} == {7.5}
