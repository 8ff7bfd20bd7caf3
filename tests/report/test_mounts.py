"""The page and the files of machines on three, eight and thirty-two mounts of any name and direction."""

import warnings
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from lxml import html as lxml_html

import ehamj
from ehamj.pages import render
from ehamj.report import report_page
from ehamj.report.sections.attenuation import attenuation
from ehamj.report.sections.headline import headline
from ehamj.report.sections.histories import histories
from ehamj.report.sections.limits import limits
from ehamj.report.sections.machine import along_in_words, machine, mounts
from ehamj.report.sections.numbers import numbers
from ehamj.report.shown import Shown
from ehamj.result import Result, load_result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.variation import DerivedAnew
from ehamj.views.statics import static_loads

FLOOR = {"kind": "broadband", "level": "VC-C", "axes": ["x", "y", "z"], "wave": {"speed": 200.0, "direction": 30.0}}
THREE = {"nose": [0.9, 0.0], "tail-left": [-0.9, 0.6], "tail-right": [-0.9, -0.6]}
CORNERS = {"fl": [0.9, 0.6], "fr": [0.9, -0.6], "rl": [-0.9, 0.6], "rr": [-0.9, -0.6]}
LEVEL = {"x1": ([0.9, 0.5, 0.2], [-1, 0, 0]), "x2": ([0.9, -0.5, 0.2], [-1, 0, 0]),
         "y1": ([0.6, 0.6, 0.2], [0, -1, 0]), "y2": ([-0.6, 0.6, 0.2], [0, -1, 0])}  # fmt: skip
MANY = {f"r{i}c{j}": [-0.95 + 1.9 * i / 7, -0.65 + 1.3 * j / 3] for i in range(8) for j in range(4)}


def table(mounts: list[dict[str, Any]], **more: Any) -> dict[str, Any]:
    size = {"size": [2.2, 1.6, 1.9], "inertia": [2000.0, 2800.0, 2400.0]}
    return {"name": "hall", "duration": 2.0, "plates": "tied", "machine": size, "ground": FLOOR, "mount": mounts,
            "control": {"kind": "feedforward"}, **more}  # fmt: skip


def upright(places: dict[str, list[float]]) -> list[dict[str, Any]]:
    return [{"name": name, "position": at} for name, at in places.items()]


def mixed() -> list[dict[str, Any]]:
    """Four upright and four level ones, of which the last is passive."""
    level = [{"name": name, "position": at, "direction": along} for name, (at, along) in LEVEL.items()]
    return [*upright(CORNERS), *level[:3], {**level[3], "actuator": "soft"}]


SOFT = {"actuators": {"isolator": {}, "soft": {"preset": "elastic-mount"}}}


@pytest.fixture(scope="module")
def results() -> dict[str, Result]:
    """Of three, eight mixed and thirty-two mounts; from threads, as many runs are made."""
    scenarios = [table(upright(THREE)), table(mixed(), **SOFT), table(upright(MANY))]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DerivedAnew)  # these are three machines, and no variations of one
        found = ehamj.simulate_many([parse_scenario(one) for one in scenarios])
    return dict(zip(("three", "mixed", "many"), found, strict=True))


def page_of(result: Result, *sections: Any) -> Any:
    return lxml_html.fromstring(render(report_page({"run": result}, sections)))


def figures_of(result: Result, section: Any) -> dict[str, Any]:
    return {picture.name: picture.figure for picture in report_page({"run": result}, (section,)).pictures}


def rows_of(where: Any, title: str) -> list[list[str]]:
    (found,) = where.xpath(f'//table[@aria-label="{title}"]')
    return [[" ".join(cell.text_content().split()) for cell in row.xpath("./th|./td")] for row in found.xpath(".//tr")]


@pytest.mark.parametrize("which", ["three", "mixed", "many"])
def test_files_hold_as_many_mounts_as_there_are(which: str, results: dict[str, Result], tmp_path: Path) -> None:
    result = results[which]
    result.write(tmp_path)
    names = list(result.scenario.plant.mounts)
    with xr.open_dataset(tmp_path / "result.nc", engine="h5netcdf") as data:
        assert data["mount"].values.tolist() == names
        assert data["stroke"].shape == (2001, len(names))
        assert data["foot_velocity"].shape == (2001, len(names), 3)
        np.testing.assert_array_equal(data["stroke"].sel(mount=names[-1]), result.dataset["stroke"][:, -1])
    again = load_result(tmp_path)
    assert again.scenario == result.scenario
    assert again.summary == result.summary
    assert list(again.summary.saturation["command"]) == names
    lines = str(again).splitlines()
    assert len(lines) == 10 + any(line.startswith("worse:  ") for line in lines)
    assert any(line.startswith("attenuation:  least of x, y, z ") for line in lines) is (which == "mixed")


@pytest.mark.parametrize("which", ["three", "mixed", "many"])
def test_every_mount_has_a_row_with_what_it_carries(which: str, results: dict[str, Result]) -> None:
    result, seen = results[which], page_of(results[which], machine, mounts)
    head, *rows = rows_of(seen, "What the mounts do")
    assert [row[:2] for row in rows] == [[str(k), name] for k, name in enumerate(result.scenario.plant.mounts, 1)]
    carried = [0.0 if row[4] == "< 0.001" else float(row[4].replace("−", "-")) for row in rows]
    loads = static_loads(result.scenario)
    np.testing.assert_allclose(carried, 1e-3 * loads.along, rtol=5.1e-3, atol=1e-3)
    if which != "mixed":  # there the level ones' membranes carry some of it across
        assert sum(carried) == pytest.approx(1e-3 * loads.weight, rel=5.1e-3)
    three = "heave, roll, pitch (rank 3 of 6)"
    actuated = {"three": three, "many": f"{three}; 29 patterns of self-stress"}
    actuated["mixed"] = "heave, roll, pitch, surge, sway, yaw (rank 6 of 6); 1 pattern of self-stress"
    assert actuated[which] in " ".join(seen.xpath('//section[@id="machine"]//text()'))
    if which == "mixed":
        assert head[5:] == ["warp"]
        assert rows[7] == ["8", "y2", "along −y", "soft (passive)", rows[7][4], "–"]
        assert [row[5] for row in rows[:4]] == ["+1.00", "−1.00", "−1.00", "+1.00"]
    else:
        assert head[5:] == []


def test_of_six_directions_every_motions_attenuation_stands_first(results: dict[str, Result]) -> None:
    seen, summary = page_of(results["mixed"], headline, attenuation, numbers), results["mixed"].summary
    rows = rows_of(seen, "Attenuation [dB] in the third-octave bands at")
    motions = ("vertical, z, worst place", "along x, worst place", "along y, worst place", "roll, rx", "pitch, ry")
    assert [row[0] for row in rows[1:]] == [f"run, {motion}" for motion in (*motions, "yaw, rz")]
    told = [summary.attenuation_at_worst("x")[band] for band in ("20", "50", "100")]
    assert [float(cell.replace("−", "-")) for cell in rows[2][3:]] == pytest.approx(told, abs=0.051)
    yaw = summary.attenuation_db["rz"]["50"]
    assert yaw is not None
    assert float(rows[6][4].replace("−", "-")) == pytest.approx(yaw, abs=0.051)
    assert [item.split(" ", 1)[0].lower() for item in map(str.strip, seen.xpath('//*[@id="verdict"]/li/span/text()'))][
        :3
    ] == ["overall", "vertical", "horizontal"]
    assert {"Along x, per third-octave band", "Attenuation along y at every place [dB]"} <= set(
        seen.xpath("//table/@aria-label")
    )


def test_shares_at_limits_have_a_row_per_mount_that_reached_one(results: dict[str, Result]) -> None:
    reached = {name: dict(by) for name, by in results["many"].summary.saturation.items()}
    reached["command"]["r3c2"] = 0.25
    result = results["many"]
    changed = Result(result.scenario, result.dataset, result.summary.changed(saturation=reached))
    section = limits(Shown.of({"run": changed}))
    (found,) = (one for one in section.tables if one.title.startswith("Share of the time"))
    assert found.head[1:] == ["command", "spool", "spool drive", "cavitation"]
    assert found.rows == [["r3c2", "25.0", "0", "0", "0"], ["the other 31", "0", "0", "0", "0"]]


def test_histories_of_many_draw_the_loudest_and_a_band_between_the_others(results: dict[str, Result]) -> None:
    result = results["many"]
    figures = figures_of(result, histories)
    below = figures["history-stroke"].axes[1]
    stroke = 1e6 * (result.dataset.stroke.values - result.dataset.stroke.values[0])
    loudest = np.argsort(-np.abs(stroke - stroke.mean(axis=0)).max(axis=0))[:4]
    assert len(below.lines) == 4
    low, high = below.get_xlim()
    inside = (result.dataset.time.values >= low) & (result.dataset.time.values <= high)
    others = np.delete(stroke, loudest, axis=1)[inside]
    band = np.concatenate([path.vertices[:, 1] for path in below.collections[0].get_paths()])
    np.testing.assert_allclose([band.min(), band.max()], [others.min(), others.max()], atol=0.02 * np.ptp(others))
    names = [text.get_text() for text in figures["history-stroke"].legends[0].get_texts()]
    assert "the other 28, lowest to highest" in names


@pytest.mark.parametrize("which", ["three", "mixed", "many"])
def test_names_in_the_drawing_do_not_lie_on_each_other(which: str, results: dict[str, Result]) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = figures_of(results[which], machine)["machine-plan"]
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    mounts = results[which].scenario.plant.mounts
    wanted = {*mounts, *map(str, range(1, len(mounts) + 1))}
    texts = [text for text in figure.axes[0].texts if text.get_text() in wanted]
    assert len(texts) == len(mounts)
    boxes = [text.get_window_extent(canvas.get_renderer()).shrunk(0.95, 0.8) for text in texts]
    assert not [(one, other) for one, other in combinations(boxes, 2) if one.overlaps(other)]


def test_directions_in_words() -> None:
    given = ((0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.6, 0.0, -0.8))
    assert [along_in_words(one) for one in given] == ["up", "down", "along −x", "along y", "0.6, 0, −0.8"]


def test_a_machine_with_renamed_mounts_runs_as_the_default() -> None:
    """Names are names: the channels are the same to the last bit."""
    names = dict(zip(CORNERS, ("front-left", "front-right", "rear-left", "rear-right"), strict=True))
    runs = [
        simulate(parse_scenario(table(upright({called: CORNERS[name] for name, called in by.items()}), duration=0.1)))
        for by in (names, {name: name for name in CORNERS})
    ]
    for channel in ("stroke", "cg_velocity", "valve_command", "chamber_pressure"):
        np.testing.assert_array_equal(*(run.dataset[channel].values for run in runs))
