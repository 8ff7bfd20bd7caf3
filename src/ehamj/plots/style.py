"""What all figures share: colours, type, margins and the place of title, legend and axes."""

import itertools
import textwrap
import threading
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

import numpy as np

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure
    from matplotlib.text import Text
else:  # names for annotations: Matplotlib itself is imported when the first figure is drawn
    Artist = Axes = Axis = Figure = Text = Any


INCH: Final = 72.0
WIDTH: Final = 374.0
"""Width of every figure [pt]."""

TITLE_LETTERS: Final = 52
"""Letters of a title that fit into a line: bold ones are 7 pt wide on average."""
LEFT, BELOW = 58.0, 40.0
"""Room left of and below every axes, for numbers and names [pt]."""

BLUE, VERMILLION, GREEN, PURPLE, SKY, ORANGE = "#0072B2", "#D55E00", "#00855F", "#B5578F", "#56B4E9", "#E69F00"
FLOOR_COLOR: Final = "#A3ACB5"
GREY: Final = "#6E7781"
INK: Final = "#1F2933"
FAINT: Final = "#C9CFD6"
BAND_COLOR: Final = "#C9CFD6"
"""Between what values those lie that are not drawn one by one."""
LIMIT_COLOR: Final = "#B00020"
UNSTABLE_COLOR: Final = "#F3D9D5"
"""What lies beyond the boundary of stability."""
MOMENT_COLOR: Final = "#6D28D9"
"""Lines at times at which something happened."""
MARKERS: Final = {BLUE: "o", VERMILLION: "s", GREEN: "^", PURPLE: "D", SKY: "v", ORANGE: "P"}
MOUNT_COLORS: Final = (PURPLE, ORANGE, GREEN, "#1A1A1A", BLUE, VERMILLION, SKY)

STYLE: Final[Any] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.5,
    "figure.titlesize": 10.5,
    "figure.titleweight": "bold",
    "axes.labelsize": 9.5,
    "axes.labelcolor": INK,
    "axes.edgecolor": "#8A939C",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.titley": 1.0,  # or every axes is measured to find out where its title has room
    "axes.formatter.useoffset": False,
    "grid.color": "#E4E7EB",
    "grid.linewidth": 0.7,
    "text.color": INK,
    "text.parse_math": False,  # names are the user's, and a dollar in them is a dollar
    "xtick.color": INK,
    "ytick.color": INK,
    "legend.frameon": False,
    "legend.fontsize": 8.8,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.2,
    "legend.labelspacing": 0.3,
    "legend.borderpad": 0.2,
    "svg.fonttype": "none",
    "svg.hashsalt": "ehamj",
}

FONTS: Final = "'Segoe UI', Roboto, Helvetica, Arial, 'Liberation Sans', sans-serif"
"""Fonts of the text in an SVG: none is wider than the one that the layout is computed with."""


_DRAWING: Final = threading.RLock()
"""Held by whoever draws: Matplotlib's style is one for all threads, and who leaves it takes it from the others."""


@contextmanager
def styled() -> Iterator[None]:
    """The style of all figures; decorates what draws one."""
    import matplotlib

    with _DRAWING, matplotlib.rc_context(STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing")  # the reader's fonts draw the text, not these
        yield


def new_figure(title: str, panels: int = 1, **look: Any) -> tuple[Figure, list[Axes]]:
    """A figure with so many axes below each other, which `arrange` will place."""
    figure, grid = new_grid(title, panels, 1, **look)
    return figure, list(grid[:, 0])


def new_grid(title: str, rows: int, columns: int, **look: Any) -> tuple[Figure, Any]:
    """A figure, and its axes as an array (rows, columns); ``look`` as `Figure.subplots` takes it."""
    from ehamj.plots.axis import StyledFigure, SwiftAxes

    figure = StyledFigure(figsize=(WIDTH / INCH, WIDTH / INCH))
    figure.within = styled
    figure.suptitle(title)
    return figure, figure.subplots(rows, columns, squeeze=False, **{"subplot_kw": {"axes_class": SwiftAxes}} | look)


def wrapped(title: str) -> str:
    """A title in as many lines as it needs at the figures' width."""
    return "\n".join(textwrap.wrap(" ".join(title.split()), TITLE_LETTERS, break_on_hyphens=False))


def line_key(**look: Any) -> Artist:
    """A line that stands in a legend alone."""
    from matplotlib.lines import Line2D

    return Line2D([], [], **look)


def patch_key(**look: Any) -> Artist:
    """A patch that stands in a legend alone."""
    from matplotlib.patches import Patch

    return Patch(**look)


def share(axes: Iterable[Axes]) -> None:
    """Let axes below each other share the lowest one's horizontal axis: the others keep its name, unseen."""
    for one in list(axes)[:-1]:
        one.tick_params(labelbottom=False)
        one.xaxis.label.set_visible(False)


def _room(axes: Axes) -> float:
    """What the numbers and the name of an axis need on the left [pt]."""
    ticks = axes.yaxis.get_major_formatter().format_ticks(list(axes.yaxis.get_major_locator()()))
    return max([LEFT, *(5.6 * len(text) + 24.0 for text in ticks)])


def arrange(
    figure: Figure,
    panels: Sequence[tuple[Axes, float]],
    entries: Mapping[str, Artist],
    right: float = 14.0,
    gap: float = BELOW,
    head: float = 0.0,
    gaps: Sequence[float] = (),
) -> None:
    """Place title, legend and axes below each other, the same margins in every figure.

    Fixed places cost a quarter of what Matplotlib's own layouts do.

    Args:
        figure: whose height is set.
        panels: axes from top to bottom, each with its height [pt].
        entries: of the legend, which stands between title and axes, over no data.
        right: margin on the right [pt].
        gap: room below all axes but the last [pt].
        head: room above the first [pt].
        gaps: room below each of them, instead of ``gap``; the last's does not count [pt].
    """
    below = [*(gaps or [gap] * len(panels))[: len(panels) - 1], BELOW]
    left = max(_room(axes) for axes, _ in panels)
    columns = legend_columns(list(entries), WIDTH - left)
    rows = -(-len(entries) // columns)
    title = wrapped(figure.get_suptitle())
    name, keys = 24.0 + 13.0 * title.count("\n"), 12.0 * rows + 8.0 + head
    height = name + keys + sum(panel for _, panel in panels) + sum(below)
    figure.set_size_inches(WIDTH / INCH, height / INCH)
    figure.suptitle(title, x=6.0 / WIDTH, y=1.0 - 6.0 / height, ha="left", va="top")
    if entries:
        legend(figure, entries, (left / WIDTH, 1.0 - name / height), columns)
    top, width = height - name - keys, WIDTH - left - right
    for (axes, panel), room in zip(panels, below, strict=True):
        axes.set_position((left / WIDTH, (top - panel) / height, width / WIDTH, panel / height))
        axes.yaxis.set_label_coords((14.0 - left) / width, 0.5)
        top -= panel + room


def legend(figure: Figure, entries: Mapping[str, Artist], place: tuple[float, float], columns: int) -> None:
    """The figure's legend, its upper left corner at a place [shares of the figure]."""
    handles, names = list(entries.values()), list(entries)
    figure.legend(handles, names, loc="upper left", bbox_to_anchor=place, ncols=columns, borderaxespad=0.0)


def mount_styles(mounts: int) -> list[tuple[str, float]]:
    """Colour and line width of each mount: later ones are thinner, so that lines which coincide all show."""
    widths = np.linspace(2.9, 0.6, max(mounts, 2))
    return list(zip(itertools.cycle(MOUNT_COLORS), (round(float(width), 2) for width in widths[:mounts]), strict=False))


def colors_of(labels: Iterable[str], passive: str | None) -> dict[str, str]:
    """Colour of each of several machines: the passive one always has the same, the others follow in order."""
    others = itertools.cycle((BLUE, GREEN, PURPLE, SKY, ORANGE))
    return {label: VERMILLION if label == passive else next(others) for label in labels}


def legend_columns(names: Sequence[str], room: float) -> int:
    """How many columns of a legend fit into ``room`` [pt]; it is filled column by column."""
    for columns in range(min(len(names), 4), 1, -1):
        widths = [max(map(len, part)) for part in np.array_split(np.array(names, object), columns)]
        if sum(5.3 * width + 32.0 for width in widths) <= room:
            return columns
    return 1


def shown(label: str, most: int = 36) -> str:
    """A label as a legend can show it: not endless, and no underscore first, which would hide it."""
    label = label if len(label) <= most else f"{label[: most - 1]}…"
    return f"\u2009{label}" if label.startswith("_") else label
