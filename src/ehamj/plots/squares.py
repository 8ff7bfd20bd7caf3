"""Matrices as coloured squares with their numbers: correlations, likeness of shapes."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from ehamj.plots import style
from ehamj.plots.axes import fixed_axis
from ehamj.plots.style import Figure

LETTER: Final = 5.0
"""Width of a letter of a row's name [pt]."""
LARGEST: Final = 34.0
"""Side of a square, where there is room for it [pt]."""
NUMBERS: Final = 16.0
"""Side of a square from which on it shows its number [pt]."""
LONGEST: Final = 34


@style.styled()
def squares_chart(
    title: str, rows: Sequence[str], columns: Sequence[str], values: ArrayLike, signed: bool = True
) -> Figure:
    """A matrix (row, column) of numbers from −1, or from 0, to 1; NaN stays white.

    Args:
        title: of the figure.
        rows: their names.
        columns: their names, short; they stand upright above.
        values: numbers.
        signed: whether they may be negative.
    """
    from matplotlib import colormaps

    found = np.asarray(values, float).reshape(len(rows), len(columns))
    figure, (axes,) = style.new_figure(title)
    colors = colormaps["RdBu" if signed else "Blues"]
    axes.imshow(np.ma.masked_invalid(found), cmap=colors, vmin=-1.0 if signed else 0.0, vmax=1.0, aspect="auto")
    left = 12.0 + LETTER * max(len(style.shown(name, LONGEST)) for name in rows)
    side = min(LARGEST, (style.WIDTH - left - 14.0) / len(columns))
    if side >= NUMBERS:
        for (i, j), value in np.ndenumerate(found):
            text = "–" if np.isnan(value) else f"{value:.2f}".replace("-", "−").replace("0.", ".")
            dark = abs(value) > 0.62
            axes.text(j, i, text, ha="center", va="center", fontsize=min(8.0, 0.34 * side),
                      color="white" if dark else style.INK)  # fmt: skip
    axes.grid(False)
    fixed_axis(axes.yaxis, range(len(rows)), [style.shown(name, LONGEST) for name in rows])
    fixed_axis(axes.xaxis, range(len(columns)), [style.shown(name, LONGEST) for name in columns])
    axes.tick_params(length=0.0, labelsize=8.5, top=False, labeltop=True, bottom=False, labelbottom=False)
    upright = max(map(len, columns)) > 2
    axes.tick_params(axis="x", labelrotation=90.0 if upright else 0.0)
    above = 10.0 + (LETTER * max(len(style.shown(name, LONGEST)) for name in columns) if upright else 8.0)
    heading = 24.0 + 13.0 * style.wrapped(title).count("\n")
    width, height = style.WIDTH, heading + above + side * len(rows) + 8.0
    figure.set_size_inches(width / style.INCH, height / style.INCH)
    figure.suptitle(style.wrapped(title), x=6.0 / width, y=1.0 - 6.0 / height, ha="left", va="top")
    size = side * len(columns) / width, side * len(rows) / height
    axes.set_position((left / width, 8.0 / height, *size))
    return figure
