"""Figures from arrays: no peak is lost, every axis says its unit, nothing lies over anything, SVG fits into a page."""

import ast
import re
import warnings
from pathlib import Path
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ehamj import plots
from ehamj.plots import Foot, Levels, Limit, Response, Trace

BANDS = 10.0 ** np.arange(0.0, 2.55, 0.1)
TIME = np.arange(60_001) / 1000.0
FEET = [Foot("front-left", 0.9, 0.6, "a"), Foot("front-right", 0.9, -0.6, "a")]
FEET += [Foot("rear-left", -0.9, 0.6, "b"), Foot("rear-right", -0.9, -0.6, "b")]
SIZE, CG = (2.2, 1.6, 1.9), (0.05, -0.02, 0.75)
NASTY = ("_under", "$x$ & <b>", "x" * 80, "Maschine 加工")


def levels(label: str, scale: float, color: str = plots.BLUE) -> Levels:
    return Levels(label, BANDS, scale * (2.0 + np.sin(BANDS)), color)


def noise(seed: int, n: int = TIME.size) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=n).cumsum()


def figures() -> dict[str, Figure]:
    """One of each kind, with difficult content."""
    gap = levels("active", 20.0)
    gap.values[5:9] = np.nan
    curves = [levels("floor", 20.0, plots.FLOOR_COLOR), gap, levels("passive", 19.0, plots.VERMILLION)]
    classes = {"VC-A": (BANDS[6:20], np.full(14, 50.0)), "operating theatre": (BANDS[6:20], np.full(14, 100.0))}
    mounts = [Trace(f"mount {k}", TIME, noise(k), color) for k, (color, _) in enumerate(plots.mount_styles(4))]
    band = Trace("all mounts", TIME, np.column_stack([trace.values for trace in mounts]), plots.BLUE)
    limits = [Limit("fully open, ±2 V", (2.0, -2.0)), Limit("stop", (1e6,))]
    return {
        "attenuation": plots.attenuation("Attenuation", curves[1:]),
        "criterion": plots.criterion("Classes", curves, classes, 40.0),
        "history": plots.history("History", "command [V]", [band], mounts, limits, (3.0, 4.0)),
        "short": plots.history("Short", "command [V]", [band], mounts, limits),
        "plan": plots.machine_plan(SIZE, CG, FEET, [("wave\n200 m/s", 30.0)]),
        "side": plots.machine_side(SIZE, CG, FEET),
        "nasty": plots.attenuation("Nasty", [levels(label, 1.0, plots.GREEN) for label in NASTY]),
    }


@pytest.fixture(scope="module")
def drawn() -> dict[str, Figure]:
    return figures()


@pytest.fixture(scope="module")
def written(drawn: dict[str, Figure]) -> dict[str, str]:
    return {name: plots.svg(figure, name) for name, figure in drawn.items()}


NAMES = ("attenuation", "criterion", "history", "short", "plan", "side", "nasty")


# --- thinning ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n", [1, 2, 499, 500, 501, 999, 60_001])
def test_no_peak_is_lost(n: int) -> None:
    time, values = TIME[:n], noise(n, n)
    middle, low, high = plots.envelope(time, values)
    assert len(middle) == len(low) == len(high) <= 500
    assert (low.min(), high.max()) == (values.min(), values.max())
    assert (np.diff(middle) > 0).all()
    nearest = np.abs(middle[:, None] - time[[np.argmin(values), np.argmax(values)]]).argmin(axis=0)
    assert low[max(nearest[0] - 1, 0) : nearest[0] + 2].min() == values.min()
    assert high[max(nearest[1] - 1, 0) : nearest[1] + 2].max() == values.max()


def test_envelope_of_several_lines_holds_all_of_them() -> None:
    values = np.column_stack([noise(1), noise(2) + 30.0, noise(3) - 30.0])
    _, low, high = plots.envelope(TIME, values, most=60)
    # 60 001 samples in stretches of 1001: stretch k holds from sample 1001 k on.
    parts = [values[k : k + 1001] for k in range(0, 60_001, 1001)]
    np.testing.assert_array_equal(low, [part.min() for part in parts])
    np.testing.assert_array_equal(high, [part.max() for part in parts])


def test_envelope_leaves_out_what_is_no_number() -> None:
    values = noise(4)
    values[100:130] = np.nan
    values[20_000:50_000] = np.nan
    _, low, high = plots.envelope(TIME, values)
    assert (np.nanmin(low), np.nanmax(high)) == (np.nanmin(values), np.nanmax(values))
    assert np.isnan(low).any()


def test_a_thinned_line_keeps_its_peaks() -> None:
    values = noise(5)
    time, kept = plots.thinned(TIME, values)
    assert len(time) == len(kept) <= 3002
    assert (kept.min(), kept.max()) == (values.min(), values.max())
    assert (np.diff(time) > 0).all()
    same = plots.thinned(TIME[:900], values[:900])
    np.testing.assert_array_equal(same, (TIME[:900], values[:900]))


# --- what is drawn -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_every_axis_says_what_it_is_and_its_unit(drawn: dict[str, Figure], name: str) -> None:
    assert drawn[name].axes
    for axes in drawn[name].axes:
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert re.search(r"\w.* \[[^\]]+\]", label), f"{name}: {label!r}"


@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_cut_off_and_the_legend_covers_no_data(drawn: dict[str, Figure], name: str) -> None:
    figure = drawn[name]
    with matplotlib.rc_context(plots.STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing")
        renderer = FigureCanvasAgg(figure).get_renderer()
        figure.draw(renderer)
        (legend,) = figure.legends
        page, box = figure.bbox, legend.get_window_extent(renderer)
        assert box.x0 >= page.x0 or name == "nasty"
        assert box.x1 <= page.x1 + 1.0 or name == "nasty"
        title = figure._suptitle.get_window_extent(renderer)
        assert title.y1 <= page.y1
        assert box.y1 <= title.y0 + 1.0
        for axes in figure.axes:
            assert not axes.get_window_extent(renderer).overlaps(box)
            tight = axes.get_tightbbox(renderer)
            assert page.x0 - 0.5 <= tight.x0
            assert tight.x1 <= page.x1 + 0.5
            assert page.y0 - 0.5 <= tight.y0
        for above, below in zip(figure.axes, figure.axes[1:], strict=False):
            assert above.get_tightbbox(renderer).y0 >= below.get_tightbbox(renderer).y1


def test_attenuation_shows_its_values_with_gaps_and_up_is_quieter(drawn: dict[str, Figure]) -> None:
    (axes,) = drawn["attenuation"].axes
    lines = {line.get_color(): line for line in axes.lines}
    shown = np.asarray(lines[plots.BLUE].get_ydata(), float)
    assert np.isnan(shown[5:9]).all()
    np.testing.assert_array_equal(shown[9:], 20.0 * (2.0 + np.sin(BANDS[9:])))
    assert axes.get_ylim()[0] < 0.0 < axes.get_ylim()[1]
    assert axes.get_ylim()[1] >= np.nanmax(shown)
    assert "up = quieter" in axes.get_ylabel()
    assert lines[plots.BLUE].get_zorder() > lines[plots.VERMILLION].get_zorder()
    assert lines[plots.BLUE].get_linewidth() < lines[plots.VERMILLION].get_linewidth()


def test_classes_are_drawn_at_their_limits_and_named_beside_the_axes(drawn: dict[str, Figure]) -> None:
    (axes,) = drawn["criterion"].axes
    assert axes.get_xscale() == axes.get_yscale() == "log"
    (line,) = (line for line in axes.lines if line.get_gid() == "class-VC-A")
    np.testing.assert_array_equal(line.get_xydata(), np.column_stack([BANDS[6:20], np.full(14, 50.0)]))
    named = {text.get_text(): text for text in axes.texts}
    assert named["VC-A"].xy == (axes.get_xlim()[1], 50.0)
    assert "floor not known above 40 Hz" in [text.get_text() for text in drawn["criterion"].legends[0].get_texts()]


def test_a_level_of_nothing_is_not_drawn_on_a_logarithmic_axis() -> None:
    figure = plots.criterion("t", [Levels("a", BANDS, np.where(BANDS > 10.0, 1.0, 0.0), plots.BLUE)], {})
    shown = np.asarray(figure.axes[0].lines[0].get_ydata(), float)
    np.testing.assert_array_equal(np.isnan(shown), BANDS <= 10.0)


def test_near_limits_are_drawn_and_far_ones_named(drawn: dict[str, Figure]) -> None:
    above, below = drawn["history"].axes
    flat = [line.get_ydata()[0] for line in above.lines if line.get_color() == plots.LIMIT_COLOR]
    assert flat == [2.0, -2.0]
    names = [text.get_text() for text in drawn["history"].legends[0].get_texts()]
    assert "fully open, ±2 V" in names
    assert "stop: far outside" in names
    assert below.get_xlim() == (3.0, 4.0)
    for k, line in enumerate(below.lines):
        x, y = line.get_data()
        inside = (x >= 3.0) & (x <= 4.0)
        np.testing.assert_array_equal(np.asarray(y)[inside], noise(k)[3000:4001])


def test_a_short_run_has_one_part_with_every_line(drawn: dict[str, Figure]) -> None:
    (axes,) = drawn["short"].axes
    names = [text.get_text() for text in drawn["short"].legends[0].get_texts()]
    assert names[:4] == ["mount 0", "mount 1", "mount 2", "mount 3"]
    assert axes.lines[0].get_ydata().max() == noise(0).max()


def test_what_is_too_small_beside_others_is_drawn_again_at_its_own_scale() -> None:
    """A tenth, and a hundredth of that: each gets a panel that it fills."""
    loud, soft, softest = (Trace(str(size), TIME, size * np.sin(9.0 * TIME), plots.BLUE) for size in (10.0, 1.0, 0.01))
    closer = plots.quieter([loud, soft, softest])
    assert [[trace.label for trace in group] for group in closer] == [["1.0", "0.01"], ["0.01"]]
    figure = plots.history("Quiet", "velocity [µm/s]", [loud], [loud, soft, softest], (), (3.0, 4.0), closer)
    reach = [max(abs(limit) for limit in axes.get_ylim()) for axes in figure.axes]
    assert reach == pytest.approx([10.0, 10.0, 1.0, 0.01], rel=0.3)
    assert plots.quieter([loud, Trace("half", TIME, 0.5 * loud.values, plots.BLUE)]) == []


def test_a_run_that_blew_up_can_be_drawn() -> None:
    values = np.r_[np.zeros(50), 1.0, -3.0, 1e200, np.inf, np.nan]
    trace = Trace("machine", TIME[: values.size], values, plots.BLUE)
    for window in (None, (0.02, 0.05)):
        figure = plots.history("Failed", "velocity [µm/s]", [trace], [trace], [Limit("range", (5.0,))], window)
        assert max(abs(limit) for axes in figure.axes for limit in axes.get_ylim()) < 10.0
        assert "<svg" in plots.svg(figure, "failed")


@pytest.mark.parametrize("size", [SIZE, (8.0, 2.0, 2.5), (1.0, 1.0, 4.0), (1.2, 3.0, 0.5)])
def test_the_machine_is_drawn_to_scale(size: tuple[float, float, float]) -> None:
    feet = [
        Foot(foot.name, np.sign(foot.x) * 0.4 * size[0], np.sign(foot.y) * 0.4 * size[1], foot.kind) for foot in FEET
    ]
    scales = []
    for figure in (plots.machine_plan(size, (0.0, 0.0, 0.3), feet), plots.machine_side(size, (0.0, 0.0, 0.3), feet)):
        (axes,) = figure.axes
        box = axes.get_position()
        width, height = figure.get_size_inches() * 72.0
        scales += [box.width * width / np.ptp(axes.get_xlim()), box.height * height / np.ptp(axes.get_ylim())]
        assert height < 500.0
        outline = axes.patches[0].get_bbox()
        assert outline.x0 > axes.get_xlim()[0]
        assert outline.y1 < axes.get_ylim()[1]
    np.testing.assert_allclose(scales, scales[0], rtol=1e-9)


def test_mounts_stand_where_they_are(drawn: dict[str, Figure]) -> None:
    (axes,) = drawn["plan"].axes
    boxes = [patch.get_bbox() for patch in axes.patches[1:5]]
    centres = [((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2) for box in boxes]
    np.testing.assert_allclose(centres, [(foot.x, foot.y) for foot in FEET])
    texts = {text.get_text() for text in axes.texts}
    assert texts >= {foot.name for foot in FEET} | {"2.2", "1.8", "1.2", "x", "y", "wave\n200 m/s"}
    assert {"1.9", "0.75", "z"} <= {text.get_text() for text in drawn["side"].axes[0].texts}


# --- SVG -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_svg_is_whole_and_keeps_its_ids_to_itself(written: dict[str, str], name: str) -> None:
    text = written[name]
    root = ElementTree.fromstring(text)
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    ids = re.findall(r'\bid="([^"]*)"', text)
    assert len(ids) == len(set(ids))
    assert all(found.startswith(f"{name}-") and " " not in found for found in ids)
    referred = re.findall(r'href="#([^"]*)"|url\(#([^)]*)\)', text)
    assert {a or b for a, b in referred} <= set(ids)
    assert set(re.findall(r"https?://[^\"]*", plots.inline(text))) == {"http://www.w3.org/2000/svg"}
    assert plots.inline(text).startswith("<svg")
    assert len(text) < 250_000


def test_text_stays_text_and_names_are_literal(written: dict[str, str]) -> None:
    root = ElementTree.fromstring(written["nasty"])
    texts = {"".join(node.itertext()).strip() for node in root.iter("{http://www.w3.org/2000/svg}text")}
    assert {"_under", "$x$ & <b>", "x" * 35 + "…", "Maschine 加工", "third-octave band [Hz]"} <= texts


def test_the_same_arrays_give_the_same_bytes(written: dict[str, str]) -> None:
    again = figures()
    assert plots.svg(again["criterion"], "criterion") == written["criterion"]
    assert plots.svg(again["plan"], "plan") == written["plan"]


def test_matplotlib_is_imported_late_and_pyplot_never() -> None:
    needing = Path(plots.__file__).parent / "axis.py"  # its classes are Matplotlib's, so who uses them imports it late
    for path in {*Path(plots.__file__).parent.glob("*.py")} - {needing}:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        imports = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]
        assert not any("pyplot" in ast.unparse(node) for node in imports), path
        early = [ast.unparse(node) for node in tree.body if node in imports]
        assert not any("matplotlib" in words or "ehamj.plots.axis " in words for words in early), path


def test_drawing_leaves_the_settings_of_others_alone() -> None:
    before = dict(matplotlib.rcParams)
    plots.svg(plots.machine_side(SIZE, CG, FEET), "side")
    assert dict(matplotlib.rcParams) == before


# --- responses -----------------------------------------------------------------------------------------------------


def responses() -> list[Response]:
    f = np.geomspace(1.0, 300.0, 50)
    ones = np.ones(50)
    return [
        Response("passive, linear", f, 1.0 / (1.0 + 0.01j * f), plots.VERMILLION),
        Response("passive, measured", f, 0.5 / (1.0 + 0.01j * f), plots.VERMILLION, 0.1 * ones, 0.9 * ones, 0.7 * ones),
    ]


def test_a_response_shows_magnitude_phase_band_and_coherence() -> None:
    linear, measured = responses()
    figure = plots.response("Floor to machine", responses(), "m/m")
    above, middle, below = figure.axes
    assert [axes.get_ylabel() for axes in figure.axes] == ["magnitude [dB re 1 m/m]", "phase [°]", "coherence [-]"]
    assert {axes.get_xlabel() for axes in figure.axes} == {"frequency [Hz]"}
    np.testing.assert_allclose(above.lines[0].get_ydata(), 20 * np.log10(np.abs(linear.response)))
    np.testing.assert_allclose(middle.lines[1].get_ydata(), np.degrees(np.angle(measured.response)))
    band = above.collections[0].get_paths()[0].vertices
    assert band[:, 1].max() == pytest.approx(20 * np.log10(np.abs(measured.response).max() + 0.1))
    assert [line.get_ydata()[0] for line in below.lines] == [0.9, 0.7]
    (legend,) = figure.legends
    names = [text.get_text() for text in legend.get_texts()]
    assert names[:2] == ["passive, linear", "passive, measured"]
    assert "95 % confidence" in names
    assert len(plots.response("Linear", responses()[:1], "m/m").axes) == 2


def test_a_matrix_of_responses_leaves_zeros_empty() -> None:
    curves = {("x", "x"): responses(), ("z", "z"): responses()}
    figure = plots.response_matrix("All", ("x", "z"), ("x", "z"), curves, "m/m")
    drawn = [len(axes.lines) for axes in figure.axes]
    assert drawn == [2, 0, 0, 2]
    assert [axes.texts[0].get_text() for axes in figure.axes if axes.texts] == ["0", "0"]
    assert len(figure.legends) == 1
    assert "[dB re 1 m/m]" in figure.get_supylabel()


@pytest.mark.parametrize(("level", "lowest"), [(20.0, "e"), (2.0, "e"), (0.3, "f")])
def test_classes_are_drawn_down_to_the_first_that_is_missed(level: float, lowest: str) -> None:
    """Twelve decades of classes that nobody meets would press what happens into a corner."""
    frequency = np.array([8.0, 16.0, 31.5])
    classes = {name: (frequency, np.full(3, 200.0 / 4.0**k)) for k, name in enumerate("abcdefghi")}
    curves = [plots.Levels("floor", frequency, np.full(3, level), plots.FLOOR_COLOR)]
    (axes,) = plots.criterion("classes", curves, classes).axes
    drawn = [line.get_gid().removeprefix("class-") for line in axes.lines if str(line.get_gid()).startswith("class-")]
    assert drawn[-1] == lowest
