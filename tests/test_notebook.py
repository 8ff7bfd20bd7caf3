"""What a notebook shows of objects, by IPython's own formatter, and the report's figures as a user asks for them."""

import gc
import gzip
import os
import re
from functools import partial
from pathlib import Path
from urllib.request import urlopen
from xml.etree import ElementTree

import numpy as np
import pytest
from IPython.core.formatters import DisplayFormatter
from matplotlib.axes import Axes

import ehamj
from ehamj import Result
from ehamj.errors import InputError
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.replay.recording import check_whole
from ehamj.studies.outcome import Outcome


@pytest.fixture(scope="module")
def result() -> Result:
    """On a floor that moves vertically alone."""
    vertical = "ground.axes={'BW.RJOB..EHZ'='z'}"
    return ehamj.simulate(ehamj.load_scenario("recorded", ["duration=2", vertical, "name=a <b> & c"]))


def shown(thing: object, kind: str) -> str:
    """What a notebook is sent of it, of a kind that a browser shows."""
    data, _ = DisplayFormatter().format(thing)
    assert kind in data, f"of {type(thing).__name__} a notebook shows {', '.join(data)}"
    return str(data[kind])


def cells(html: str) -> dict[str, list[str]]:
    """Cells of each row by its first; the table must be well formed."""
    rows = [list(row.itertext()) for row in ElementTree.fromstring(html).iter("tr")]
    return {name: rest for name, *rest in rows}


def test_a_scenario_shows_what_it_states(result: Result) -> None:
    found = cells(shown(result.scenario, "text/html"))
    assert found["ground.scale"] == ["350.0"]
    assert found["name"] == ["a <b> & c"]
    assert "machine.mass" not in found  # which is the default
    varied = cells(shown(result.scenario.varied({"machine.mass": 4321.0}), "text/html"))
    assert "4321 kg" in varied["machine"][0]
    assert varied["machine.mass"] == ["4321.0"]
    assert "gravity" not in varied  # whose copy states all, and differs in little


def test_modes_show_their_frequencies(result: Result) -> None:
    found = modes(linear_model(result.scenario.plant))
    rows = cells(shown(found, "text/html"))
    for mode in found:
        assert float(rows[mode.name][0]) == pytest.approx(mode.frequency, rel=1e-3)


def test_an_outcome_shows_its_answers() -> None:
    outcome = Outcome("A <title>", "How?", ("First.", "a < b"), {}, {})
    said = shown(outcome, "text/html")
    assert "a &lt; b" in said
    assert "A &lt;title&gt;: How?" in said


def test_attenuation_is_that_of_the_summary(result: Result) -> None:
    axes = result.plot.attenuation("z")
    known = {float(band): level for band, level in result.summary.attenuation_db["z"].items() if level is not None}
    drawn = [np.asarray(line.get_ydata(), float) for line in axes.lines]
    assert any(np.array_equal(one[np.isfinite(one)], list(known.values())) for one in drawn)
    svg = shown(axes, "image/svg+xml")
    assert "Attenuation" in svg
    assert ElementTree.fromstring(svg).tag.endswith("svg")


@pytest.mark.parametrize(
    ("which", "asked"),
    [("criteria", "z"), ("criteria", "xy"), ("histories", "command"), ("transmissibility", "z"), ("spectrogram", "z")],
)
def test_every_figure_is_axes_of_that_quantity(which: str, asked: str, result: Result) -> None:
    more = {"norm": "nist-a"} if asked == "xy" else {}
    axes = getattr(result.plot, which)(asked, **more)
    assert isinstance(axes, Axes)
    assert re.search(r"\[.+\]", axes.get_ylabel())  # a unit
    assert len(shown(axes, "image/svg+xml")) > 1000


def test_results_stand_beside_each_other(result: Result) -> None:
    passive = ehamj.simulate(result.scenario.variant("passive"))
    legend = result.plot.beside(passive).histories().figure.legends[0]
    assert [text.get_text() for text in legend.get_texts()] == ["floor", "passive", "combined"]


@pytest.mark.parametrize(
    ("which", "asked", "said"),
    [
        ("attenuation", "w", "axis = 'w': must be one of z, x, y, rx, ry, rz"),
        ("criteria", "up", "axis = 'up': must be one of z, x, y"),
        ("histories", "speed", "quantity = 'speed': .*must be one of velocity, stroke"),
        ("spectrogram", "rx", "must be one of z, x, y"),
    ],
)
def test_what_cannot_be_drawn_is_refused(which: str, asked: str, said: str, result: Result) -> None:
    with pytest.raises(InputError, match=said):
        getattr(result.plot, which)(asked)


def test_a_notebook_is_given_the_whole_recording(
    result: Result, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """The widget keeps what it sends until a browser is there."""
    monkeypatch.setattr("ehamj.replay.shown._in_notebook", lambda: True)
    monkeypatch.setattr("gzip.compress", partial(gzip.compress, compresslevel=0))  # of 67 MB, for once
    widget = result.replay()
    ((_, (sent,)),) = widget._event_queue
    (tmp_path / "sent.rrd").write_bytes(sent)
    check_whole(tmp_path / "sent.rrd")
    with urlopen(widget._esm) as served:  # from here, not from Rerun's own site
        assert b"re_viewer_bg.wasm" in served.read()
    assert widget._esm.startswith("http://localhost:")


def test_without_screen_or_viewer_the_way_out_is_named(result: Result, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(InputError, match=r"no screen here; result\.save\(FOLDER\)"):
        result.replay()
    monkeypatch.setattr("ehamj.replay.shown._in_notebook", lambda: True)
    monkeypatch.setitem(__import__("sys").modules, "rerun_notebook", None)
    with pytest.raises(InputError, match=r"pip install 'ehamj\[notebook\]'"):
        result.replay()


def test_a_viewer_finds_its_recording_when_the_script_has_ended(
    result: Result, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """It stays where the viewer reads it; what was left the day before yesterday goes."""
    opened: list[Path] = []
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("ehamj.replay.shown.open_viewer", lambda path: opened.append(path) or "")
    old = tmp_path / "ehamj-replay-old"
    old.mkdir()
    os.utime(old, (0.0, 0.0))
    result.replay()
    gc.collect()
    check_whole(opened[0])
    assert not old.exists()
    with pytest.raises(InputError, match=r"'runs/1' is no result; ehamj\.load_result"):
        result.replay("runs/1")  # type: ignore[arg-type]
