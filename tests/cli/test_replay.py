"""`ehamj replay` opens the recording that is there, and rebuilds it only when asked, then as the run built it."""

from pathlib import Path

import pytest
from harness import Cli
from rerun.chunk import RrdReader

RUN = (
    "run",
    "workshop",
    "--no-report",
    "--set",
    "duration=0.5",
    "--set",
    "plates=tied",
    "--set",
    "compare=['passive']",
)


def shown_in(recording: Path) -> set[str]:
    """Labels of the machines in a recording: the first part of the paths below which a world stands."""
    paths = (str(chunk.entity_path) for chunk in RrdReader(recording).stream())
    return {path.split("/")[1].replace("\\", "") for path in paths if "/world/" in path}


@pytest.fixture
def result(cli: Cli) -> Path:
    assert cli(*RUN, "--out", "a").code == 0
    return Path("a")


def test_it_leaves_the_recording_that_is_there(cli: Cli, result: Path) -> None:
    both = shown_in(result / "replay.rrd")
    assert both == {"feedforward", "passive"}
    before = (result / "replay.rrd").read_bytes()
    said = cli("replay", "a", "--json")
    assert (said.code, said.json) == (0, {"replay": "a/replay.rrd", "opened": False, "built": False})
    assert (result / "replay.rrd").read_bytes() == before
    text = cli("replay", "a").out
    assert "a/replay.rrd (as it is" in text
    assert "no screen here; open it with: rerun a/replay.rrd" in text


def test_rebuilt_it_has_the_variants_that_the_run_had(cli: Cli, result: Path) -> None:
    before = shown_in(result / "replay.rrd")
    (result / "replay.rrd").write_bytes(b"damaged")
    damaged = cli("replay", "a")
    assert damaged.code == 2
    assert "--rebuild builds it anew" in damaged.message
    assert cli("replay", "a", "--rebuild", "--json").json["built"]
    assert shown_in(result / "replay.rrd") == before


def test_a_comparison_stands_beside_and_touches_no_recording(cli: Cli, result: Path) -> None:
    before = (result / "replay.rrd").read_bytes()
    said = cli("replay", "a", "--compare", "a/passive", "--json")
    assert said.json == {"replay": "a/replay-compare.rrd", "opened": False, "built": True}
    assert (result / "replay.rrd").read_bytes() == before
    assert "leave one out" in cli("replay", "a", "--compare", "a/passive", "--rebuild").message


def test_a_result_without_a_recording_gets_one(cli: Cli) -> None:
    said = cli(*RUN, "--no-replay", "--out", "a")
    assert "replay: none; `ehamj replay a` writes it" in said.out
    assert cli("replay", "a", "--json").json["built"]
    assert shown_in(Path("a/replay.rrd")) == {"feedforward", "passive"}


def test_a_designed_scenario_writes_a_replay(cli: Cli) -> None:
    """As any other: nothing that a design leaves in the scenario switches it off."""
    assert cli("design", "vc-c-floor", "--architecture", "feedforward", "--out", "designed").code == 0
    short = ("--set", "duration=0.2", "--set", "compare=[]", "--no-report")
    assert cli("run", "designed/scenario.toml", *short, "--out", "run").code == 0
    assert Path("run/replay.rrd").is_file()
