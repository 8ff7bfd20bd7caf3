"""Maps: a quantity over two parameters."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.arrays import Array
from ehamj.plots import style
from ehamj.plots.axes import plain
from ehamj.plots.charts import HEIGHT, Line, draw, entries_of, set_scales
from ehamj.plots.style import Axes, Figure, Text

BLANK: Final = "#D9DDE2"
APART: Final = 17.0
"""Least distance of the names of two contours [pt]."""


@style.styled()
def map_chart(
    title: str,
    x: tuple[str, ArrayLike],
    y: tuple[str, ArrayLike],
    values: tuple[str, ArrayLike],
    boundary: tuple[str, ArrayLike] | None = None,
    points: Sequence[Line] = (),
    levels: Sequence[float] | None = None,
    logarithmic: str = "",
    blank: str = "no value",
) -> Figure:
    """A quantity over two parameters as filled contours, with the boundary of stability.

    Contours go on as they are up to what has no value, so that no gap of the grid's size is left open.

    Args:
        title: of the figure.
        x: name with unit, and values (n,).
        y: name with unit, and values (m,).
        values: name with unit, and values (m, n); NaN where there are none.
        boundary: name, and a function (m, n) that is positive where designs are unstable: hatched.
        points: designs marked.
        levels: of the contours; round ones without.
        logarithmic: "x", "y" or "xy".
        blank: what it means that a stable design has no value; such designs are grey.
    """
    from matplotlib import colormaps
    from matplotlib.colors import ListedColormap
    from matplotlib.ticker import MaxNLocator

    across, up = np.asarray(x[1], float), np.asarray(y[1], float)
    values_at = np.asarray(values[1], float)
    reach = np.full(values_at.shape, -1.0) if boundary is None else np.asarray(boundary[1], float)
    known = np.isfinite(values_at) & (reach <= 0.0)
    field, empty = _continued(values_at, known), ~known & (reach <= 0.0)
    figure, (axes,) = style.new_figure(title)
    if levels is None:
        levels = MaxNLocator(10, steps=[1, 2, 2.5, 5, 10]).tick_values(float(field.min()), float(field.max()))
    steps = np.asarray(levels, float)
    colors = colormaps["viridis"](np.linspace(0.06, 0.98, len(steps) + 1))
    axes.contourf(across, up, field, levels=steps, colors=colors, extend="both", zorder=0.5)
    drawn = axes.contour(across, up, field, levels=steps, colors="white", linewidths=0.6, zorder=0.6)
    inks = ["white" if k <= 0.5 * len(steps) else style.INK for k in range(len(steps))]  # on dark, on bright
    names = axes.clabel(drawn, fontsize=8, fmt=plain, colors=inks)
    entries = {values[0]: style.line_key(color=colors[len(colors) // 2], linewidth=6.0)}
    if boundary is not None and reach.max() > 0.0:
        axes.contourf(across, up, reach, levels=[0.0, np.inf], colors=[style.UNSTABLE_COLOR], zorder=0.8)
        axes.contour(across, up, reach, levels=[0.0], colors=[style.LIMIT_COLOR], linewidths=2.0, zorder=0.9)
        entries[boundary[0]] = style.patch_key(facecolor=style.UNSTABLE_COLOR, edgecolor=style.LIMIT_COLOR)
    if empty.any():
        axes.pcolormesh(across, up, np.ma.masked_where(~empty, np.ones(empty.shape)), shading="nearest", zorder=0.7,
                        cmap=ListedColormap([BLANK]))  # fmt: skip
        entries[blank] = style.patch_key(facecolor=BLANK, edgecolor=style.GREY)
    draw(axes, points)
    axes.grid(False)
    axes.set(xlabel=x[0], ylabel=y[0], xlim=(across.min(), across.max()), ylim=(up.min(), up.max()))
    set_scales(axes, logarithmic)
    style.arrange(figure, [(axes, 1.15 * HEIGHT)], entries | entries_of([axes]))
    _thin_out(axes, names, points)
    return figure


def _continued(values: Array, known: NDArray[np.bool_]) -> Array:
    """Values, and where they are not known those of the nearest design of which they are."""
    from scipy.ndimage import distance_transform_edt

    if not known.any():
        return np.zeros(values.shape)
    nearest = distance_transform_edt(~known, return_distances=False, return_indices=True)
    return np.asarray(values[tuple(nearest)])


def _thin_out(axes: Axes, names: Sequence[Text], points: Sequence[Line]) -> None:
    """Take away contours' names that lie on another one, on a point or over the edge; colours count from dark to
    bright anyway."""
    taken = [
        axes.transData.transform(place)
        for line in points
        if line.marker and line.marker != "."
        for place in zip(np.ravel(line.x), np.ravel(line.y), strict=True)
    ]
    unit = axes.figure.dpi / style.INCH
    box = axes.get_window_extent()
    for name in names:
        at = axes.transData.transform(name.get_position())
        free = all(np.hypot(*(at - other)) > APART * unit for other in taken)
        inside = box.x0 + 8 * unit < at[0] < box.x1 - 8 * unit and box.y0 + 6 * unit < at[1] < box.y1 - 6 * unit
        if free and inside:
            taken.append(at)
        else:
            name.set_visible(False)
