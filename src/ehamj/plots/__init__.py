"""Figures from plain arrays; they know no simulation.

Every figure is a `matplotlib.figure.Figure` of a phone's proportions, so that its text stays readable across a narrow
screen and two of them fit beside each other on paper. Matplotlib is imported when the first figure is drawn, and
pyplot never. Colours are those of Okabe and Ito, which most colour-blind people tell apart.
"""

from ehamj.plots.bands import QUIETEST, Levels, attenuation, criterion, levels
from ehamj.plots.charts import Line, direction_chart, lines_chart
from ehamj.plots.files import inline, svg
from ehamj.plots.histories import (
    FAR_LIMIT,
    STRETCHES,
    Limit,
    Moment,
    Trace,
    envelope,
    finite,
    history,
    quieter,
    thinned,
)
from ehamj.plots.loci import Branch, View, locus_chart, view_of
from ehamj.plots.loops import bode, loop_figures, nichols, nyquist
from ehamj.plots.machine import Foot, Mark, machine_plan, machine_side
from ehamj.plots.maps import map_chart
from ehamj.plots.responses import Response, response, response_matrix
from ehamj.plots.spectrograms import spectrogram

from ehamj.plots.style import (  # isort: skip
    BAND_COLOR, BLUE, FLOOR_COLOR, GREEN, GREY, INK, LIMIT_COLOR, ORANGE, PURPLE, SKY, STYLE, VERMILLION, Figure,
    colors_of, mount_styles, shown,
)  # fmt: skip

__all__ = [
    "BAND_COLOR", "BLUE", "FAR_LIMIT", "FLOOR_COLOR", "GREEN", "GREY", "INK", "LIMIT_COLOR", "ORANGE", "PURPLE",
    "QUIETEST", "SKY", "STRETCHES", "STYLE", "VERMILLION", "Branch", "Figure", "Foot", "Levels", "Limit", "Line",
    "Mark", "Moment", "Response", "Trace", "View", "attenuation", "bode", "colors_of", "criterion", "direction_chart",
    "envelope", "finite", "history", "inline", "levels", "lines_chart", "locus_chart", "loop_figures", "machine_plan",
    "machine_side", "map_chart", "mount_styles", "nichols", "nyquist", "quieter", "response", "response_matrix",
    "shown", "spectrogram", "svg", "thinned", "view_of",
]  # fmt: skip
