"""A scenario that is judged by a file beside it: from anywhere, by any name, and on every page."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from harness import Cli
from lxml import html

from ehamj.replay import write_replay
from ehamj.report import write_report
from ehamj.result import Result, load_result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario

NAME = "my limits/spindle <nose> & table, 100 %.csv"
LIMITS = "# title: spindle <nose>\nband [Hz],rough [um/s],fine cut [um/s]\n8,100,50\n10,20,10\n12.5,20,10\n"
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


def test_report_and_replay_take_any_name_and_outlive_the_file(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    out.mkdir()
    simulate(load_scenario(folder / "machine.toml")).save(out)
    for there in (True, False):
        if not there:
            shutil.rmtree(folder / "my limits")
        result = load_result(out)
        write_report(out, {"run": result})
        seen = html.fromstring((out / "report.html").read_text(encoding="utf-8"))
        assert seen.xpath('//*[@id="classes"]//h3')[0].text_content() == "Class met: spindle <nose>"
        assert any("rough" in cell.text_content() for cell in seen.xpath('//section[@id="classes"]//tbody//td'))
        drawn = [name for name in seen.xpath("//figure/@id") if "spindle" in name]
        assert len(drawn) == (1 if there else 0)
        assert not any(
            set(name) - set("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_") for name in drawn
        )
    write_replay(out / "replay.rrd", {"run": replace(result)})


def test_a_file_that_cannot_be_used_is_refused_before_anything_runs(folder: Path, cli: Cli, tmp_path: Path) -> None:
    (folder / NAME).write_text("band [Hz],rough [kg]\n8,100\n", encoding="utf-8")
    said = cli("run", str(folder / "machine.toml"), "--out", str(tmp_path / "never"))
    assert said.message.startswith(f"criteria.norms = {Path(NAME).name!r}: column 'rough': 'kg' is not a unit")
    assert not (tmp_path / "never").exists()
