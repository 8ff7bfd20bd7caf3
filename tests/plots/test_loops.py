"""Bode, Nyquist and Nichols plots of loop gains: what they draw, where, and with which disk."""

import numpy as np
import pytest

from ehamj import plots
from ehamj.plots import loops

HERTZ = np.geomspace(0.1, 1000.0, 600)
S = 2j * np.pi * HERTZ
LAG = plots.Response("lag", HERTZ, 8.0 / (1.0 + S / 60.0) ** 3, plots.BLUE)
SLOW = plots.Response("slow", HERTZ, 40.0 / S, plots.GREEN)


def drawn(figure: plots.Figure, number: int, color: str) -> np.ndarray:
    line = next(line for line in figure.axes[number].lines if line.get_color() == color and len(line.get_xdata()) > 9)
    return np.column_stack([np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)])


def test_bode_shows_decibels_and_degrees_over_hertz() -> None:
    figure = plots.bode("loop", [LAG, SLOW])
    assert [axes.get_ylabel() for axes in figure.axes] == ["loop gain [dB]", "phase [deg]"]
    assert figure.axes[1].get_xlabel() == "frequency [Hz]"
    magnitude, phase = drawn(figure, 0, plots.BLUE), drawn(figure, 1, plots.BLUE)
    np.testing.assert_allclose(magnitude[:, 0], HERTZ)
    np.testing.assert_allclose(magnitude[:, 1], 20 * np.log10(np.abs(LAG.response)))
    np.testing.assert_allclose(phase[:, 1], -3 * np.degrees(np.arctan(2 * np.pi * HERTZ / 60.0)), atol=1e-9)
    assert plots.svg(figure, "loop").count("lag") >= 1


def test_nyquist_keeps_what_is_near_the_point_and_bends_the_rest() -> None:
    figure = plots.nyquist("loop", [LAG, SLOW], 0.5)
    found = drawn(figure, 0, plots.BLUE)
    kept = np.isfinite(found).all(axis=1) & (np.hypot(*found.T) < 2.0)
    np.testing.assert_allclose(found[kept] @ [1, 1j], LAG.response[kept])
    assert np.nanmax(np.hypot(*found.T)) <= loops.REACH


@pytest.mark.parametrize("margin", [0.3, 0.5, 1.2])
def test_on_the_edge_of_the_disk_the_sensitivity_has_its_margin(margin: float) -> None:
    edge = loops._disk(margin)
    np.testing.assert_allclose(np.abs(1.0 / (1.0 + edge) - 0.5), 1.0 / margin)


def test_nichols_shows_decibels_over_degrees_about_the_critical_point() -> None:
    figure = plots.nichols("loop", [LAG], 0.5)
    axes, found = figure.axes[0], drawn(figure, 0, plots.BLUE)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("phase [deg]", "loop gain [dB]")
    np.testing.assert_allclose(found[:, 1], 20 * np.log10(np.abs(LAG.response)))
    low, high = axes.get_xlim()
    assert low <= -180.0 <= high
