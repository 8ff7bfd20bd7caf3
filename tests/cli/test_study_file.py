"""Studies of many designs on the command line, from the file to the scenario that is run."""

import json
from pathlib import Path

import pandas as pd
import pytest
from harness import Cli

from ehamj.scenario.load import load_scenario

FILE = """
title = "A small study"
question = "Which piston?"
scenario = "single-actuator"
best = 1

[vary]
"actuators.isolator.piston_area" = { low = 0.02, high = 0.05 }
"machine.mass" = { tolerance = 0.1 }

[plan]
kind = "latin-hypercube"
number = 12

[named.larger]
"actuators.isolator.piston_area" = 0.06

[objectives]
"actuator.isolator.hydraulic_frequency" = "highest"

[limits]
"actuator.isolator.velocity_gain" = { at_least = 5e-5 }

[tolerances]
number = 8
vary."actuators.isolator.piston_area" = { tolerance = 0.02 }
"""


@pytest.fixture
def file(tmp_path: Path) -> str:
    path = tmp_path / "small.toml"
    path.write_text(FILE, encoding="utf-8")
    return str(path)


def designs(folder: str) -> pd.DataFrame:
    return pd.read_parquet(Path(folder) / "designs.parquet").drop(columns="seconds [s]")


def test_a_study_is_done_and_its_best_design_runs(cli: Cli, file: str, tmp_path: Path) -> None:
    told = cli("study", file, "--out", "found", "--threads", "1", "--set", "plan.number=10", "--json").json
    assert (told["study"], told["folder"], told["complete"]) == ("small", "found", True)
    best = told["numbers"]["best"][0]
    assert best["values"]["actuators.isolator.piston_area"] > 0.045  # ω_h rises with the area
    assert told["settings"]["plan"]["number"] == 10
    table = designs("found")
    assert table["stage"].value_counts().to_dict() == {"tolerance": 16, "search": 10, "named": 2}
    assert "actuators.isolator.piston_area [m²]" in table.columns
    found = load_scenario(tmp_path / "found" / "best-1.toml")
    assert found.actuators["isolator"].piston_area == best["values"]["actuators.isolator.piston_area"]
    files = {path.name for path in (tmp_path / "found").iterdir()}
    assert files >= {"study.html", "study.json", "study.toml", "scenario.toml", "designs.csv", "designs.sqlite"}
    page = (tmp_path / "found" / "study.html").read_text("utf-8")
    for text in ("A small study", "best-1.toml", "designs.parquet", "Yield around design", "figure-scatter-matrix"):
        assert text in page
    assert json.loads((tmp_path / "found" / "study.json").read_text("utf-8"))["numbers"] == told["numbers"]

    # The folder's own file does it again, and it can be gone on with.
    again = cli("study", "found", "--out", "again", "--json").json
    pd.testing.assert_frame_equal(designs("again"), table)
    assert again["numbers"] == told["numbers"]
    resumed = cli("study", "again", "--resume", "--json").json
    assert (resumed["folder"], resumed["numbers"]) == ("again", told["numbers"])

    assert "exists already" in cli("study", file, "--out", "found").message


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--set", "plan.numbr=3"], "did you mean 'number'?"),
        (["--set", 'objectives={"actuator.isolator.speed"="highest"}'], "no such merit"),
        (["--set", "budget.designs=10"], "budget.designs = 10: the study makes 30 designs"),
        (["--set", 'vary={"machine.mas"={tolerance=0.1}}'], "mas"),
        (["--resume"], "--resume: needs --out"),
        (["--resume", "--out", "nowhere"], "nowhere"),
        (["--threads", "0"], "must be at least 1"),
        (["--threads", "1", "--processes", "2"], "name one"),
        (["--scheduler", "somewhere"], "scheduler 'somewhere'"),
    ],
)
def test_what_cannot_be_done_is_refused_and_nothing_written(
    cli: Cli, file: str, arguments: list[str], words: str, tmp_path: Path
) -> None:
    assert words in cli("study", file, *arguments).message
    left = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert [path.name for path in left] == ["small.toml"]


def test_studies_that_ship_are_listed_beside_the_questions(cli: Cli) -> None:
    listed = {one["name"]: one["question"] for one in cli("study", "--json").json["studies"]}
    assert "actuator" in listed["paper-sensitivity"]
    assert "wave" in listed["waves"]


def test_the_schema_of_a_study_file_is_json(cli: Cli) -> None:
    said = json.loads(cli("schema", "study").out)
    assert {"vary", "plan", "objectives", "limits"} <= set(said["properties"])
    assert "duration" in json.loads(cli("schema").out)["properties"]


def test_how_far_it_is_is_told_now_and_then(cli: Cli, file: str) -> None:
    said = cli("study", file, "--set", "tolerances.number=1")
    assert said.err.startswith("study\n")
    assert "page, tables and figures: runs/0001/study.html" in said.out
