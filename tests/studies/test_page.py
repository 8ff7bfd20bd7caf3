"""A study's folder, and the command that writes it."""

import csv
import json
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from harness import Cli

from ehamj.labels import labelled
from ehamj.plots.charts import Line, lines_chart
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.studies.outcome import Drawing, Outcome
from ehamj.studies.page import flat_table, write_outcome

TABLE = xr.Dataset(
    {"gain": labelled(("case", "frequency"), np.array([[1.0, np.nan], [0.5, 0.25]]), "m/V", "gain")},
    {
        "case": labelled(("case",), ["a", "b"], "", "case"),
        "frequency": labelled(("frequency",), [1.0, 2.0], "Hz", "frequency"),
    },
    {"title": "gains"},
)
OUTCOME = Outcome(
    title="A <study>",
    question="Is 1 < 2?",
    answers=("It is & stays so.",),
    tables={"gains": TABLE},
    drawings={
        "chart": Drawing("What it says.", lambda: lines_chart("t", "x [m]", {"y [m]": [Line("l", [0, 1], [0, 1])]}))
    },
    numbers={"one": 1.0},
)


def test_a_table_is_flat_with_units_and_empty_cells() -> None:
    head, rows = flat_table(TABLE)
    assert head == ["case", "frequency [Hz]", "gain [m/V]"]
    assert rows == [["a", 1.0, 1.0], ["a", 2.0, ""], ["b", 1.0, 0.5], ["b", 2.0, 0.25]]


def test_everything_is_written_and_reads_back(tmp_path: Path) -> None:
    scenario = parse_scenario({"name": "a machine"})
    write_outcome(tmp_path, "gains", OUTCOME, scenario)
    files = {path.name for path in tmp_path.iterdir()}
    assert files == {"study.html", "study.json", "scenario.toml", "gains.nc", "gains.csv", "chart.svg"}
    with xr.open_dataset(tmp_path / "gains.nc", engine="h5netcdf") as stored:
        xr.testing.assert_identical(stored.load(), TABLE)
    with (tmp_path / "gains.csv").open(encoding="utf-8", newline="") as file:
        assert list(csv.reader(file))[2] == ["a", "2.0", ""]
    ET.parse(tmp_path / "chart.svg")
    assert json.loads((tmp_path / "study.json").read_text("utf-8"))["numbers"] == {"one": 1.0}
    assert load_scenario(tmp_path / "scenario.toml") == scenario
    page = (tmp_path / "study.html").read_text("utf-8")
    for text in ("A &lt;study&gt;", "It is &amp; stays so.", "gain [m/V]", "What it says.", "<svg", "gains.csv"):
        assert text in page
    assert "<study>" not in page.replace("A &lt;study&gt;", "")


def test_the_command_lists_the_studies(cli: Cli) -> None:
    """Each with a question of its own; the names are those that a wrong one is answered with."""
    listed = cli("study", "--json").json["studies"]
    questions = {one["name"]: one["question"] for one in listed}
    assert "wave" in questions["waves"]
    assert len(set(questions.values())) == len(questions)
    refused = cli("study", "nothing").message
    assert refused.rpartition("must be one of ")[2].split(", ") == list(questions)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nothing"], "must be one of"),
        (["waves", "no-such.toml"], "no-such.toml"),
        (["waves", "--set", "machine.mass=-1"], "mass"),
    ],
)
def test_bad_input_writes_nothing(cli: Cli, arguments: list[str], words: str, tmp_path: Path) -> None:
    assert words in cli("study", *arguments).message
    assert list(tmp_path.iterdir()) == []


def test_the_command_writes_a_study(cli: Cli, tmp_path: Path) -> None:
    folder = tmp_path / "found"
    told = cli("study", "waves", "--out", str(folder), "--json", "--set", "plates=tied").json
    assert (told["study"], told["folder"]) == ("waves", str(folder))
    assert (folder / "study.html").is_file()
    assert (folder / "map-valves-held.csv").is_file()
    assert told["numbers"]["worst"]["valves held"]["rocking"] == pytest.approx(
        told["numbers"]["simulated_rocking"], rel=1e-3
    )
