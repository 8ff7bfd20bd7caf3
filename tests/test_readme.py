"""What the README shows of Python runs as it stands, and gives what it says."""

from pathlib import Path
from typing import Any

import pytest
from blocks import blocks

import ehamj
from ehamj.campaign.file import load_study
from ehamj.campaign.staged import stages_of
from ehamj.scenario.load import load_scenario

README = (Path(__file__).parents[1] / "README.md").read_text("utf-8")


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """The folder where all blocks ran one after another, and what they left."""
    folder, left = tmp_path_factory.mktemp("reader"), dict[str, Any]()
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for block in blocks(README, "python"):
            exec(block.body, left)
    return folder, left


def test_a_result_is_saved_whole(ran: tuple[Path, dict[str, Any]]) -> None:
    folder, left = ran
    saved = {path.name for path in (folder / "runs/mine").iterdir()}
    assert saved >= {"report.html", "replay.rrd", "result.nc", "summary.json", "scenario.toml", "controller.json"}
    assert ehamj.load_result(folder / "runs/mine").summary == left["result"].summary


def test_a_law_held_isolates_less_than_on_its_machine_and_more_than_none(ran: tuple[Path, dict[str, Any]]) -> None:
    designed, held, passive = ran[1]["levels"]
    assert designed > held + 3.0 > passive + 20.0


def test_the_example_law_isolates_as_the_comment_says(ran: tuple[Path, dict[str, Any]]) -> None:
    quieter = ran[1]["quieter"].summary
    assert quieter["attenuation_db"]["z"]["20"] == pytest.approx(15.0, abs=1.0)
    assert not any(share for by in quieter["saturation"].values() for share in by.values())
    assert ran[1]["same"].summary.margins is None  # it only measures the ground: there is no loop


def test_the_compiled_law_is_the_same_one(ran: tuple[Path, dict[str, Any]]) -> None:
    python, compiled = (ran[1][name].summary["attenuation_db"]["z"]["20"] for name in ("quieter", "same"))
    assert compiled == pytest.approx(python, abs=1.0)  # it takes over 0.2 s later
    law = ehamj.load_controller(ran[0] / "law.json")
    assert law.inputs == ran[1]["law"].inputs


def test_the_scenario_of_the_readme_is_read(tmp_path: Path) -> None:
    (block,) = (one.body for one in blocks(README, "toml") if "[machine]" in one.body)
    (tmp_path / "mine.toml").write_text(block, encoding="utf-8")
    scenario = load_scenario(tmp_path / "mine.toml")
    assert (scenario.machine.mass, scenario.nominal.machine.mass) == (5200.0, 5000.0)


def test_the_study_of_the_readme_is_one(
    ran: tuple[Path, dict[str, Any]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (block,) = (one.body for one in blocks(README, "toml") if "[plan]" in one.body)
    (tmp_path / "stiffer.toml").write_text(block, encoding="utf-8")
    file = load_study(tmp_path / "stiffer.toml")
    assert sum(stage.count() for stage in stages_of(file)) == 1 + 64 + 4 * 50
    monkeypatch.chdir(ran[0])  # where its folder is
    oil = ran[1]["swept"].designs.query("stage == 'search'")["own.oil"]
    assert oil.to_list() == pytest.approx([4 * 0.539 * factor for factor in (0.8, 0.9, 1.0, 1.1, 1.2)])
