"""What the page says of norms that limit peaks."""

import numpy as np
import pytest
from lxml import html

from ehamj.pages import render
from ehamj.report import report_page
from ehamj.report.shown import Shown
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

SHAKEN = {"kind": "sine", "dof": "z", "amplitude": 7e-3 / (2 * np.pi * 20.0), "frequency": 20.0, "fade_in": 0.5}


@pytest.fixture(scope="module")
def result() -> Result:
    """A floor of 7 mm/s at 20 Hz, where dwellings have a limit of 7.5 mm/s and sensitive buildings one of 4.25."""
    criteria = {"norms": ["din-4150-3", "din-4150-3-floors"]}
    return simulate(parse_scenario({"duration": 1.0, "plates": "tied", "ground": SHAKEN, "criteria": criteria}))


def test_peak_and_frequency_stand_in_the_tables(result: Result) -> None:
    seen = html.fromstring(render(report_page({"run": result})))
    assert "by peak of the whole history" in seen.xpath('//section[@id="classes"]//tbody/tr[1]')[0].text_content()
    classes = seen.xpath('//section[@id="classes"]//tbody/tr[2]/td/text()')
    assert classes[0].startswith("dwelling (0.6 dB, peak 7.0")  # 20 lg(7.5/7)
    assert classes[0].endswith(" mm/s at 20.0 Hz)")
    rows = seen.xpath('//table[@aria-label="Criteria at every place"]//tr')
    cells = [[" ".join(cell.text_content().split()) for cell in row.xpath("./th|./td")] for row in rows]
    floors = cells[[row[0] for row in cells].index("DIN 4150-3, floors") + 1]
    assert floors[1] == "sensitive building (9.1 dB, peak 7.00 mm/s)"  # 20 lg(20/7); no frequency, which does not count


def test_the_figure_shows_the_swing_that_decides_against_every_line(result: Result) -> None:
    pictures = {picture.name: picture for picture in report_page({"run": result}).pictures}
    assert not any("floors" in name for name in pictures)  # one number at all frequencies: the table says it
    (axes,) = pictures["criterion-din-4150-3-z"].figure.axes
    verdict = result.summary.criteria["din-4150-3"].places["machine"].z
    (point,) = [line for line in axes.lines if line.get_color() == Shown.of({"run": result}).colors["run"]]
    assert point.get_xydata().tolist() == [[verdict.peak_hz, pytest.approx(1e3 * verdict.peak)]]
    (dwelling,) = [line for line in axes.lines if line.get_label() == "dwelling"]
    limit = np.interp(20.0, *dwelling.get_data())
    # The line has 200 points from 1 to 200 Hz.
    assert limit == pytest.approx(7.5, rel=1e-3)
    assert verdict.margin_db == pytest.approx(20 * np.log10(limit / (1e3 * verdict.peak)), abs=0.02)
