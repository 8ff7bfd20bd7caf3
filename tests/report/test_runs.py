"""Several runs on one page: each is described, and every setting that differs stands side by side, no other."""

from typing import Any

import pytest
from lxml import html

from ehamj.pages import render
from ehamj.report import report_page
from ehamj.report.sections.runs import runs
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
