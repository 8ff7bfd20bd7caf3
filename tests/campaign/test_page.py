"""A problem whose front is known, through search, store and page; a study that goes on where it was stopped."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml import html

import ehamj
from ehamj.campaign.run import Study
from ehamj.scenario.model import Scenario


def first(scenario: Scenario) -> float:
    """ZDT1 (Zitzler, Deb and Thiele, 2000), of two variables: the mass and the height of the CG."""
    return (scenario.machine.mass - 3000.0) / 2000.0


def second(scenario: Scenario) -> float:
    g = 1.0 + 9.0 * (scenario.machine.cg[2] - 0.5) / 0.4
    return g * (1.0 - float(np.sqrt(max(first(scenario), 0.0) / g)))


ZDT1: dict[str, Any] = {
    "title": "ZDT1",
    "question": "Where is the front?",
    "scenario": "recorded",
    "set": {"control": {"kind": "passive"}, "compare": []},
    "vary": {"machine.mass": {"low": 3000.0, "high": 5000.0}, "machine.cg.2": {"low": 0.5, "high": 0.9}},
    "plan": {"kind": "optimise", "population": 16, "generations": 10},
    "objectives": {"own.first": "lowest", "own.second": "lowest"},
}


@pytest.fixture(scope="module")
def zdt1(tmp_path_factory: pytest.TempPathFactory) -> Study:
    folder: Path = tmp_path_factory.mktemp("study") / "zdt1"
    return ehamj.run_study(ZDT1, folder, functions={"first": first, "second": second})


def test_the_front_of_a_known_problem_is_found_and_shown(zdt1: Any) -> None:
    """Its true front is f₂ = 1 − √f₁."""
    numbers, designs = zdt1.outcome.numbers, zdt1.designs
    found = designs.loc[numbers["front"], ["own.first", "own.second"]].to_numpy(float)
    assert len(found) >= 8
    assert np.median(found[:, 1] - (1.0 - np.sqrt(found[:, 0]))) < 0.1
    page = html.fromstring((zdt1.folder / "study.html").read_text("utf-8"))
    figures = {figure.get("id") for figure in page.xpath("//figure")}
    assert figures == {f"figure-{name}" for name in zdt1.outcome.drawings}
    drawn = " ".join(page.xpath('//figure[@id="figure-pareto-front"]//text()'))
    assert str(numbers["best"][0]["number"]) in drawn


def test_every_best_design_is_a_scenario_with_its_values(zdt1: Any) -> None:
    for place, row in enumerate(zdt1.outcome.numbers["best"], 1):
        scenario = ehamj.load_scenario(zdt1.folder / f"best-{place}.toml")
        assert scenario.machine.mass == row["values"]["machine.mass"]
        assert first(scenario) == pytest.approx(row["merits"]["own.first"])
