"""The spectrogram: one scale for all panels, a picture of few bytes, numbers on both axes."""

import re

import numpy as np
import pytest

from ehamj import plots
from ehamj.plots.spectrograms import scale_of

TIME = np.arange(1.0, 21.0, 0.25)
BANDS = ["8", "10", "12.5", "16", "20", "25"]


def panels() -> dict[str, np.ndarray]:
    loud = np.full((6, TIME.size), 20.0)
    loud[3, 10:20] = 130.0
    loud[:, :4] = np.nan
    return {"floor": loud, "machine": 0.01 * loud}


@pytest.mark.parametrize(
    ("values", "scale"),
    [
        ([1.0, 130.0], (1.0, 200.0)),
        ([0.3, 4.9, np.nan], (0.2, 5.0)),
        ([50.0, 50.0], (5.0, 50.0)),
        ([1e-9, 1000.0], (0.1, 1000.0)),  # 80 dB are enough
        ([0.0, 0.0], (1e-4, 1e-3)),
    ],
)
def test_the_scale_spans_what_is_there(values: list[float], scale: tuple[float, float]) -> None:
    assert scale_of([np.array(values)], 1e-3) == pytest.approx(scale)


def test_all_panels_share_scale_time_and_bands() -> None:
    figure = plots.spectrogram("levels", TIME, BANDS, panels(), "velocity [µm/s]")
    *both, bar = figure.axes
    limits = {(image.norm.vmin, image.norm.vmax) for axes in both for image in axes.images}
    assert limits == {(0.2, 200.0)}
    assert bar.get_ylabel() == "velocity [µm/s]"
    assert [axes.get_title("left") for axes in both] == ["floor", "machine"]
    for axes in both:
        assert axes.get_xlim() == (0.75, 20.75)
        assert [label.get_text() for label in axes.get_yticklabels()] == ["10", "20"]


def test_a_level_stands_at_its_time_and_band() -> None:
    figure = plots.spectrogram("levels", TIME, BANDS, panels(), "velocity [µm/s]")
    (image,) = figure.axes[0].images
    left, right, bottom, top = image.get_extent()
    shown = image.get_array()
    row, column = np.unravel_index(np.argmax(shown), shown.shape)
    # The first loud column ends at TIME[10], where it was given.
    assert left + (column + 1) * (right - left) / shown.shape[1] == pytest.approx(TIME[10])
    assert bottom + row + 0.5 == 3.0
    assert top == 5.5


def test_the_file_is_small_and_the_same_every_time() -> None:
    texts = [plots.svg(plots.spectrogram("levels", TIME, BANDS, panels(), "velocity [µm/s]"), "levels") for _ in "ab"]
    assert texts[0] == texts[1]
    assert len(texts[0]) < 60_000
    assert re.search(r'<image [^>]*xlink:href="data:image/png;base64,', texts[0])


def test_a_moment_is_marked_in_every_panel() -> None:
    struck = plots.Moment("fault: front-left", 5.0)
    figure = plots.spectrogram("levels", TIME, BANDS, panels(), "velocity [µm/s]", moments=[struck])
    for axes in figure.axes[:2]:
        assert {float(line.get_xdata()[0]) for line in axes.lines} == {5.0}
        assert axes.get_xlim() == (0.75, 20.75)
    assert "fault: front-left" in [text.get_text() for legend in figure.legends for text in legend.get_texts()]


def test_a_title_that_is_too_long_goes_on_in_the_next_line() -> None:
    title = "Vertical attenuation, a very long name of a scenario, passive, fault at front-left"
    figure = plots.attenuation(title, [])
    shown = figure.get_suptitle()
    assert " ".join(shown.split()) == title
    figure.canvas.draw()
    box = figure._suptitle.get_window_extent()
    assert 0.0 <= box.x0 < box.x1 <= figure.bbox.width
    assert plots.attenuation("short", []).get_figheight() < figure.get_figheight()
