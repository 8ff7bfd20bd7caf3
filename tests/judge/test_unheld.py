"""A class that rests on some of a norm's bands alone is no verdict, and is not called one anywhere."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml import html

from ehamj.pages import render
from ehamj.report import report_page
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario


def recorded(folder: Path, rate: float, **treatment: Any) -> Result:
    """A floor of 5 Hz, 10 µm/s, recorded at a rate."""
    time = np.arange(0.0, 14.0, 1.0 / rate)
    rows = [f"{t:.6f},{1e-5 * np.sin(2 * np.pi * 5.0 * t):.9g}" for t in time]
    (folder / "floor.csv").write_text("time [s],z [m/s]\n" + "\n".join(rows) + "\n", encoding="utf-8")
    ground = {"kind": "record", "file": str(folder / "floor.csv"), "start": 1.0, **treatment}
    return simulate(parse_scenario({"duration": 12.0, "plates": "tied", "ground": ground}))


def unheld(result: Result) -> list[str]:
    return [text for text in result.summary.warnings if text.startswith("no verdict")]


def test_a_record_that_ends_early_gives_no_verdict(tmp_path: Path) -> None:
    """Sampled at 50 Hz it holds nothing above 25 Hz: by what it holds, 7.1 of 10 µm/s at 5 Hz, it would meet VC-D."""
    result = recorded(tmp_path, 50.0)
    criterion = result.summary.criterion
    assert (criterion.machine.z.met, criterion.machine.z.decided) == ("VC-D", False)
    assert criterion.verdict.vertical.startswith("floor at best VC-D, machine at best VC-D ")
    # Of 4 to 80 Hz, 14 bands, those from 20 Hz on: the upper edge of 20 Hz, 22.4 Hz, lies above what is known.
    assert criterion.verdict.vertical.endswith(": 7 of 14 bands undecided")
    (told,) = unheld(result)
    usable = result.summary.analysis.usable_to_hz
    assert usable is not None
    assert f"known up to {usable:.3g} Hz only" in told
    assert "to 100 Hz (vc, nist-a, iso-2631-2)" in told
    seen = html.fromstring(render(report_page({"run": result})))
    (cell, *_) = seen.xpath('//section[@id="classes"]//tbody/tr/td/text()')
    assert cell.startswith("at best VC-D (")
    assert "machine at best VC-D" in seen.xpath('//*[@id="verdict"]')[0].text_content()


def test_a_high_pass_takes_the_bands_below_it(tmp_path: Path) -> None:
    """A high-pass at 3 Hz leaves 0.9 of the motion at 3·9^(1/8) = 3.95 Hz: in the band at 5 Hz, not in that at 4 Hz."""
    result = recorded(tmp_path, 500.0, highpass=3.0)
    levels = result.summary.third_octave_velocity["machine"]["z"]
    assert (levels["4"], levels["5"]) == (None, pytest.approx(1e-5 / np.sqrt(2.0) / (1.0 + 0.6**8), rel=0.01))
    (told,) = unheld(result)
    assert "known from 3.95 Hz on only, and a verdict needs the bands from 1 to 4 Hz (vc, nist-a, iso-2631-2)" in told
    assert result.summary.criterion.machine.z.undecided == ("4",)


def test_a_record_that_holds_every_band_gives_a_verdict(tmp_path: Path) -> None:
    result = recorded(tmp_path, 500.0)
    assert unheld(result) == []
    assert result.summary.criterion.machine.z.decided
    assert "at best" not in result.summary.criterion.verdict.vertical


def test_a_class_that_is_missed_anyway_needs_no_further_band(tmp_path: Path) -> None:
    """Above the coarsest class nothing else can change the verdict."""
    result = recorded(tmp_path, 50.0, scale=300.0)
    words = result.summary.criterion.verdict
    assert words.vertical.startswith("floor worse than workshop, machine worse than workshop")
    assert words.horizontal.startswith("floor at rest as far as known, ")
    (told,) = unheld(result)
    assert told.startswith("no verdict along x, y: ")
