"""Every level on the page has its statistic beside it, and older results, which have but one, still have a page."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml import html

from ehamj.estimate.statistics import SHORT, WORDS
from ehamj.judge.summary import Summary
from ehamj.pages import render
from ehamj.replay import write_replay
from ehamj.report import report_page, write_report
from ehamj.report.shown import Shown
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

STRUCK = {
    "kind": "sum",
    "parts": [
        {"kind": "shock", "dof": "z", "velocity": 2e-3, "pulse_time": 0.02, "begin": 6.0},
        {"kind": "broadband", "level": "VC-D"},
    ],
}


def run(**criteria: Any) -> Result:
    return simulate(parse_scenario({"duration": 12.0, "plates": "tied", "ground": STRUCK, "criteria": criteria}))


@pytest.fixture(scope="module")
def result() -> Result:
    return run()


def rows_of(seen: Any, title: str) -> list[list[str]]:
    (table,) = seen.xpath(f'//table[@aria-label="{title}"]')
    return [[" ".join(c.text_content().split()) for c in row.xpath("./th|./td")] for row in table.xpath(".//tr")]


def number(text: str) -> float:
    return 0.0 if text.startswith("<") else float(text)


def test_the_table_of_statistics_is_the_summarys(result: Result) -> None:
    seen = html.fromstring(render(report_page({"run": result})))
    rows = rows_of(seen, "Vertical velocity by statistic [µm/s]")
    summary = result.summary
    band = summary.criterion.machine.z.deciding_band
    assert band is not None
    begin = rows.index([f"in the band at {band} Hz, averaging 1 s"])
    found = {row[0]: [number(cell) for cell in row[1:]] for row in rows[begin + 1 : begin + len(WORDS)]}
    for name in WORDS:
        if name != "peak":
            places = (summary.in_bands("velocity", name)[place]["z"][band] for place in ("floor", "machine"))
            # Three digits, and nothing below a thousandth of a µm/s.
            assert found[WORDS[name]] == pytest.approx([1e6 * (level or 0.0) for level in places], rel=6e-3, abs=1e-3)
    assert rows[-1][0] == WORDS["peak"]
    peak = float(np.abs(result.dataset.ground_velocity.values[:, :, 2]).max())
    assert number(rows[-1][1]) == pytest.approx(1e6 * peak, rel=6e-3)


@pytest.mark.parametrize("statistic", ["rms", "max_1s", "l10"])
def test_the_statistic_that_judges_stands_at_axis_table_and_verdict(result: Result, statistic: Any) -> None:
    judged = result if statistic == "rms" else run(statistic=statistic, norms=["vc"])
    page = report_page({"run": judged})
    (picture,) = [picture for picture in page.pictures if picture.name == "criterion-z"]
    assert picture.figure.axes[0].get_ylabel() == f"velocity, {SHORT[statistic]} [µm/s]"
    levels = judged.summary.in_bands("velocity", statistic)["machine"]["z"].values()
    color = Shown.of({"run": judged}).colors["run"]
    (own,) = [line for line in picture.figure.axes[0].lines if line.get_color() == color]
    np.testing.assert_allclose(own.get_ydata(), [np.nan if v in (None, 0.0) else 1e6 * v for v in levels])
    seen = html.fromstring(render(page))
    (title,) = seen.xpath('//section[@id="classes"]//table/@aria-label')
    rows = rows_of(seen, title)
    assert rows[1] == [f"by {WORDS[statistic]}"]
    assert ([f"by {WORDS['max_1s']}"] in rows[2:]) == (statistic != "max_1s")
    said = seen.xpath('//*[@id="verdict"]')[0].text_content()
    assert f"by VC curves, constant acceleration from 4 to 8 Hz, {WORDS[statistic]}" in " ".join(said.split())


def test_a_transient_floor_is_told_of(result: Result) -> None:
    assert result.summary.floor_transient
    seen = html.fromstring(render(report_page({"run": result})))
    assert "the floor is transient" in seen.xpath('//*[@id="warnings"]')[0].text_content()


def test_an_older_result_has_page_and_replay(result: Result, tmp_path: Path) -> None:
    plain = result.summary.to_dict()
    for key in ("levels", "floor_transient", "transience", "statistic"):
        del plain[key]
    for key in ("max_1s", "decisive", "title"):
        del plain["criterion"][key]
    del plain["analysis"]["usable_from_hz"]
    judged = [plain["criterion"], *(by["places"] for by in plain["criteria"].values())]
    for place in (place for places in judged for place in places.values() if "z" in place):
        for axis in "xyz":
            for key in ("statistic", "bands", "peak", "peak_hz"):
                place[axis].pop(key, None)
    older = replace(result, summary=Summary.read(plain, "older"))
    write_report(tmp_path, {"run": older})
    seen = html.fromstring((tmp_path / "report.html").read_text(encoding="utf-8"))
    lines = [" ".join(line.text_content().split()) for line in seen.xpath('//*[@id="verdict"]/li[not(@class="worse")]')]
    said = plain["criterion"]["verdict"]
    for (name, words), line in zip(said.items(), lines, strict=True):
        assert line.startswith(f"{name} {words}, of the centre of gravity alone")
    assert not seen.xpath('//table[@aria-label="Vertical velocity by statistic [µm/s]"]')
    write_replay(tmp_path / "replay.rrd", {"run": older})
