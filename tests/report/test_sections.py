"""Every registered section of the report is made from a small run, by itself."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from lxml import html

from ehamj.pages import Page, Section, render, write_page
from ehamj.report import Shown, report_page
from ehamj.report.sections import SECTIONS, annex
from ehamj.report.sections.machine import machine
from ehamj.report.sections.runs import runs_beside, runs_first
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

ASKED = {
    "points": {"nose": [0.33, 0.0, 1.06]},
    "relative": [{"name": "laser", "from": "nose", "to": "ground front-left"}],
    "criteria": {"response_spectrum": {"last": 63.0}},
    "ground": {"kind": "broadband", "level": "VC-C"},
    "fault": [{"kind": "valve-stuck", "mount": "front-left", "time": 0.5, "settling": 0.1}],
}


@pytest.fixture(scope="module")
def shown() -> Shown:
    """A run that has something to say in every section: 1 s, too short for the low bands, which is a warning."""
    table = {"name": "small", "duration": 1.0, "plates": "tied", "compare": (), **ASKED}
    active = simulate(parse_scenario({**table, "control": {"kind": "combined", "linearisation": {}}}))
    return Shown.of({"active": active, "passive": simulate(parse_scenario(table))})


ELSEWHERE = (annex, runs_first)
"""A heading alone; and what pages of several scenarios have in front."""


@pytest.mark.parametrize(
    "section", [one for one in SECTIONS if one not in ELSEWHERE], ids=lambda section: section.__name__
)
def test_a_section_is_made(section: Callable[[Shown], Section | None], shown: Shown, tmp_path: Path) -> None:
    found = section(shown)
    assert found is not None, "nothing in the run asks for it: extend ASKED"
    write_page(tmp_path, "page.html", Page("t", "t", "", [found]))
    (seen,) = html.fromstring((tmp_path / "page.html").read_text("utf-8")).xpath(f'//*[@id="{found.id}"]')
    drawn = [figure.get("id").removeprefix("figure-") for figure in seen.xpath(".//figure[.//*[name()='svg']]")]
    assert sorted(drawn) == sorted(path.stem for path in (tmp_path / "figures").iterdir())
    assert len(drawn) == len(found.figures)
    assert len(seen.xpath(".//table")) == sum(bool(table.rows) for table in found.tables)
    assert seen.xpath(".//td | .//li | .//figure | .//p | .//dd")
    for table in found.tables:
        assert {len(row) for row in table.rows} <= {1, len(table.head)}, table.title
    for picture in found.figures:
        for axes in picture.figure.axes:
            across = [] if axes.get_label() == "<colorbar>" else [axes.get_xlabel()]
            assert all(re.search(r"\w.* \[[^\]]+\]", text) for text in (*across, axes.get_ylabel()))


def test_sections_have_names_of_their_own(shown: Shown) -> None:
    page = Page("t", "t", "", [found for section in SECTIONS if (found := section(shown))])
    ids = html.fromstring(render(page)).xpath("//@id")
    assert len(ids) == len(set(ids))


def test_what_a_client_reads_stands_before_the_annex(shown: Shown) -> None:
    """Verdict, attenuation, machine, levels before and after, limits and warnings; all tables of parameters after."""
    seen = html.fromstring(render(report_page(shown)))
    ids = seen.xpath("//section/@id")
    front, rest = ids[: ids.index("annex")], ids[ids.index("annex") + 1 :]
    assert front == ["headline", "machine", "classes", "nearest", "warnings"]
    assert {"runs", "inputs", "tables", "faults", "modes"} <= set(rest)
    assert seen.xpath('//div[@class="annexed"]//section/@id') == ["annex", *rest]


def test_several_scenarios_are_told_apart_in_front(shown: Shown) -> None:
    active, passive = shown.results.values()
    other = replace(passive, scenario=passive.scenario.model_copy(update={"name": "another"}))
    both = Shown.of({"small": active, "another": other})
    assert runs_beside(both) is None
    assert runs_first(both) is not None
    assert runs_first(shown) is None


def test_what_was_set_otherwise_stands_in_front(shown: Shown) -> None:
    """Of the parameters those that are not the preset's, with their units, and no other."""
    told = dict(machine(shown).facts)
    assert not [name for name in told if name.startswith("set")]
    heavy = shown.scenario.varied({"machine.mass": 4200.0, "actuators.isolator.flow_gain": 1.85e-6})
    run = Shown.of({"heavy": replace(shown.first, scenario=heavy)})
    told = dict(machine(run).facts)
    assert told["set, machine"] == "mass 4200 kg"
    assert told["set, actuator isolator"].startswith("flow_gain 1.85 × 10⁻⁶ m³/s/mA")
