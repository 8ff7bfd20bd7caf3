"""Figures of many designs: axes with units, what a user named anyhow, few points for a browser, nothing outside."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure

from ehamj.plots import svg
from ehamj.plots.clouds import Cloud, Pair, pairs_chart, scatter_matrix
from ehamj.plots.effects import Effects, effects_chart
from ehamj.plots.histograms import Spread, spreads_chart

NASTY = ("_under", "$x$ & <b>", "x" * 90, "Maschine 加工")
ROWS = 4000


def figures() -> dict[str, Figure]:
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, ROWS))
    a[:50] = np.nan
    clouds = [Cloud("designs", np.arange(10, ROWS)), Cloud("_best $1$", np.arange(10), 2)]
    columns = {
        "area [10⁻³ m²]": a,
        "gain [dB]": b,
        "a name that goes on and on and on [m³/s/mA]": a * b,
        "still [-]": 0 * b,
    }
    half = np.array([0.5, np.nan, -0.1, 0.0])
    return {
        "effects": effects_chart("Shares", "index [-]", NASTY, [Effects("first", half, half - 0.1, half + 0.1)], 0.0),
        "tornado": effects_chart(
            "Ends", "ω [rad/s]", NASTY, [Effects("low", half), Effects("high", -half)], 0.2, "own"
        ),
        "pairs": pairs_chart("Front", [Pair(("a [m]", a), ("b [m]", b), {60: "60", 61: "<61>"}, [60, 61])] * 2, clouds),
        "matrix": scatter_matrix("All", columns, clouds),
        "spread": spreads_chart(
            "Spread", [Spread("a [m]", a, 0.0, 5.0, 1.0, "yield 5 %"), Spread("c [m]", np.ones(9))], "machines"
        ),
    }


@pytest.fixture(scope="module")
def drawn() -> dict[str, Figure]:
    return figures()


KINDS = ("effects", "tornado", "pairs", "matrix", "spread")


@pytest.mark.parametrize("kind", KINDS)
def test_every_axis_that_is_named_has_a_unit(drawn: dict[str, Figure], kind: str) -> None:
    labels = [label for axes in drawn[kind].axes for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
    assert labels
    for label in labels:
        assert re.search(r"\[[^\]]+\]$", label), label


@pytest.mark.parametrize("kind", KINDS)
def test_it_is_a_small_svg(drawn: dict[str, Figure], kind: str) -> None:
    text = svg(drawn[kind], kind)
    ElementTree.fromstring(text)
    assert len(text) < 1e6


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_that_is_drawn_lies_outside(drawn: dict[str, Figure], kind: str) -> None:
    figure = drawn[kind]
    figure.canvas.draw()
    box = figure.bbox
    for axes in figure.axes:
        for text in (axes.xaxis.label, axes.yaxis.label):
            if text.get_text() and text.get_visible():
                own = text.get_window_extent()
                assert own.x0 >= box.x0 - 1, text.get_text()
                assert own.y0 >= box.y0 - 1, text.get_text()


def test_a_cloud_is_thinned_evenly_and_keeps_its_ends() -> None:
    rows = Cloud("", np.arange(100, 1100)).drawn(11)
    np.testing.assert_array_equal(rows, np.linspace(100, 1099, 11).round())
    assert Cloud("", [3, 5]).drawn(11).tolist() == [3, 5]


def test_correlations_of_a_matrix_are_spearmans() -> None:
    x = np.arange(50.0)
    figure = scatter_matrix("m", {"x [m]": x, "y [m]": np.exp(-x)}, [Cloud("designs", np.arange(50))])
    assert [text.get_text() for axes in figure.axes for text in axes.texts] == ["−1.00"]
