"""A scenario that is judged by a file beside it: from anywhere, by any name, and on every page."""

import shutil
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from harness import Cli
from lxml import html

from ehamj.criteria.curves import CANDIDATES
from ehamj.errors import InputError
from ehamj.replay import write_replay
from ehamj.report import Shown, write_report
from ehamj.result import Result, load_result
from ehamj.run.drive import drive
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario

NAME = "my limits/spindle <nose> & table, 100 %.csv"
LIMITS = "# title: spindle <nose>\nband [Hz],rough [um/s],fine cut [um/s]\n8,100,50\n10,20,10\n12.5,20,10\n"
PEAK = "# statistic: peak\nfrequency [Hz],rough [um/s],fine cut [um/s]\n8,100,50\n10,20,10\n"
SCENARIO = f"""
duration = 6.0
plates = "tied"
ground = {{kind = "sine", dof = "z", amplitude = 2.3e-7, frequency = 10.0}}
[criteria]
norms = ["{NAME}", "vc"]
"""
LEVEL = 2.3e-7 * 2 * np.pi * 10.0 / np.sqrt(2.0)
"""10.2 µm/s RMS."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "a" / "my limits").mkdir(parents=True)
    (tmp_path / "a" / NAME).write_text(LIMITS, encoding="utf-8")
    (tmp_path / "a" / "machine.toml").write_text(SCENARIO, encoding="utf-8")
    return tmp_path / "a"


def judged(result: Result) -> tuple[str | None, str | None, float | None]:
    verdict = result.summary.criterion.floor.z
    return verdict.met, verdict.next_class, verdict.excess_db


def test_the_file_gives_the_verdict_and_the_resolved_scenario_runs_again(folder: Path, tmp_path: Path) -> None:
    result = simulate(load_scenario(folder / "machine.toml"))
    met, missed, excess = judged(result)
    assert (met, missed) == ("rough", "fine cut")
    assert excess == pytest.approx(20 * np.log10(LEVEL / 10e-6), abs=0.01)
    assert list(result.summary.criteria) == [Path(NAME).name, "vc"]
    elsewhere = tmp_path / "b"
    elsewhere.mkdir()
    (elsewhere / "again.toml").write_text(result.scenario.to_toml(), encoding="utf-8")
    assert judged(simulate(load_scenario(elsewhere / "again.toml"))) == judged(result)


def test_report_and_replay_take_any_name(folder: Path, tmp_path: Path) -> None:
    result = simulate(load_scenario(folder / "machine.toml"))
    write_report(tmp_path, {"run": result})
    seen = html.fromstring((tmp_path / "report.html").read_text(encoding="utf-8"))
    assert seen.xpath('//*[@id="classes"]//h3')[0].text_content() == "Class met: spindle <nose>"
    assert any("rough" in cell.text_content() for cell in seen.xpath('//section[@id="classes"]//tbody//td'))
    (drawn,) = (name for name in seen.xpath("//figure/@id") if "spindle" in name)
    assert not set(drawn) - set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_")
    write_replay(tmp_path / "replay.rrd", {"run": replace(result)})


@pytest.mark.parametrize("text", [LIMITS, f"# statistic: l10\n{LIMITS}", PEAK], ids=["band", "l10", "peak"])
def test_a_result_holds_the_limits_that_judged_it(folder: Path, tmp_path: Path, text: str) -> None:
    """After the file has other limits, and after it is gone, the page's norm is the one of the verdict."""
    (folder / NAME).write_text(text, encoding="utf-8")
    scenario = load_scenario(folder / "machine.toml")
    before = scenario.criteria.norm(scenario.criteria.norms[0])
    simulate(scenario).write(tmp_path)
    for then in (text.replace("20,10", "2000,1000").replace("fine cut", "other"), None):
        if then is None:
            shutil.rmtree(folder / "my limits")
        else:
            (folder / NAME).write_text(then, encoding="utf-8")
        after = Shown.of({"run": load_result(tmp_path)}).norms[Path(NAME).name]
        assert (after.title, after.classes, after.note) == (before.title, before.classes, before.note)
        for name, axis, band in product(before.classes, "xyz", (*CANDIDATES, None)):
            assert after.limit(name, axis, band) == before.limit(name, axis, band)


def test_a_run_is_judged_by_the_file_as_it_was_when_it_began(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What takes hours must not fail at its end because of a file that was there."""

    def gone(*arguments: Any) -> Any:
        shutil.rmtree(folder / "my limits")
        return drive(*arguments)

    monkeypatch.setattr("ehamj.run.simulate.drive", gone)
    assert judged(simulate(load_scenario(folder / "machine.toml")))[:2] == ("rough", "fine cut")


def test_limits_that_a_result_does_not_hold_are_not_guessed(folder: Path) -> None:
    result = simulate(load_scenario(folder / "machine.toml"))
    criteria = dict(result.summary.criteria)
    name = Path(NAME).name
    criteria[name] = criteria[name].model_copy(update={"own_limits": None})
    shown = Shown.of({"run": replace(result, summary=result.summary.model_copy(update={"criteria": criteria}))})
    with pytest.raises(InputError, match="does not hold the limits; run it again"):
        _ = shown.norms


def test_a_file_that_cannot_be_used_is_refused_before_anything_runs(folder: Path, cli: Cli, tmp_path: Path) -> None:
    (folder / NAME).write_text("band [Hz],rough [kg]\n8,100\n", encoding="utf-8")
    said = cli("run", str(folder / "machine.toml"), "--out", str(tmp_path / "never"))
    assert said.message.startswith(f"criteria.norms = {Path(NAME).name!r}: column 'rough': 'kg' is not a unit")
    assert not (tmp_path / "never").exists()
