"""What the page says of norms, points, relative motions and response spectra: the numbers of the files beside it."""

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from lxml import html as lxml_html
from oracles.levels import whole_run_rms

from ehamj import plots
from ehamj.criteria import iso2631, nist
from ehamj.criteria.curves import CANDIDATES, Norm
from ehamj.pages import Picture, render
from ehamj.report import report_page, write_report
from ehamj.report.shown import Shown
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

FLOOR = {"kind": "broadband", "level": "VC-C", "axes": ("x", "z"), "wave": {"speed": 200.0, "direction": 30.0}}
ASKED = {
    "points": {"nose": [0.33, 0.0, 1.06], "table": [0.5, -0.3, 0.7]},
    "relative": [{"name": "laser", "from": "nose", "to": "ground front-left"}],
    "criteria": {"response_spectrum": {"last": 63.0}},
}
BASE: dict[str, Any] = {"name": "line 3", "duration": 6.0, "plates": "tied", "ground": FLOOR, **ASKED}
ACTIVE = {**BASE, "control": {"kind": "feedforward"}}
PLACES = {"worst foot": "feet", "centre of gravity": "machine", "nose": "nose", "table": "table"}


@pytest.fixture(scope="module")
def results() -> dict[str, Result]:
    return {name: simulate(parse_scenario(table)) for name, table in (("feedforward", ACTIVE), ("passive", BASE))}


@pytest.fixture(scope="module")
def folder(results: dict[str, Result], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    results["feedforward"].write(folder)
    write_report(folder, results)
    return folder


@pytest.fixture(scope="module")
def whole(folder: Path) -> Any:
    return lxml_html.fromstring((folder / "report.html").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def pictures(results: dict[str, Result]) -> dict[str, Picture]:
    return {picture.name: picture for picture in report_page(results).pictures}


def table_of(where: Any, title: str) -> list[list[str]]:
    (found,) = where.xpath(f'//table[@aria-label="{title}"]')
    return [[" ".join(cell.text_content().split()) for cell in row.xpath("./th|./td")] for row in found.xpath(".//tr")]


def number(text: str) -> float:
    return float(text.replace("−", "-"))


def said(places: dict[str, Any], axes: str, norm: Norm) -> tuple[str, str, float]:
    """Class, band and margin (or minus excess) of the worst of some axes, straight from the summary."""
    coarse = ["", *norm.classes]

    def badness(axis: str) -> tuple[int, float]:
        verdict = places[axis]
        margin = verdict["margin_db"] if verdict["class"] else -verdict["excess_db"]
        return coarse.index(verdict["class"] or ""), np.inf if margin is None else margin

    axis = min(axes, key=badness)
    return places[axis]["class"] or f"over {norm.classes[0]}", places[axis]["deciding_band_hz"], badness(axis)[1]


def test_classes_at_every_place_are_the_summarys(results: dict[str, Result], whole: Any) -> None:
    _, *rows = table_of(whole, "Criteria at every place")
    norms = results["passive"].scenario.criteria.chosen()
    assert [row[0] for row in rows if len(row) == 1] == [norm.title for norm in norms.values()]
    assert len(rows) == 3 * (1 + 1 + 2 * len(PLACES))  # per norm: its title, the floor once, the places of two runs
    name, names = "", iter(norms)
    for row in rows:
        if len(row) == 1:
            name = next(names)
            continue
        label, _, place = row[0].partition(", ")
        who = PLACES[place] if place else "floor"
        found = results[label if place else "passive"].summary["criteria"][name]["places"][who]
        for cell, axes in zip(row[1:], ("z", "xy"), strict=True):
            met, band, margin = said(found, axes, norms[name])
            assert met in cell
            if "at rest" not in cell:
                assert cell.endswith(f"{band} Hz)")
                assert number(re.findall(r"([\d.]+) dB", cell)[0]) == pytest.approx(abs(margin), abs=0.051)


def test_attenuation_at_every_place_is_the_summarys(results: dict[str, Result], whole: Any) -> None:
    head, *rows = table_of(whole, "Vertical attenuation at every place [dB]")
    assert head[1:] == ["5 Hz", "10 Hz", "20 Hz", "50 Hz", "100 Hz"]
    label = ""
    for row in rows:
        if len(row) == 1:
            label = row[0]
            continue
        summary = results[label].summary
        tables = {"machine": summary["attenuation_db"], **summary["attenuation_at_db"]}
        for cell, band in zip(row[1:], ("5", "10", "20", "50", "100"), strict=True):
            expected = tables[PLACES[row[0]]]["z"][band]
            assert (cell == "–") == (expected is None)
            assert expected is None or number(cell) == pytest.approx(expected, abs=0.051)
    assert len(rows) == 2 * (1 + len(PLACES))


@pytest.mark.parametrize(("name", "norm"), [("nist-a", nist.NIST_A), ("iso-2631-2", iso2631.ISO_2631_2)])
@pytest.mark.parametrize(("view", "axes"), [("z", "z"), ("xy", "xy")])
def test_levels_lie_as_far_from_a_drawn_limit_as_the_norm_counts(
    results: dict[str, Result], pictures: dict[str, Picture], name: str, norm: Norm, view: str, axes: str
) -> None:
    figure = pictures[f"criterion-{name}-{view}"].figure
    lines = {line.get_color(): line for line in figure.axes[0].lines if line.get_label()[0] == "_"}
    strictest = norm.classes[-1]
    for label, color in Shown.of(results).colors.items():
        drawn = dict(zip(*(np.asarray(part) for part in lines[color].get_data()), strict=True))
        for band in CANDIDATES:
            limit = norm.limit(strictest, axes[0], band)
            if limit is None:
                continue
            tables = results[label].summary[f"third_octave_{limit.quantity}"]
            assert set(tables) == {"floor", *PLACES.values()}
            found = [tables[place][axis][band.name] for place in PLACES.values() for axis in axes]
            levels = [level for level in found if level is not None]  # the machine where it is worst, as it is judged
            if levels and max(levels) > 0:
                share = drawn[band.nominal] / (1e6 * limit.as_velocity(band))
                assert share == pytest.approx(max(levels) / limit.value, rel=1e-9)


@pytest.mark.parametrize(
    "name", ["criterion-z", "criterion-nist-a-z", "criterion-iso-2631-2-z", "criterion-iso-2631-2-xy"]
)
def test_the_strictest_curve_in_question_is_in_sight(pictures: dict[str, Picture], name: str) -> None:
    """The first that no machine meets or, of a norm of few classes, the strictest."""
    (axes,) = pictures[name].figure.axes
    low, high = axes.get_ylim()
    curves = [line for line in axes.lines if str(line.get_gid()).startswith("class-")]
    assert low < curves[-1].get_ydata().min() <= curves[-1].get_ydata().max() < high


def test_relative_motions_are_the_summarys_and_the_datasets(results: dict[str, Result], whole: Any) -> None:
    head, title, *rows = table_of(whole, "Relative motion [µm]")
    assert head[1:] == ["feedforward, peak", "feedforward, RMS", "passive, peak", "passive, RMS"]
    assert title == ["laser: nose against ground front-left"]
    assert [row[0] for row in rows] == ["x", "y", "z", "distance"]
    for column, (label, kind) in enumerate((label, kind) for label in results for kind in ("peak", "rms")):
        laser = results[label].summary["relative"]["laser"][kind]
        moved = results[label].dataset["relative_displacement"].sel(relative="laser").values
        about = np.column_stack([moved - moved[0], np.linalg.norm(moved - moved[0], axis=1)])
        stored = np.abs(about).max(axis=0) if kind == "peak" else np.sqrt((about**2).mean(axis=0))
        for row, axis, value in zip(rows, ("x", "y", "z", "total"), stored, strict=True):
            assert laser[axis] == pytest.approx(value, rel=1e-12)
            assert row[1 + column] == "< 0.001" or number(row[1 + column]) == pytest.approx(1e6 * value, rel=5.1e-3)


def test_response_spectra_are_the_summarys(results: dict[str, Result], pictures: dict[str, Picture]) -> None:
    colors = Shown.of(results).colors
    for kind, factor in (("velocity", 1e6), ("acceleration", 1e3)):
        lines = {
            (line.get_color(), line.get_linestyle()): line
            for line in pictures[f"spectrum-{kind}-z"].figure.axes[0].lines
        }
        for label, result in results.items():
            spectrum = result.summary["response_spectrum"]
            frequency, level = lines[colors[label], "-"].get_data()
            np.testing.assert_allclose(frequency, spectrum["frequency_hz"])
            np.testing.assert_allclose(level, factor * np.array(spectrum[kind]["machine"]["z"]))
        floor = results["passive"].summary["response_spectrum"][kind]["floor"]["z"]
        np.testing.assert_allclose(lines[plots.FLOOR_COLOR, "-"].get_ydata(), factor * np.array(floor))
        nose = results["feedforward"].summary["response_spectrum"][kind]["nose"]["z"]
        np.testing.assert_allclose(lines[plots.INK, "--"].get_ydata(), factor * np.array(nose))
    assert "spectrum-velocity-y" in pictures  # the machine rolls, though the floor rests along y


def test_the_page_says_the_numbers_of_the_stored_files(folder: Path, whole: Any) -> None:
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    with xr.open_dataset(folder / "result.nc", engine="h5netcdf") as data:
        part = data["point_velocity"].sel(point="nose", axis="z").values
    stored = summary["third_octave_velocity"]["nose"]["z"]
    for band, centre in (("25", 25.12), ("50", 50.12), ("80", 79.43)):
        assert 20 * np.log10(whole_run_rms(part, 1000.0, 0.6, centre) / stored[band]) == pytest.approx(0.0, abs=0.1)
    verdict = summary["criteria"]["vc"]["places"]["nose"]["z"]
    shown = {row[0]: row for row in table_of(whole, "Criteria at every place")[:10]}["feedforward, nose"][1]
    assert shown == f"{verdict['class']} ({verdict['margin_db']:.1f} dB, {verdict['deciding_band_hz']} Hz)"


def test_points_are_drawn_and_listed_with_their_source(results: dict[str, Result], whole: Any) -> None:
    head, *rows = table_of(whole, "Points")
    assert head == ["point", "x [m]", "y [m]", "z [m]", "source"]
    assert rows == [["nose", "0.33", "0", "1.06", "given"], ["table", "0.5", "−0.3", "0.7", "given"]]
    assert table_of(whole, "Relative motions")[1] == ["laser", "nose", "ground front-left"]
    drawn = parse_scenario({**BASE, "points": {"spindle-nose": [0.33, 0.0, 1.06]}, "relative": []})
    seen = lxml_html.fromstring(render(report_page({"one": replace(results["passive"], scenario=drawn)})))
    assert table_of(seen, "Points")[1][-1] == "assumed"


def test_a_page_without_requests_has_neither_section(results: dict[str, Result]) -> None:
    plain = {"points": {}, "relative": [], "criteria": {"norms": ["vc"]}}
    result = simulate(parse_scenario({**BASE, **plain, "duration": 1.0}))
    seen = lxml_html.fromstring(render(report_page({"one": result})))
    assert not seen.xpath('//*[@id="spectra" or @id="relative"]')
    assert not any("nist" in picture.name or "iso" in picture.name for picture in report_page({"one": result}).pictures)


def test_the_verdict_is_that_of_the_first_norm(results: dict[str, Result]) -> None:
    criteria = {"norms": ["nist-a"]}
    result = simulate(parse_scenario({**BASE, "criteria": criteria, "duration": 6.0}))
    seen = lxml_html.fromstring(render(report_page({"one": result})))
    assert seen.xpath('//*[@id="classes"]//h3')[0].text_content() == "Class met: NIST-A"
    assert "worse than NIST-A" in seen.xpath('//*[@id="verdict"]')[0].text_content()
