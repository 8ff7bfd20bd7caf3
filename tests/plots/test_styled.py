"""A figure looks as the house draws it, whoever draws it."""

from io import BytesIO

import matplotlib
import numpy as np

from ehamj.plots import lines_chart
from ehamj.plots.charts import Line
from ehamj.plots.style import Figure, styled


def drawn(figure: Figure) -> bytes:
    with BytesIO() as file:
        figure.savefig(file, format="png", metadata={"Software": None}, bbox_inches="tight")
        return file.getvalue()


def test_a_figure_that_a_user_saves_has_the_house_style() -> None:
    def chart() -> Figure:
        return lines_chart(
            "A line", "time [s]", {"value [m]": [Line("one", np.arange(3.0), np.arange(3.0), "#000000")]}
        )

    with styled():
        own = drawn(chart())
    with matplotlib.rc_context({"font.size": 20.0, "grid.color": "red", "text.color": "red"}):
        theirs = drawn(chart())
    assert own == theirs
