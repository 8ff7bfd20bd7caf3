"""Designs as points: every column against every other, and what is best in two at a time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.arrays import Array
from ehamj.plots import style
from ehamj.plots.axes import linear_axis
from ehamj.plots.charts import HEIGHT
from ehamj.plots.style import Artist, Axes, Figure

MOST: Final = 600
"""Points of a group that a panel shows, and that a cell of a matrix shows: more would be a blot of megabytes."""
MOST_OF_A_CELL: Final = 250
BINS: Final = 14
CELL_GAP: Final = 5.0
"""Room between the cells of a matrix [pt]."""
NEAR: Final = 13.0
"""Least distance of two numbers beside points [pt]."""
LOOKS: Final[tuple[dict[str, Any], ...]] = (
    {"marker": ".", "color": style.BLUE, "markersize": 4.0, "alpha": 0.55, "markeredgewidth": 0.0},
    {"marker": "x", "color": style.GREY, "markersize": 3.2, "alpha": 0.7, "markeredgewidth": 0.7},
    {"marker": "s", "color": style.VERMILLION, "markersize": 4.2, "markerfacecolor": "white", "markeredgewidth": 1.2},
    {"marker": "D", "color": style.INK, "markersize": 5.5, "markerfacecolor": style.ORANGE, "markeredgewidth": 1.2},
)
"""Of the groups, told apart in grey too: dots, crosses, squares, diamonds."""


@dataclass(frozen=True)
class Cloud:
    """Points of one look: which of the rows, by number; ``look`` counts `LOOKS`."""

    label: str
    rows: Sequence[int] | NDArray[np.int_]
    look: int = 0

    def drawn(self, most: int) -> NDArray[np.int_]:
        """Rows that are drawn, evenly taken where there are more."""
        rows = np.asarray(self.rows, int)
        return rows if len(rows) <= most else rows[np.linspace(0, len(rows) - 1, most).round().astype(int)]


@dataclass(frozen=True)
class Pair:
    """Two columns against each other: name with unit, and values of all rows.

    ``numbers`` stand beside the rows that they are of; ``line`` joins those rows, in this order.
    """

    x: tuple[str, ArrayLike]
    y: tuple[str, ArrayLike]
    numbers: Mapping[int, str] = field(default_factory=dict)
    line: Sequence[int] = ()
    better: str = ""
    """Where the better ones lie, in words."""


def _points(axes: Axes, clouds: Sequence[Cloud], x: Array, y: Array, most: int = MOST) -> dict[str, Artist]:
    entries = {}
    for place, cloud in enumerate(clouds):
        look, rows = LOOKS[cloud.look], cloud.drawn(most)
        axes.plot(x[rows], y[rows], linestyle="none", zorder=2.0 + 0.1 * place + (cloud.look >= 2), **look)
        entries[style.shown(cloud.label, 48)] = style.line_key(linestyle="none", **(look | {"alpha": 1.0}))
    return entries


@style.styled()
def pairs_chart(title: str, pairs: Sequence[Pair], clouds: Sequence[Cloud]) -> Figure:
    """Panels below each other, two columns in each; squares may have numbers beside them."""
    figure, axes = style.new_figure(title, len(pairs))
    entries: dict[str, Artist] = {}
    height = HEIGHT if len(pairs) == 1 else 0.8 * HEIGHT
    for one, pair in zip(axes, pairs, strict=True):
        x, y = np.asarray(pair.x[1], float), np.asarray(pair.y[1], float)
        entries |= _points(one, clouds, x, y)
        if len(pair.line):
            rows = np.asarray(pair.line, int)
            one.plot(x[rows], y[rows], color=style.VERMILLION, linewidth=1.1, zorder=2.9)
        one.set(xlabel=pair.x[0], ylabel=pair.y[0])
        one.margins(x=0.05, y=0.08)
        linear_axis(one.xaxis, 5)
        linear_axis(one.yaxis, 5)
        if pair.better:
            one.set_title(pair.better, loc="right", fontsize=8.8, color=style.GREY, pad=2.0)
    style.arrange(figure, [(one, height) for one in axes], entries, gap=58.0, head=14.0)
    for one, pair in zip(axes, pairs, strict=True):
        _numbered(one, pair)
    return figure


def _numbered(axes: Axes, pair: Pair) -> None:
    """Write numbers beside points, but for those that would lie on one that is there."""
    unit, taken = axes.figure.dpi / style.INCH, list[Any]()
    x, y = np.asarray(pair.x[1], float), np.asarray(pair.y[1], float)
    for row, text in pair.numbers.items():
        at = axes.transData.transform((x[row], y[row]))
        if not np.isfinite(at).all() or any(
            abs(at[0] - other[0]) < (NEAR + 2.5 * len(text)) * unit and abs(at[1] - other[1]) < 0.8 * NEAR * unit
            for other in taken
        ):
            continue  # fmt: skip
        taken.append(at)
        axes.annotate(
            text,
            (x[row], y[row]),
            (4, 3),
            textcoords="offset points",
            fontsize=7.8,
            zorder=6,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.3},
        )


@style.styled()
def scatter_matrix(title: str, columns: Mapping[str, ArrayLike], clouds: Sequence[Cloud]) -> Figure:
    """Every column against every other below the diagonal, its own spread on it, rank correlations above it.

    Args:
        title: of the figure.
        columns: at least two; what each is, its unit in brackets at the end, and its values of all rows.
        clouds: which rows are drawn how; spread and correlation are of all their rows.
    """
    names, values = list(columns), [np.asarray(column, float) for column in columns.values()]
    count, rows = len(names), np.unique(np.concatenate([np.asarray(cloud.rows, int) for cloud in clouds]))
    figure, grid = style.new_grid(title, count, count)
    entries: dict[str, Artist] = {}
    for up in range(count):
        for across in range(count):
            axes = grid[up, across]
            if across < up:
                entries |= _points(axes, clouds, values[across], values[up], MOST_OF_A_CELL)
                axes.margins(0.08)
            elif across == up:
                _spread(axes, values[up][rows])
            else:
                _correlation(axes, values[across][rows], values[up][rows])
    _name_cells(grid, names)
    _place_cells(figure, grid, entries)
    return figure


def _spread(axes: Axes, values: Array) -> None:
    known = values[np.isfinite(values)]
    axes.hist(known, bins=BINS, color=style.BLUE, alpha=0.3, edgecolor=style.BLUE, linewidth=0.6)
    axes.margins(x=0.08)


def _correlation(axes: Axes, x: Array, y: Array) -> None:
    from scipy.stats import spearmanr

    known = np.isfinite(x) & np.isfinite(y)
    still = known.sum() < 3 or np.ptp(x[known]) == 0.0 or np.ptp(y[known]) == 0.0
    rank = 0.0 if still else float(spearmanr(x[known], y[known]).statistic)
    text = "–" if still else f"{rank:.2f}".replace("-", "−")
    weight = "bold" if abs(rank) >= 0.5 else "normal"
    color = style.INK if abs(rank) >= 0.3 else style.GREY
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color=color, fontsize=9.5,
              fontweight=weight)  # fmt: skip
    axes.set_axis_off()


def _name_cells(grid: Any, names: Sequence[str]) -> None:
    """Numbers and names at the outer cells alone; no number where two cells meet."""
    from matplotlib.ticker import MaxNLocator

    count = len(names)
    for up in range(count):
        for across in range(up + 1):
            axes = grid[up, across]
            for one in (axes.xaxis, axes.yaxis):
                linear_axis(one)
                one.set_major_locator(MaxNLocator(3 if count > 3 else 4, prune="both"))
            axes.tick_params(labelsize=7.2, pad=1.5, length=2.0)
            axes.tick_params(labelbottom=up == count - 1, labelleft=across == 0 and up > 0)
            if up == count - 1:
                axes.set_xlabel(_broken(names[across]), fontsize=7.6)
            if across == 0 and up > 0:
                axes.set_ylabel(_broken(names[up]), fontsize=7.6)
            if across == up:
                axes.tick_params(left=False, labelleft=False)
                axes.grid(False)


def _broken(name: str, letters: int = 15) -> str:
    """A name in lines of so many letters, its unit in one of its own."""
    import textwrap

    what, bracket, unit = name.rpartition(" [")
    lines = textwrap.wrap(what or name, letters)[:2]
    return "\n".join([*lines, f"[{unit}"] if bracket else lines)


def _place_cells(figure: Figure, grid: Any, entries: Mapping[str, Artist]) -> None:
    """Square cells below title and legend."""
    count, left, right, below = len(grid), 64.0, 14.0, 54.0
    side = (style.WIDTH - left - right - CELL_GAP * (count - 1)) / count
    title = style.wrapped(figure.get_suptitle())
    columns = style.legend_columns(list(entries), style.WIDTH - 12.0)
    name = 24.0 + 13.0 * title.count("\n")
    keys = 12.0 * -(-len(entries) // columns) + 10.0
    height = name + keys + count * side + CELL_GAP * (count - 1) + below
    figure.set_size_inches(style.WIDTH / style.INCH, height / style.INCH)
    figure.suptitle(title, x=6.0 / style.WIDTH, y=1.0 - 6.0 / height, ha="left", va="top")
    style.legend(figure, entries, (6.0 / style.WIDTH, 1.0 - name / height), columns)
    for up in range(count):
        for across in range(count):
            x, y = left + across * (side + CELL_GAP), below + (count - 1 - up) * (side + CELL_GAP)
            axes = grid[up, across]
            axes.set_position((x / style.WIDTH, y / height, side / style.WIDTH, side / height))
            axes.yaxis.set_label_coords(-29.0 / side, 0.5)
