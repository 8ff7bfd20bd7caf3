"""Root loci: where the poles of a loop go as its gain rises."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.plots import style
from ehamj.plots.axes import plain
from ehamj.plots.style import Artist, Axes, Figure

RAYS: Final = (0.05, 0.1, 0.2, 0.5)
"""Damping ratios that a locus shows as rays."""
SYMBOLS: Final = ("x", "s", "D")
"""Marks of gains, in their order."""
FEWEST: Final = 1e-3
"""Share of the picture below which a branch's step is left out."""


@dataclass(frozen=True)
class Branch:
    """One pole over the gain: (n,) [1/s], NaN where there is none; without a name it is drawn faint."""

    label: str
    poles: ComplexArray
    color: str


@dataclass(frozen=True)
class View:
    """A part of the upper half plane: lowest real part and highest imaginary part, over 2π [Hz]."""

    left: float
    top: float


@style.styled()
def locus_chart(title: str, branches: Sequence[Branch], marks: Mapping[str, int], views: Sequence[View]) -> Figure:
    """Root locus of the upper half plane; right of the red line the loop is unstable, grey rays are damping ratios.

    Args:
        title: of the figure.
        branches: poles over the same gains; later ones lie on top.
        marks: name → number of a gain at which every pole is marked, at most as many as `SYMBOLS`.
        views: parts that are shown, below each other.
    """
    figure, axes = style.new_figure(title, len(views))
    for one, view in zip(axes, views, strict=True):
        right = 0.12 * abs(view.left)
        one.set(xlim=(view.left, right), ylim=(0.0, view.top), ylabel="imaginary part/2π [Hz]")
        one.set_xlabel("real part/2π [Hz]")
        one.axvspan(0.0, right, color=style.UNSTABLE_COLOR, zorder=0)
        one.axvline(0.0, color=style.LIMIT_COLOR, linewidth=1.4, zorder=1)
        _rays(one, view)
        for branch in branches:
            _branch(one, branch, marks, view)
    axes[-1].set_xlabel("real part/2π [Hz]; right of the red line: unstable")
    style.arrange(
        figure, [(one, 1.05 * style.WIDTH / 2.0) for one in axes], _entries(branches, marks), gap=52.0, head=10.0
    )
    return figure


def _branch(axes: Axes, branch: Branch, marks: Mapping[str, int], view: View) -> None:
    roots: ComplexArray = np.asarray(branch.poles / (2.0 * np.pi), complex)
    seen = (roots.imag >= -1e-6 * view.top) & (roots.imag <= view.top) & (roots.real >= view.left)
    if not seen.any():
        return
    near = np.convolve(seen, [1, 1, 1], "same") > 0  # one step beyond the edge, so that lines reach it
    roots = np.asarray(np.where(near & (roots.imag >= -1e-6 * view.top), roots, np.nan), complex)
    named = bool(branch.label)
    width, size = (1.8, 5.5) if named else (0.9, 3.5)
    line, order = _without_small_steps(roots, view), 3.0 if named else 2.0
    axes.plot(line.real, line.imag, color=branch.color, linewidth=width, zorder=order)
    look: dict[str, Any] = {"color": branch.color, "markerfacecolor": "white", "markersize": size}
    look |= {"markeredgewidth": 0.7 * width, "zorder": order + 0.5}
    for row, symbol in zip(marks.values(), SYMBOLS, strict=False):
        axes.plot([roots[row].real], [roots[row].imag], symbol, **look)


def _without_small_steps(roots: ComplexArray, view: View) -> ComplexArray:
    """The branch without points that nobody sees: a pole that stays where it is needs no 120 of them."""
    kept = [0]
    for k in range(1, roots.size):
        step = roots[k] - roots[kept[-1]]
        small = math.hypot(step.real / view.left, step.imag / view.top) < FEWEST
        if not small or not np.isfinite(step):
            kept.append(k)
    return roots[kept]


def _rays(axes: Axes, view: View) -> None:
    """Damping ratios as rays from the origin, named where they leave the picture."""
    for ratio in RAYS:
        slope = math.sqrt(1.0 - ratio**2) / ratio
        up = min(view.top, -view.left * slope)
        at = (-up / slope, up)
        axes.plot([0.0, at[0]], [0.0, at[1]], color="#B8BEC6", linewidth=0.8, linestyle=(0, (1, 2)), zorder=1)
        beside = up < view.top
        axes.annotate(
            f"{plain(100.0 * ratio)} %", at, (2, 3) if beside else (0, 2), textcoords="offset points",
            ha="left" if beside else "center", va="bottom", fontsize=7.5, color=style.GREY,
        )  # fmt: skip


def _entries(branches: Sequence[Branch], marks: Mapping[str, int]) -> dict[str, Artist]:
    entries: dict[str, Artist] = {}
    for branch in branches:
        if branch.label:
            entries[style.shown(branch.label)] = style.line_key(color=branch.color, linewidth=1.8)
    if any(not branch.label for branch in branches):
        entries["other poles"] = style.line_key(color=style.GREY, linewidth=0.9)
    for name, symbol in zip(marks, SYMBOLS, strict=False):
        entries[name] = style.line_key(
            color=style.INK, linestyle="none", marker=symbol, markerfacecolor="white", markersize=5.5
        )
    entries["damping ratio"] = style.line_key(color="#8F97A0", linewidth=0.9, linestyle=(0, (1, 2)))
    return entries


def view_of(poles: Array | ComplexArray, room: float = 1.15) -> View:
    """A view around poles [1/s] of any shape, with some room."""
    known = np.asarray(poles, complex) / (2.0 * np.pi)
    known = known[np.isfinite(known)]
    top = room * float(known.imag.max(initial=1e-3))
    return View(-max(room * float(-known.real.min(initial=0.0)), 0.1 * top), top)
