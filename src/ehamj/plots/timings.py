"""Timings as the bench draws them: panels of bars and of lines below each other, each with an axis of its own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from ehamj.plots import style
from ehamj.plots.axes import linear_axis
from ehamj.plots.charts import HEIGHT, Line, draw, entries_of, set_scales
from ehamj.plots.style import Axes, Figure

BAR: Final = 15.0
"""Height of a bar with the room around it [pt]."""
GAP: Final = 62.0
"""Room between two panels: the upper one's axis, the lower one's name [pt]."""


@dataclass(frozen=True)
class Bars:
    """Bars by name over an axis from zero, written out beside it: ``note`` says more of a bar than its number."""

    title: str
    axis: str
    values: Mapping[str, float]
    notes: Mapping[str, str]
    color: str = style.BLUE

    @property
    def height(self) -> float:
        """Of the panel [pt]."""
        return BAR * max(len(self.values), 1) + 6.0

    def draw(self, axes: Axes) -> None:
        """Draw them, the first on top: each name on its bar, its number at the right end of the panel."""
        places = range(len(self.values))
        axes.barh(list(places), list(self.values.values()), height=0.74, color=self.color, alpha=0.28)
        for place, (name, value) in zip(places, self.values.items(), strict=True):
            said = " ".join(part for part in (f"{value:.3g}", self.notes.get(name, "")) if part)
            for x, text, side in ((0.012, name, "left"), (0.995, said, "right")):
                axes.text(x, place, text, transform=axes.get_yaxis_transform(), ha=side, va="center", fontsize=8.8)
        axes.set(xlabel=self.axis, yticks=[], xlim=(0.0, 1.02 * max([*self.values.values(), 1e-12])))
        axes.set_ylim(len(self.values) - 0.4, -0.6)
        linear_axis(axes.xaxis, 6)
        axes.grid(visible=False, axis="y")


@dataclass(frozen=True)
class Lines:
    """Points with lines between them, both axes logarithmic."""

    title: str
    axis: str
    quantity: str
    lines: Sequence[Line]
    """With markers."""
    ticks: Sequence[float] = ()
    """Numbers on the horizontal axis, where they are not to be round ones."""

    @property
    def height(self) -> float:
        """Of the panel [pt]."""
        return 0.7 * HEIGHT

    def draw(self, axes: Axes) -> None:
        """Draw them."""
        from matplotlib.ticker import FixedLocator

        for line in self.lines:
            axes.plot(line.x, line.y, color=line.hue, linewidth=line.width, alpha=0.5)
        draw(axes, self.lines)
        axes.set(xlabel=self.axis, ylabel=self.quantity, xscale="log", yscale="log")
        set_scales(axes, "xy")
        if self.ticks:
            axes.xaxis.set_major_locator(FixedLocator(self.ticks))


Panel = Bars | Lines


@style.styled()
def timings_chart(title: str, panels: Sequence[Panel]) -> Figure:
    """Panels below each other; their lines stand in one legend."""
    figure, axes = style.new_figure(title, len(panels))
    for one, panel in zip(axes, panels, strict=True):
        panel.draw(one)
        one.set_title(panel.title, loc="left", fontsize=9.5, fontweight="bold")
    placed = [(one, panel.height) for one, panel in zip(axes, panels, strict=True)]
    style.arrange(figure, placed, entries_of(axes), gap=GAP, head=18.0)
    return figure
