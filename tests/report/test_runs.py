"""Several runs on one page: each is described, and every setting that differs stands side by side, no other."""

import tomllib
from types import SimpleNamespace
from typing import Any

import pytest
from lxml import html

from ehamj.pages import render
from ehamj.report import report_page
from ehamj.report.sections.runs import differences, runs
from ehamj.report.shown import Shown
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

BASE: dict[str, Any] = {
    "name": "hall",
    "description": "a mill in a hall",
    "duration": 0.5,
    "plates": "tied",
    "ground": {"kind": "broadband", "level": "VC-A"},
    "control": {"kind": "feedforward"},
}


def rows(results: dict[str, Result], title: str) -> dict[str, list[str]]:
    """Cells of a table of the section by its rows' first one, as text."""
    seen = html.fromstring(render(report_page(results, [runs])))
    (table,) = seen.xpath(f'//table[@aria-label="{title}"]')
    cells = ([" ".join(c.text_content().split()) for c in row.xpath("./th|./td")] for row in table.xpath(".//tbody/tr"))
    return {first: others for first, *others in cells}


@pytest.fixture(scope="module")
def results() -> dict[str, Result]:
    first = parse_scenario(BASE)
    heavier = first.varied({"machine.mass": 5200.0, "name": "heavier"})
    other = parse_scenario(
        {**BASE, "name": "rig", "description": "", "ground": {"kind": "sine", "amplitude": 1e-6, "frequency": 20.0},
         "criteria": {"low_frequency": "flat"}}
    )  # fmt: skip
    return {one.name: simulate(one) for one in (first, heavier, other, other.variant("passive"))}


def test_every_run_is_described(results: dict[str, Result]) -> None:
    found = rows(results, "Runs")
    assert found["what it is"] == ["a mill in a hall", "a mill in a hall", "–", "–"]
    assert found["simulated"] == ["0.5 s"] * 4
    assert found["floor"] == ["broadband VC-A", "broadband VC-A", "sine", "sine"]
    assert found["control"] == ["feedforward", "feedforward", "feedforward", "passive"]
    for label, said in zip(results, found["verdict, vertical"], strict=True):
        assert said == results[label].summary.criterion.briefly()["vertical"]
    assert [said.split(", RMS")[0] for said in found["judged by"]] == [
        *["VC curves, constant acceleration from 4 to 8 Hz"] * 2,
        *["VC curves, VC-C and stricter from 1 Hz"] * 2,
    ]


def test_two_runs_of_one_scenario_are_compared_and_no_family(results: dict[str, Result]) -> None:
    one = results["hall"]
    assert not Shown.of({"hall (a)": one, "hall (b)": one}).together
    variant = one.scenario.variant("passive")
    beside = SimpleNamespace(scenario=variant, dataset=one.dataset, summary=one.summary)
    assert Shown.of({"feedforward": one, "passive": beside}).together  # type: ignore[dict-item]


def test_settings_that_differ_stand_side_by_side(results: dict[str, Result]) -> None:
    found = {name.split()[-1]: cells for name, cells in rows(results, "Differences in settings").items()}
    assert found["machine.mass"] == ["4000", "5200", "4000", "4000"]
    assert found["ground.kind"] == ["broadband", "broadband", "sine", "sine"]
    assert found["ground.frequency"] == ["–", "–", "20", "20"]
    assert found["control.kind"] == ["feedforward", "feedforward", "feedforward", "passive"]
    assert found["criteria.low_frequency"] == ["classic", "classic", "flat", "flat"]
    assert found["control.designed_for"][0] == "the run's own"
    assert found["control.designed_for"][1].startswith("machine.mass = 4000")
    assert not {"name", "description", "duration", "seed", "machine.mass.sources"} & found.keys()
    assert [found[f"ground.{name}"] for name in ("level", "first", "fall")] == [
        ["VC-A", "VC-A", "–", "–"], ["1", "1", "–", "–"], ["12", "12", "–", "–"],
    ]  # fmt: skip


def flat(table: Any, key: str = "") -> dict[str, Any]:
    """Every value of a scenario as it is written, by its key."""
    if not isinstance(table, dict):
        return {key: table}
    found: dict[str, Any] = {}
    for name, value in table.items():
        found |= flat(value, f"{key}.{name}".lstrip("."))
    return found


@pytest.mark.parametrize(
    "other",
    [
        {"kind": "record", "file": "example:BW.RJOB", "remove_response": True, "highpass": 0.5},
        {"kind": "sine", "amplitude": 1e-6, "frequency": 20.0, "wave": {"speed": 300.0, "direction": 90.0}},
        {"kind": "broadband", "level": "VC-B", "wave": {"speed": 200.0}},
        {"kind": "broadband", "level": "VC-A", "axes": ["x", "z"], "fade_in": 0.2},
    ],
)
def test_every_setting_that_differs_is_told_with_its_unit(other: dict[str, Any]) -> None:
    """By the tables that are written of the scenarios: none of their differences is missing."""
    one, two = parse_scenario(BASE), parse_scenario({**BASE, "ground": other})
    written = [flat(tomllib.loads(scenario.to_toml())["ground"], "ground") for scenario in (one, two)]
    differ = {key for key in written[0].keys() | written[1].keys() if written[0].get(key) != written[1].get(key)}
    stands: Any = SimpleNamespace(results={str(k): SimpleNamespace(scenario=own) for k, own in enumerate((one, two))})
    told = {html.fromstring(str(row[0])).xpath("string(//code)"): str(row[0]) for row in differences(stands).rows}
    assert differ <= told.keys()
    units = {
        "ground.wave.speed": "[m/s]",
        "ground.wave.direction": "[deg]",
        "ground.fade_in": "[s]",
        "ground.fall": "[dB/octave]",
    }
    for key in differ & units.keys():
        assert units[key] in told[key]


def test_a_law_beside_none_is_told_by_what_is_not_as_by_default() -> None:
    one = parse_scenario({**BASE, "control": {"kind": "combined", "delay": 1e-4}})
    stands: Any = SimpleNamespace(results={"a": SimpleNamespace(scenario=one)})
    stands.results["b"] = SimpleNamespace(scenario=one.variant("passive"))
    table = differences(stands)
    told = [html.fromstring(str(row[0])).xpath("string(//code)") for row in table.rows]
    assert told == ["control.kind", "control.delay", "control.designed_for"]
    assert "as by default" in table.note


def test_a_run_alone_and_runs_that_are_the_same_have_no_differences(results: dict[str, Result]) -> None:
    assert runs(Shown.of({"hall": results["hall"]})) is None
    section = runs(Shown.of({"a": results["hall"], "b": results["hall"]}))
    assert section is not None
    assert section.tables[1].rows == []


def test_the_page_is_headed_by_all_that_it_compares(results: dict[str, Result]) -> None:
    own = {name: results[name] for name in ("rig", "rig, passive")}
    assert report_page(own).heading == "rig"
    page = report_page({name: results[name] for name in ("hall", "heavier")})
    assert page.heading == "hall beside heavier"
    assert page.verdict[0][0] == "hall, vertical"
