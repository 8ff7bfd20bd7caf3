"""`ehamj design`: what it prints and writes, that what it writes runs, and what it refuses."""

import json
import re
from functools import partial
from pathlib import Path

import pytest

from ehamj.cli import frame
from ehamj.run.simulate import simulate
from ehamj.scenario.load import load_scenario

QUICK = ("--set", "plates='tied'", "--set", "compare=[]", "--set", "duration=5", "--set", "ground={kind='rest'}")
FILES = {"design.json", "design.html", "controller.json", "scenario.toml"}


@pytest.fixture
def cli(cli):  # type: ignore[no-untyped-def]
    """The command in the common harness."""
    return partial(cli, "design")


def test_a_design_is_written_told_and_runs(cli) -> None:  # type: ignore[no-untyped-def]
    code, out, _ = cli("benchmark", "--architecture", "modal", *QUICK, "--out", "made", "--json")
    assert code == 0
    told = json.loads(out)
    assert told["meets"] is True
    assert told["gain_margin_db"] >= 6.0
    assert told["phase_margin_deg"] >= 45.0
    assert told["disk_margin"] >= 0.5
    assert any("Leaves the margins" in answer for answer in told["answers"])
    folder = Path("made")
    assert {path.name for path in folder.iterdir() if path.is_file()} >= FILES
    page = (folder / "design.html").read_text(encoding="utf-8")
    text = " ".join(re.sub(r"<(style|svg).*?</\1>|<[^>]+>", " ", page, flags=re.DOTALL).split())
    for words in ("4056 kg", "0, 0, 0.6 m", "bar, tank 0 bar", "318 cm²", "rest; 5 s", "modal:"):
        assert words in text
    assert not re.search(r"\d[eE][-+−]?\d|\binf\b|\bnan\b", text)
    law = json.loads((folder / "controller.json").read_text())
    assert law["period_s"] == 1e-4
    scenario = load_scenario(folder / "scenario.toml", ["duration=0.1"])
    assert scenario.control.kind == "modal"
    assert simulate(scenario).summary["margins"]["gain_db"] >= 6.0
    by_file = load_scenario(
        folder / "scenario.toml", ["duration=0.1", "control={kind='law', file='made/controller.json'}"]
    )
    assert simulate(by_file).summary["margins"]["gain_db"] >= 6.0
    # A second time into the same folder it wants to be told so.
    code, out, err = cli("benchmark", "--architecture", "feedforward", *QUICK, "--out", "made")
    assert (code, out) == (2, "")
    assert "--overwrite" in err


def test_feedforward_has_no_margins_to_leave(cli) -> None:  # type: ignore[no-untyped-def]
    code, out, _ = cli("benchmark", "--architecture", "feedforward", *QUICK, "--out", "made", "--json")
    assert code == 0
    assert json.loads(out)["gain_margin_db"] is None
    assert any("there is no loop" in answer for answer in json.loads(out)["answers"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("--architecture", "pid"),
            "--architecture 'pid': must be one of feedforward, stroke-servo",
        ),
        (("--architecture", "adaptive"), "adaptive must be stated whole, in [control]"),
        (("--phase-margin", "95"), "--phase-margin 95: must be from 0 to 89"),
        (("--architecture", "modal", "--gain-margin", "45"), "no crossing of the loop"),
    ],
    ids=["architecture", "lines", "range", "impossible"],
)
def test_what_cannot_be_designed_is_refused_and_nothing_written(cli, arguments, message) -> None:  # type: ignore[no-untyped-def]
    code, out, err = cli("benchmark", *QUICK, *arguments, "--out", "made")
    assert (code, out) == (2, "")
    assert message in " ".join(err.split())
    assert not Path("made").exists()


def test_a_scenario_keeps_its_own_architecture_and_the_machine_that_it_is_held_for(  # type: ignore[no-untyped-def]
    cli, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(frame.out, "_width", 80)
    control = "control={kind='stroke-servo', delay=1.5e-4, designed_for={machine={mass=4000.0}}}"
    held = ("--set", control, "--set", "machine.mass=5200")
    code, out, _ = cli("benchmark", *QUICK, *held, "--set", "output.nichols=true", "--out", "made")
    assert code == 0
    tables, _, _ = out.partition("\n- ")
    assert max(map(len, tables.splitlines())) <= 80
    assert "the machine it runs on" in tables
    assert {path.name for path in Path("made").glob("*.svg")} >= {"bode.svg", "nyquist.svg", "nichols.svg"}
    written = load_scenario(Path("made/scenario.toml"))
    assert written.control.kind == "stroke-servo"
    assert (written.machine.mass, written.nominal.machine.mass) == (5200.0, 4000.0)
    assert written.controller().to_dict()["A"] == json.loads(Path("made/controller.json").read_text())["A"]
