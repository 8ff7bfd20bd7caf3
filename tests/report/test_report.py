"""The page: its numbers are those of the files beside it, it stands alone, and it says what did not work."""

import html
import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from lxml import html as lxml_html
from scipy import signal

from ehamj import plots
from ehamj.control import Controller
from ehamj.criteria.vc import CLASSES
from ehamj.designs.footprint import rocking_modes, slowest_rocking
from ehamj.evaluation import FREQUENCIES
from ehamj.ground import Start
from ehamj.judge.brief import PROCESSING, brief
from ehamj.judge.worse import CAUSES
from ehamj.linear.loop import Loop
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.linear.response import rigid_floor
from ehamj.pages import Picture, render
from ehamj.pages.words import number
from ehamj.plant.mounts import MOUNTS
from ehamj.report import report_page, write_report
from ehamj.report.sections import SECTIONS
from ehamj.report.sections.headline import headline, warnings
from ehamj.report.sections.histories import characteristic_part, histories
from ehamj.report.sections.inputs import inputs
from ehamj.report.sections.limits import limits
from ehamj.report.sections.loops import loops
from ehamj.report.sections.modes import modes as modes_section
from ehamj.report.shown import Shown
from ehamj.result import Result
from ehamj.run.failures import Incomplete
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario, parse_scenario

FLOOR = {"kind": "broadband", "level": "VC-C", "axes": ("x", "z"), "wave": {"speed": 200.0, "direction": 30.0}}
BASE: dict[str, Any] = {"name": "line 3", "description": "a mill", "duration": 4.0, "plates": "tied", "ground": FLOOR}
ACTIVE = {**BASE, "control": {"kind": "feedforward"}}


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
def pictures(results: dict[str, Result]) -> list[Picture]:
    return report_page(results).pictures


@pytest.fixture(scope="module")
def whole(folder: Path) -> Any:
    return lxml_html.fromstring((folder / "report.html").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def at_rest() -> Result:
    command = {"kind": "sine", "mounts": ("rear-left",), "amplitude": 0.5, "frequency": 13.0}
    control = {"kind": "open-loop", "signals": (command,)}
    return simulate(parse_scenario({**BASE, "duration": 2.0, "ground": {"kind": "rest"}, "control": control}))


@pytest.fixture(scope="module")
def failed() -> Result:
    """A machine that hangs on its oil, lifted until a chamber is empty."""
    soft = {"isolator": {"membrane_stiffness": 1e4, "chamber_volume": 5.39e-5}}
    control = {"kind": "open-loop", "signals": ({"kind": "step", "amplitude": 10.0, "start": 0.2},)}
    with pytest.raises(Incomplete) as caught:
        simulate(parse_scenario({**BASE, "gravity": 0.0, "actuators": soft, "control": control}))
    return caught.value.result


def text_of(results: dict[str, Result], *sections: Any) -> Any:
    """The page without its drawings, or the given sections of it."""
    return lxml_html.fromstring(render(report_page(results, sections or SECTIONS)))


def names_of(result: Result) -> set[str]:
    """Names of a result's figures."""
    return {picture.name for picture in report_page({"run": result}).pictures}


def rows_of(table: Any) -> list[list[str]]:
    return [[" ".join(cell.text_content().split()) for cell in row.xpath("./th|./td")] for row in table.xpath(".//tr")]


def table_of(where: Any, title: str) -> list[list[str]]:
    (found,) = where.xpath(f'//table[@aria-label="{title}"]')
    return rows_of(found)


def value(text: str) -> float | None:
    """A number of the page."""
    if text == "–":
        return None
    mantissa, _, power = text.replace("−", "-").partition(" × 10")
    return float(mantissa) * 10.0 ** int(power.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")) or 0)


def same(text: str, expected: float | None, rel: float = 5.1e-3) -> bool:
    """Whether a number of the page is the expected one to three significant digits."""
    if expected is None or text == "–":
        return expected is None and text == "–"
    if text == "< 0.001":
        return 0.0 < abs(expected) < 1e-3
    return value(text) == pytest.approx(expected, rel=rel)


# --- numbers -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "shown"),
    [
        (0.0, "0"),
        (1.0, "1.00"),
        (39.87, "39.9"),
        (-0.331, "−0.331"),
        (9.999, "10.0"),
        (99.96, "100"),
        (12345.0, "12300"),
        (0.001234, "0.00123"),
        (1.4e9, "1.40 × 10⁹"),
        (6.6e-11, "6.60 × 10⁻¹¹"),
        (None, "–"),
        (float("nan"), "–"),
        (float("inf"), "∞"),
    ],
)
def test_three_significant_digits(given: float | None, shown: str) -> None:
    assert number(given) == shown


def test_the_verdict_is_the_summarys(folder: Path, whole: Any) -> None:
    criterion = json.loads((folder / "summary.json").read_text())["criterion"]
    verdict, loudest = criterion["verdict"], criterion["max_1s"]["verdict"]
    lines = [
        " ".join(line.text_content().split()) for line in whole.xpath('//*[@id="verdict"]/li[not(@class="worse")]')
    ]
    vertical, horizontal, by, second = lines
    assert vertical.startswith(f"vertical {verdict['vertical']}. Machine worst at ")
    assert horizontal.startswith(f"horizontal {verdict['horizontal']}")
    assert by == "judged by VC curves, constant acceleration from 4 to 8 Hz, RMS over the whole run"
    both = "; ".join(f"{name} {loudest[name]}" for name in ("vertical", "horizontal"))
    assert second == f"by the largest 1 s RMS {both}"
    assert "actuated" in verdict["vertical"]


def test_the_verdict_says_where_the_machine_is_worse_than_its_floor(results: dict[str, Result], whole: Any) -> None:
    """In one sentence: axis, decibel, band and reason."""
    found = [one for one in results["feedforward"].summary.worse if one.amplification_db is not None]
    assert len(found) > 1
    (said,) = whole.xpath('//*[@id="verdict"]/li[@class="worse"]')
    text = " ".join(said.text_content().split())
    for one in found:
        assert f"by {one.amplification_db:.1f} dB at {one.band} Hz" in text
        assert CAUSES[one.by] in text
    assert brief(results["feedforward"].summary)["worse"] == text.removeprefix("worse than its floor ")


def test_headline_attenuation_is_the_summarys(results: dict[str, Result], whole: Any) -> None:
    head, *rows = rows_of(whole.xpath('//*[@id="headline"]//table')[0])
    assert head == ["", "5 Hz", "10 Hz", "20 Hz", "50 Hz", "100 Hz"]
    head = [name.removesuffix(" Hz") for name in head]
    shown = product(results.items(), ("worst place", "centre of gravity"))
    for ((label, result), place), row in zip(shown, rows, strict=True):
        summary = result.summary
        tables = [summary["attenuation_db"]["z"]]
        if place == "worst place":
            tables += [table["z"] for table in summary["attenuation_at_db"].values()]
        expected = [min((v for t in tables if (v := t[band]) is not None), default=None) for band in head[1:]]
        expected = [None if tables[0][band] is None else level for band, level in zip(head[1:], expected, strict=True)]
        assert row[0] == f"{label}, {place}"
        for text, level in zip(row[1:], expected, strict=True):
            assert (text == "–") == (level is None)
            assert level is None or value(text) == pytest.approx(level, abs=0.051)


def rank(verdict: Any) -> tuple[int, float]:
    return list(CLASSES).index(verdict["class"]), math.inf if verdict["margin_db"] is None else verdict["margin_db"]


def test_classes_are_the_summarys(results: dict[str, Result], whole: Any) -> None:
    head, *rows = rows_of(whole.xpath('//*[@id="classes"]//table')[0])
    assert head == ["", "floor", "feedforward", "passive"]
    assert [row for row in rows if len(row) == 1] == [["by RMS over the whole run"], ["by largest sliding 1 s RMS"]]
    expected = []
    for places_of in (lambda summary: summary["criteria"]["vc"], lambda summary: summary["criterion"]["max_1s"]):
        for axis in ("z", "x", "y"):
            by = [dict(places_of(result.summary)["places"]) for result in results.values()]
            floors = [places.pop("floor")[axis] for places in by]
            # The worst place of each: the coarsest class, and of one class the least margin.
            worst = [min((place[axis] for place in places.values()), key=rank) for places in by]
            expected.append([floors[0], *worst])
    for verdicts, row in zip(expected, [row for row in rows if len(row) > 1], strict=True):
        for text, verdict in zip(row[1:], verdicts, strict=True):
            met = verdict["class"] and f"{'' if verdict['decided'] else 'at best '}{verdict['class']}"
            if verdict["class"] and (verdict["margin_db"] is None or verdict["level"] < 1e-12):
                met = "at rest"
            assert text.startswith(met or "worse than workshop")
            if found := re.search(r"\(([\d.]+) dB, ([\d.]+) Hz(, .+)?\)", text):
                assert float(found[1]) == pytest.approx(verdict["margin_db"], abs=0.051)
                assert found[2] == verdict["deciding_band_hz"]


def test_bands_are_the_summarys(results: dict[str, Result], whole: Any) -> None:
    _, *rows = table_of(whole, "Vertical, per third-octave band")
    assert len(rows) > 10
    first = results["feedforward"].summary
    for band, floor, *others in rows:
        assert same(floor, 1e6 * first["third_octave_velocity"]["floor"]["z"][band])
        for k, result in enumerate(results.values()):
            assert same(others[2 * k], 1e6 * result.summary["third_octave_velocity"]["machine"]["z"][band])
            attenuation = result.summary["attenuation_db"]["z"][band]
            assert (others[2 * k + 1] == "–") == (attenuation is None)
            assert attenuation is None or value(others[2 * k + 1]) == pytest.approx(attenuation, abs=0.051)


def test_peaks_are_the_summarys_and_the_datasets(results: dict[str, Result], whole: Any) -> None:
    head, *rows = table_of(whole, "Peak and RMS")
    assert head[1:] == ["feedforward, peak", "feedforward, RMS", "passive, peak", "passive, RMS"]
    shown = {row[0]: row[1:] for row in rows}
    data = results["feedforward"].dataset
    expected = {
        "CG velocity z [µm/s]": 1e6 * data.cg_velocity.sel(axis="z"),
        "CG acceleration x [mm/s²]": 1e3 * data.cg_acceleration.sel(axis="x"),
        "machine displacement ry [µrad]": 1e6 * data.machine_displacement.sel(dof="ry"),
        "floor displacement x [µm]": 1e6 * data.ground_displacement.sel(axis="x"),
        "stroke [µm]": 1e6 * data.stroke,
        "valve command [V]": data.valve_command,
        "spool [mA]": data.spool,
        "actuator force [N]": data.actuator_force,
        "chamber pressure 1 [bar]": 1e-5 * data.chamber_pressure.sel(chamber=1),
        "chamber flow 2 [l/min]": 6e4 * data.chamber_flow.sel(chamber=2),
    }
    for name, values in expected.items():
        about = values if name.startswith("valve") else values - values[0]
        assert same(shown[name][0], float(abs(about).max())), name
        assert same(shown[name][1], float(((about**2).mean("time") ** 0.5).max())), name
    for result, columns in zip(results.values(), ((0, 1), (2, 3)), strict=True):
        for column, kind in zip(columns, ("peak", "rms"), strict=True):
            stroke = max(result.summary[kind]["stroke"].values())
            assert same(shown["stroke [µm]"][column], 1e6 * stroke)
    assert "supply pressure [bar]" not in shown  # it does not move
    assert not any(name.startswith("floor velocity y") for name in shown)


def test_shares_oil_and_timing_are_the_summarys(results: dict[str, Result], whole: Any) -> None:
    head, *rows = table_of(whole, "Share of the time at a limit [%]")
    assert tuple(head[1:]) == MOUNTS
    assert rows[0] == ["feedforward"]
    for row in rows[1:5]:
        shares = results["feedforward"].summary["saturation"][row[0].replace(" ", "_")]
        assert all(same(text, 100.0 * shares[mount]) for text, mount in zip(row[1:], MOUNTS, strict=True))
    for title, key, names in (
        ("Oil drawn from the supply", "oil", {"mean flow [l/min]": ("mean_flow_m3_s", 6e4)}),
        ("Oil drawn from the supply", "oil", {"peak flow [l/min]": ("peak_flow_m3_s", 6e4)}),
        ("Oil drawn from the supply", "oil", {"mean power [W]": ("mean_power_w", 1.0)}),
        ("Computation", "timing", {"step [µs]": ("timestep_s", 1e6), "stepping [s]": ("stepping_s", 1.0)}),
    ):
        shown = {row[0]: row[1:] for row in table_of(whole, title)[1:]}
        for name, (entry, factor) in names.items():
            for text, result in zip(shown[name], results.values(), strict=True):
                assert same(text, factor * result.summary[key][entry]), name


def worst_of_the_machine(tables: Any, axis: str) -> dict[str, float | None]:
    """Per band the largest level of all places but the floor: charts draw the machine where it is judged."""
    places = [tables[place][axis] for place in tables if place != "floor"]
    assert len(places) > 1
    return {band: max((table[band] for table in places if table[band] is not None), default=None) for band in places[0]}


def test_figures_show_the_summarys_levels(results: dict[str, Result], pictures: list[Picture]) -> None:
    figures = {picture.name: picture.figure for picture in pictures}
    colors = Shown.of(results).colors
    for axis in ("z", "x"):
        for figure, levels in (
            ("attenuation", lambda summary, axis=axis: summary["attenuation_db"][axis]),
            ("criterion", lambda summary, axis=axis: worst_of_the_machine(summary["third_octave_velocity"], axis)),
        ):
            lines = {line.get_color(): line for line in figures[f"{figure}-{axis}"].axes[0].lines}
            for label, result in results.items():
                factor = 1e6 if figure == "criterion" else 1.0
                expected = [factor * (np.nan if level is None else level) for level in levels(result.summary).values()]
                np.testing.assert_allclose(lines[colors[label]].get_ydata(), expected)
        floor = results["passive"].summary["third_octave_velocity"]["floor"][axis]
        line = {line.get_color(): line for line in figures[f"criterion-{axis}"].axes[0].lines}[plots.FLOOR_COLOR]
        np.testing.assert_allclose(line.get_ydata(), [1e6 * (level or np.nan) for level in floor.values()])
    assert "attenuation-y" not in figures  # the floor does not move along y


def test_histories_reach_their_peaks(results: dict[str, Result], pictures: list[Picture]) -> None:
    figures = {picture.name: picture.figure for picture in pictures}
    data = results["feedforward"].dataset
    for name, values in (
        ("history-command", data.valve_command.values),
        ("history-stroke", 1e6 * (data.stroke.values - data.stroke.values[0])),
        ("history-pressure", 1e-5 * (data.chamber_pressure - data.chamber_pressure.mean("time")).values),
    ):
        above = figures[name].axes[0]
        drawn = np.concatenate([path.vertices[:, 1] for part in above.collections for path in part.get_paths()])
        assert (drawn.min(), drawn.max()) == pytest.approx((values.min(), values.max()), rel=1e-12)


# --- transmissibility, limits, modes --------------------------------------------------------------------------------


def test_the_linear_transmissibility_is_drawn(results: dict[str, Result], pictures: list[Picture]) -> None:
    figures = {picture.name: picture.figure for picture in pictures}
    colors = Shown.of(results).colors
    model = linear_model(results["passive"].scenario.plant)
    for dof, output in (("z", "cg_displacement z"), ("rx", "machine_displacement rx")):
        above, phase, _ = figures[f"transmissibility-{dof}"].axes
        for label, result in results.items():
            loop = Loop.of(result.scenario, result.controller)
            expected = rigid_floor(model, FREQUENCIES, loop, (output,), (dof,)).response[:, 0, 0]
            magnitude = next(line for line in above.lines if is_linear(line, colors[label]))
            np.testing.assert_allclose(magnitude.get_ydata(), 20 * np.log10(np.abs(expected)))
            angle = next(line for line in phase.lines if is_linear(line, colors[label]))
            np.testing.assert_allclose(angle.get_ydata(), np.degrees(np.angle(expected)))


def is_linear(line: Any, color: str) -> bool:
    return line.get_color() == color and len(line.get_xdata()) == FREQUENCIES.size


def test_the_runs_own_transmissibility_is_drawn(results: dict[str, Result], pictures: list[Picture]) -> None:
    """By SciPy's csd of the run's own velocities: the same lines before neighbours are averaged, below 5 Hz."""
    figure = {picture.name: picture for picture in pictures}["transmissibility-z"]
    assert "Measured: Welch, 28 averages of 0.225 s or more, H1; left out where" in figure.caption
    data = results["passive"].dataset.isel(time=slice(400, None))
    floor, machine = data.ground_velocity.sel(axis="z").mean("mount").values, data.cg_velocity.sel(axis="z").values
    settings = {"nperseg": 226, "detrend": "constant"}
    f, cross = signal.csd(floor, machine, 1000.0, **settings)
    _, own = signal.welch(floor, 1000.0, **settings)
    color = Shown.of(results).colors["passive"]
    line = next(x for x in figure.figure.axes[0].lines if x.get_color() == color and x.get_linestyle() == "None")
    shown = dict(zip(np.round(line.get_xdata(), 6), line.get_ydata(), strict=True))
    for k in (1, 2, 3, 4):
        assert shown[round(f[k], 6)] == pytest.approx(20 * np.log10(abs(cross[k] / own[k])), abs=1e-6)


def test_directions_that_rest_have_no_transmissibility(pictures: list[Picture], at_rest: Result) -> None:
    names = {picture.name for picture in pictures}
    assert {"transmissibility-z", "transmissibility-x", "transmissibility-rx", "transmissibility-ry"} <= names
    assert "transmissibility-y" not in names
    (still,) = (picture for picture in report_page({"run": at_rest}).pictures if "transmissibility" in picture.name)
    assert still.name == "transmissibility-z"
    assert still.caption.startswith("Not measured")


def test_modes_are_those_of_the_analysis(results: dict[str, Result], whole: Any) -> None:
    head, *rows = table_of(whole, "Modes of the machine")
    assert head == ["mode", "f [Hz]", "ζ [-]", "moves", "turns about"]  # feedforward moves none: no column of its own
    found = [mode for mode in modes(linear_model(results["passive"].scenario.plant)) if mode.machine_moves]
    assert [row[0] for row in rows] == [mode.name for mode in found]
    for row, mode in zip(rows, found, strict=True):
        assert same(row[1], mode.frequency)
        assert float(row[2]) == pytest.approx(mode.damping_ratio, abs=5.1e-5)
    by_name = {row[0]: row[3:] for row in rows}
    # By symmetry yaw turns about the middle, heave about nothing, and each rocking in its plane.
    assert by_name["yaw"] == ["rz 1.00", "z axis at x 0.00, y 0.00 m"]
    assert by_name["heave"] == ["z 1.00", "nothing: translates"]
    assert by_name["rocking about x"][1].startswith("x axis at y 0.00, z 0.7")  # near the CG, 0.75 m
    (note,) = (text for text in whole.xpath('//section[@id="modes"]//p/text()') if "law" in text)
    assert "feedforward: the law reads the ground alone and moves no mode." in note
    assert "valves held: the valves swing at 250 Hz, ζ 0.650." in note


def test_a_loop_that_feeds_back_has_modes_of_its_own(results: dict[str, Result]) -> None:
    law = Controller(
        np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((4, 0)), -100.0 * np.ones((4, 1)), ("machine_velocity z",)
    )
    seen = text_of({"run": replace(results["passive"], controller=law), "passive": results["passive"]}, modes_section)
    head, *rows = table_of(seen, "Modes of the machine")
    assert head[1:5] == ["valves held: f [Hz]", "valves held: ζ [-]", "run: f [Hz]", "run: ζ [-]"]
    model = linear_model(results["passive"].scenario.plant)
    closed = {mode.name: mode for mode in modes(model, Loop.of(results["passive"].scenario, law)) if mode.machine_moves}
    assert {row[0] for row in rows} == set(closed)
    for name, held, _, frequency, damping, *_ in rows:
        assert same(frequency, closed[name].frequency)
        assert float(damping) == pytest.approx(closed[name].damping_ratio, abs=5.1e-5)
        assert (abs(value(frequency) - value(held)) > 0.1) == (
            name == "heave"
        )  # alike at all mounts: only heave sees it


def test_the_map_of_rocking_has_the_machine_in_it(results: dict[str, Result], pictures: list[Picture]) -> None:
    """Marked at its own height and footprint; there the map has the mode of the linear model."""
    (figure,) = (picture.figure for picture in pictures if picture.name == "modes-map")
    (axes,) = figure.axes
    scenario = results["passive"].scenario
    mark = next(line for line in axes.lines if line.get_label() == "this machine")
    assert (mark.get_xdata()[0], mark.get_ydata()[0]) == pytest.approx((1.2, 0.75))
    here = slowest_rocking(rocking_modes(scenario, xr.DataArray([0.75], dims="d"), xr.DataArray([1.0], dims="d")))
    found = min(mode.frequency for mode in modes(linear_model(scenario.plant)) if mode.name.startswith("sway-rocking"))
    assert float(here[0]) == pytest.approx(found, rel=1e-6)


def test_each_machine_has_a_table_of_its_modes(results: dict[str, Result]) -> None:
    heavy = replace(results["passive"], scenario=load_scenario("recorded", ["machine.mass=8000"]))
    seen = text_of({"light": results["passive"], "heavy": heavy}, modes_section)
    frequencies = [
        value(next(row[1] for row in table_of(seen, f"Modes of the machine, {name}") if row[0] == "heave"))
        for name in ("light", "heavy")
    ]
    # Plates move with the machine: (4000 + 56)/(8000 + 56), and to 1 % the damping's share in |λ|.
    assert frequencies[1] / frequencies[0] == pytest.approx(np.sqrt(4056 / 8056), rel=1e-2)


def test_peaks_stand_against_their_limits(results: dict[str, Result], whole: Any) -> None:
    head, *rows = table_of(whole, "Peaks against limits")
    assert head == ["", "feedforward", "passive"]
    shown = {row[0]: row[1:] for row in rows}
    for k, result in enumerate(results.values()):
        data = result.dataset
        for name, values, limit in (
            ("stroke [mm]", 1e3 * data.stroke, 1e3 * 5.39e-4 / 2 / 3.18e-2),
            ("command [V]", data.valve_command, 10.0),
            ("spool [mA]", data.spool, 20.0),
            ("flow into a chamber, of the rated [l/min]", 6e4 * data.chamber_flow, 6e4 * 1.94e-6 * 20.0),
            ("highest chamber pressure, of the supply [bar]", 1e-5 * data.chamber_pressure, 70.0),
        ):
            peak, _, bound, share, _ = shown[name][k].replace("(", "").split()
            largest = float(abs(values).max())
            assert same(peak, largest), name
            assert same(bound, limit), name
            assert value(share) == pytest.approx(100.0 * largest / limit, rel=0.051), name
        lowest = shown["lowest chamber pressure [bar]"][k].split()[0]
        assert same(lowest, 1e-5 * float(data.chamber_pressure.min()))


def test_limits_that_were_reached_say_when(results: dict[str, Result]) -> None:
    assert not text_of(results, limits).xpath('//table[@aria-label="Limits that were reached"]')
    reached = {"first_s": 1.25, "longest_s": 0.031, "mount": "rear-left"}
    at_limit = {"command": reached, "spool": None}
    seen = text_of({"run": with_summary(results["passive"], at_limit=at_limit)}, limits)
    assert table_of(seen, "Limits that were reached")[1:] == [["command", "1.250", "0.0310", "rear-left"]]


def test_margins_stand_as_the_summary_says_them(results: dict[str, Result]) -> None:
    assert loops(Shown.of({"run": results["passive"]})) is None
    heave = {"gain_db": 9.859, "phase_deg": 53.95, "disk": 0.9939, "peak_sensitivity": 1.497, "peak_hz": 421.7}
    warp = {**heave, "gain_db": None, "phase_deg": None, "crossings_hz": []}
    motions = {"heave": {**heave, "crossings_hz": [66.85, 79.2388]}, "warp": warp}
    whole = {"stable": True, "gain_db": 7.25, "phase_deg": 51.0, "disk": 0.5, "disk_all_valves": 0.61}
    grows = {"frequency_hz": 84.2, "damping_ratio": -0.01, "growth_1_s": 5.3, "motion": "heave", "count": 1}
    poles = None, {**grows, "words": "heave at 84.2 Hz with damping ratio −0.01"}
    one, other = (
        with_summary(results["passive"], margins={**whole, "stable": not pole, "motions": motions, "unstable": pole})
        for pole in poles
    )
    rows = [
        ["least, anywhere", "7.25", "51.0", "0.500", "–", "–", "–"],
        ["heave", "9.86", "54.0", "0.994", "1.50", "422", "66.8, 79.2"],
        ["warp", "–", "–", "0.994", "1.50", "422", "–"],
    ]
    assert table_of(text_of({"run": one}, loops), "Margins of the control loop")[1:] == rows
    unstable = ["the closed loop is unstable: heave at 84.2 Hz with damping ratio −0.01", *["–"] * 6]
    both = table_of(text_of({"one": one, "other": other}, loops), "Margins of the control loop")[1:]
    assert both == [["one"], *rows, ["other"], unstable, *rows]


def with_summary(result: Result, **entries: Any) -> Result:
    return replace(result, summary=result.summary.changed(**entries))


# --- the page stands alone -----------------------------------------------------------------------------------------


class Nesting(HTMLParser):
    """Finds tags that are not closed where they must be."""

    VOID = ("meta", "br", "link", "img", "hr", "input")

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.external: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in self.VOID:
            self.open.append(tag)
        self.external += [text or "" for key, text in attrs if key in ("src", "href", "xlink:href", "data", "action")]
        assert tag not in ("script", "link", "iframe", "img"), tag

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_is_well_formed_and_asks_for_nothing(folder: Path) -> None:
    text = (folder / "report.html").read_text(encoding="utf-8")
    assert text.startswith("<!DOCTYPE html>")
    parser = Nesting()
    parser.feed(text)
    assert parser.open == []
    assert all(target.startswith(("#", "data:image/png;base64,")) for target in parser.external)
    assert set(re.findall(r"https?:[^\"' )]*", text)) == {"http://www.w3.org/2000/svg"}
    assert "@import" not in text
    assert "url(" not in text[: text.index("</style>")]


def test_ids_are_unique_and_references_resolve(folder: Path) -> None:
    text = (folder / "report.html").read_text(encoding="utf-8")
    ids = re.findall(r'\bid="([^"]*)"', text)
    assert len(ids) == len(set(ids))
    assert {a or b for a, b in re.findall(r'href="#([^"]*)"|url\(#([^)]*)\)', text)} <= set(ids)


def test_every_figure_is_a_file_too(folder: Path, whole: Any, pictures: list[Picture]) -> None:
    names = [picture.name for picture in pictures]
    assert sorted(path.stem for path in (folder / "figures").iterdir()) == sorted(names)
    assert [figure.get("id") for figure in whole.xpath("//figure")] == [f"figure-{name}" for name in names]
    text = (folder / "report.html").read_text(encoding="utf-8")
    for name in names:
        assert plots.inline((folder / "figures" / f"{name}.svg").read_text(encoding="utf-8")) in text
    assert sorted(path.name for path in folder.glob(".*")) == []


@pytest.mark.parametrize("which", ["results", "at_rest", "failed"])
def test_every_figure_has_units_and_a_legend(which: str, request: pytest.FixtureRequest) -> None:
    given = request.getfixturevalue(which)
    for picture in request.getfixturevalue("pictures") if which == "results" else report_page({"run": given}).pictures:
        legends = [*picture.figure.legends, *filter(None, (axes.get_legend() for axes in picture.figure.axes))]
        assert len(legends) == 1, picture.name
        for axes in picture.figure.axes:
            across = [] if axes.get_label() == "<colorbar>" else [axes.get_xlabel()]
            for label in (*across, axes.get_ylabel()):
                assert re.search(r"\w.* \[[^\]]+\]", label), picture.name


def test_the_page_shows_parameters_with_their_sources(whole: Any) -> None:
    _, *rows = table_of(whole, "Actuator isolator")
    shown = {row[0].rsplit(" ", 1)[-1]: row[1:] for row in rows}
    assert shown["piston_area"] == ["Ap", "0.0318 m²", "paper"]
    assert shown["flow_gain"] == ["KQ", "1.94 × 10⁻⁶ m³/s/mA", "paper"]
    assert shown["spool_drive_limit"][2] == "identified"
    assert shown["foot_stiffness"] == ["kf", "∞ N/m", "assumed"]
    assert {row[0].rsplit(" ", 1)[-1]: row[2] for row in table_of(whole, "Supply")[1:]}["pressure"].endswith("(70 bar)")
    settings = {row[0].rsplit(" ", 1)[-1]: row[1] for row in table_of(whole, "Ground")[1:]}
    assert settings["kind"] == "broadband"
    assert (settings["level"], settings["wave.speed"], settings["wave.direction"]) == ("VC-C", "200", "30")
    assert table_of(whole, "Control, passive")[1][1] == "passive"
    mounts = table_of(whole, "Mounts")[1:]
    assert mounts[1] == ["front-right", "0.9", "−0.6", "isolator"]


def test_a_changed_parameter_is_given(results: dict[str, Result]) -> None:
    table = {**BASE, "machine": {"mass": 4321.0}, "actuators": {"isolator": {"piston_area": 0.03}}}
    seen = text_of({"run": replace(results["passive"], scenario=parse_scenario(table))}, inputs)
    assert table_of(seen, "Machine")[1][2:] == ["4321 kg", "given"]
    assert table_of(seen, "Actuator isolator")[1][2:] == ["0.03 m²", "given"]
    assert seen.xpath('//tbody//span[@class="badge given"]')


def visible(where: Any) -> str:
    return " ".join(where.xpath('//body//text()[not(ancestor::*[name()="style"])]'))


@pytest.mark.parametrize("which", ["results", "at_rest", "failed"])
def test_nothing_undefined_is_printed(which: str, request: pytest.FixtureRequest) -> None:
    given = request.getfixturevalue(which)
    seen = request.getfixturevalue("whole") if which == "results" else text_of({"run": given})
    assert not re.search(r"\b(None|nan|NaN|undefined|True|False|float64)\b", visible(seen))
    for row in seen.xpath("//tbody/tr[td]"):
        if not row.xpath("./th/code"):  # a parameter without symbol or source has empty cells
            assert all(cell.text_content().strip() for cell in row.xpath("./td")), row.text_content()


# --- what did not work is said -------------------------------------------------------------------------------------


def test_an_incomplete_run_says_so_loudly(failed: Result) -> None:
    (alert,) = text_of({"run": failed}, headline).xpath('//*[@role="alert"]')
    text = " ".join(alert.text_content().split())
    assert text.startswith("Incomplete ")
    assert failed.summary["failure"] in text
    assert "history-stroke" in names_of(failed)
    complete = replace(failed, summary=failed.summary.changed(complete=True))
    assert text_of({"run": complete}, headline).xpath('//*[@role="alert"]') == []


def test_the_end_of_a_run_that_failed_is_drawn_in_full(failed: Result, results: dict[str, Result]) -> None:
    data = results["passive"].dataset
    assert characteristic_part(replace(failed, dataset=data)) == pytest.approx((3.0, 4.0))
    begin, end = characteristic_part(results["passive"]) or (0.0, 0.0)
    floor = data.ground_velocity.sel(axis="z").mean("mount")
    assert begin <= float(data.time[int(np.abs(floor.values).argmax())]) <= end
    short = failed.dataset.sel(time=slice(0.0, 0.9))
    assert characteristic_part(replace(failed, dataset=short)) is None  # it is not longer than the part


def test_an_incomplete_variant_is_named(failed: Result, results: dict[str, Result]) -> None:
    seen = text_of({"good": results["passive"], "bad": failed}, headline)
    assert [node.text_content().split()[1] for node in seen.xpath('//*[@role="alert"]')] == ["bad"]


@pytest.mark.parametrize("rows", [0, 1, 2, 17])
def test_a_run_that_hardly_began_has_a_page(failed: Result, rows: int, tmp_path: Path) -> None:
    part = failed.dataset.isel(time=slice(0, rows))
    numbers = ("class", "deciding_band_hz", "margin_db", "next_class", "next_band_hz", "excess_db")
    undecided = {**dict.fromkeys(numbers), "decided": False, "undecided_bands_hz": ["4", "5"]}
    place = {**dict.fromkeys("xyz", undecided), "worst": None, "deciding_axis": None}
    verdict = {"vertical": "floor worse than workshop, machine worse than workshop", "horizontal": "the same"}
    criterion = {"floor": place, "machine": place, "verdict": verdict}
    nothing = {axis: {"5": None, "10": None} for axis in ("x", "y", "z", "rx", "ry")}
    levels = {who: {axis: {"5": None} for axis in "xyz"} for who in ("floor", "machine")}
    summary = failed.summary.changed(
        peak={}, rms={}, criterion=criterion, attenuation_db=nothing, third_octave_velocity=levels
    )
    write_report(tmp_path, {"run": replace(failed, dataset=part, summary=summary)})
    seen = lxml_html.fromstring((tmp_path / "report.html").read_text(encoding="utf-8"))
    said = seen.xpath('//*[@id="verdict"]')[0].text_content()
    assert "not judged" in said
    assert "worse than workshop" not in said
    assert ("Nothing was recorded" in visible(seen)) == (rows < 2)


def test_ground_at_rest_has_no_attenuation(at_rest: Result) -> None:
    seen = text_of({"run": at_rest}, headline)
    assert "The ground is at rest" in seen.xpath('//*[@id="headline"]')[0].text_content()
    names = names_of(at_rest)
    assert not any("attenuation" in name for name in names)
    assert {"criterion-z", "history-velocity", "history-command"} <= names


def test_a_passive_run_has_no_command(results: dict[str, Result]) -> None:
    assert "history-command" not in names_of(results["passive"])
    assert "the valves stay centred" in visible(text_of({"alone": results["passive"]}, histories))


def test_warnings_stand_on_top_and_processing_below(results: dict[str, Result]) -> None:
    shared = "record R ends at 40 Hz (sampled at 100 Hz): bands above 40 Hz are undecided"
    steps = "record R, in this order: linear trend subtracted"
    odd = "a warning that nobody thought of"
    runs = {
        label: replace(result, summary=result.summary.changed(warnings=[steps, shared, *extra]))
        for (label, result), extra in zip(results.items(), ([odd], []), strict=True)
    }
    seen = text_of(runs, warnings, inputs)
    assert [item.text_content() for item in seen.xpath('//*[@id="warnings"]//li')] == [shared, f"feedforward: {odd}"]
    assert [item.text_content() for item in seen.xpath('//*[@id="inputs"]//ul/li')] == [steps]


def test_names_of_several_results_that_share_a_warning_are_told_apart(results: dict[str, Result]) -> None:
    """Names have commas themselves."""
    odd, quiet = (results["passive"].summary.changed(warnings=found) for found in (["odd"], []))
    runs = {"recorded, passive": odd, "recorded, soft": odd, "quiet": quiet}
    seen = text_of({name: replace(results["passive"], summary=summary) for name, summary in runs.items()}, warnings)
    (told,) = seen.xpath('//*[@id="warnings"]//li')
    assert told.text_content() == "recorded, passive; recorded, soft: odd"


def test_the_notes_of_a_real_record_are_told_apart() -> None:
    start = Start(MOUNTS, np.zeros((4, 2)), 20.0, 0)
    notes = load_scenario("recorded").ground.motion(start).notes
    limit, slow = (note for note in notes if not PROCESSING.match(note))
    assert "undecided" in limit
    assert "too slowly for the vibration criteria" in slow


def test_the_notes_of_a_floor_are_told_apart() -> None:
    start = Start(MOUNTS, np.array([[0.9, 0.6], [0.9, -0.6], [-0.9, 0.6], [-0.9, -0.6]]), 20.0, 0)
    notes = load_scenario("seismic-site").ground.motion(start).notes
    (limit,) = (note for note in notes if not PROCESSING.match(note))
    assert limit == "floor shaped to a peterson target from 0.1 to 10 Hz: bands from 10 Hz on are undecided"


def test_defects_of_a_record_are_warnings(tmp_path: Path) -> None:
    """Clipped, with a gap, sampled too slowly and in a unit that no floor has: each is named on top of the page."""
    time = np.delete(np.arange(1000) / 100.0, slice(400, 420))
    samples = np.clip(np.sin(2 * np.pi * 3.0 * time), -0.5, 0.5)
    lines = [f"{t:.2f}, {v!r}" for t, v in zip(time, samples.tolist(), strict=True)]
    (tmp_path / "bad.csv").write_text("time [s], z [m/s]\n" + "\n".join(lines))
    ground = {"kind": "record", "file": str(tmp_path / "bad.csv"), "gaps": "interpolate"}
    run = simulate(parse_scenario({**BASE, "duration": 2.0, "ground": ground}))
    seen = text_of({"run": run}, warnings, inputs)
    told = [item.text_content() for item in seen.xpath('//*[@id="warnings"]//li')]
    for part in ("looks clipped", "1 gap", "which no floor does", "too slowly for the vibration criteria"):
        assert any(part in text for text in told), part
    assert set(told) <= set(run.summary["warnings"])
    processed = [item.text_content() for item in seen.xpath('//*[@id="inputs"]//ul/li')]
    assert set(told) | set(processed) == set(run.summary["warnings"])


def test_names_of_the_user_are_text(results: dict[str, Result]) -> None:
    name = "<script>alert('$x$')</script> & \"Ω\""
    run = replace(results["passive"], scenario=parse_scenario({**BASE, "name": name, "description": name}))
    both = {name: run, "_x": results["feedforward"]}
    seen = text_of(both)
    assert seen.xpath("//script") == []
    assert seen.xpath("//h1")[0].text_content() == f"{name} beside _x"
    (figure,) = (picture.figure for picture in report_page(both).pictures if picture.name == "attenuation-z")
    assert html.escape(name, quote=False)[:35] in plots.svg(figure, "a")


def test_passive_keeps_its_colour(results: dict[str, Result]) -> None:
    active, passive = results["feedforward"], results["passive"]
    assert Shown.of({"a": active, "b": passive}).colors == {"a": plots.BLUE, "b": plots.VERMILLION}
    assert Shown.of({"b": passive, "a": active}).colors == {"b": plots.VERMILLION, "a": plots.BLUE}
    many = Shown.of({str(k): active for k in range(12)}).colors
    assert plots.VERMILLION not in many.values()
    assert plots.FLOOR_COLOR not in many.values()


def test_a_report_needs_a_result(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="at least one"):
        write_report(tmp_path, {})
    assert list(tmp_path.iterdir()) == []


def test_a_second_report_leaves_nothing_of_the_first(
    results: dict[str, Result], at_rest: Result, tmp_path: Path
) -> None:
    write_report(tmp_path, results)
    (tmp_path / "figures" / "mine.svg").write_text("<svg/>")
    before = (tmp_path / "report.html").read_bytes()
    write_report(tmp_path, results)
    assert (tmp_path / "report.html").read_bytes() == before
    write_report(tmp_path, {"run": at_rest})
    kept = {path.stem for path in (tmp_path / "figures").iterdir()}
    assert kept == {picture.name for picture in report_page({"run": at_rest}).pictures} | {"mine"}


# --- size and time ------------------------------------------------------------------------------------


def test_a_minute_at_1_khz_is_small(results: dict[str, Result], tmp_path: Path) -> None:
    minute = {}
    for label, result in results.items():
        parts = [result.dataset.isel(time=slice(0, 4000))] * 15
        data = xr.concat(parts, "time").assign_coords(time=np.arange(60_000) / 1000.0)
        minute[label] = replace(result, dataset=data)
    write_report(tmp_path, minute)
    assert (tmp_path / "report.html").stat().st_size < 3e6
