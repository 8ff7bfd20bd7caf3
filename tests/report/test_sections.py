"""Every registered section of the report is made from a small run, by itself."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from lxml import html

from ehamj.pages import Page, Section, render, write_page
from ehamj.report import Shown
from ehamj.report.sections import SECTIONS
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


@pytest.mark.parametrize("section", SECTIONS, ids=lambda section: section.__name__)
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
