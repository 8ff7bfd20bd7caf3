"""Every registered command refuses bad input with exit code 2 and writes nothing, and says one JSON object."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import typer
from harness import Cli

import ehamj.bench.bench
from ehamj.cli import app

COMMANDS = sorted(typer.main.get_command(app).commands)  # type: ignore[attr-defined]
QUICK = ("--set", "plates='tied'", "--set", "compare=[]", "--set", "duration=0.01")
RUN = ("run", "benchmark", *QUICK, "--no-replay", "--no-report", "--out", "stored")

RIG = """
title = "Rig"
scenario = "benchmark"
parameters = { "actuators.isolator.membrane_stiffness" = {} }
fit = { starts = 1 }

[[test]]
name = "dial gauge"
kind = "static"
load = [{ force = [0.0, 0.0, 0.0] }, { force = [0.0, 0.0, -4000.0] }, { force = [0.0, 0.0, -8000.0] }]
reading = { "stroke front-left" = [0.0, -1.51e-6, -2.99e-6] }
"""
"""An identification that takes no time."""

REFUSED: dict[str, tuple[tuple[str, ...], str]] = {
    "run": (("no-such",), "'no-such'"),
    "scenarios": (("extra",), "unexpected extra argument"),
    "schema": (("extra",), "'extra' is not one of 'scenario', 'study', 'identify'"),
    "design": (("benchmark", "--phase-margin", "95"), "phase-margin 95"),
    "modes": (("benchmark", "--measured", "shaker"), "must be one of ring-down"),
    "paper": (("--out", "here/there"), "cannot be written"),
    "transmissibility": (("workshop", "--lines", "many"), "lines = 'many'"),
    "export": (("benchmark", "--mjcf", "model.txt"), "--mjcf 'model.txt': must end in .xml"),
    "study": (("nothing",), "study 'nothing': no study file; must be one of rocking"),
    "identify": (("nothing",), "identification 'nothing': no such file; the shipped ones are valve-sweep"),
    "merits": (("benchmark", "--find", "no such thing"), "is in no name of a merit"),
    "replay": (("here",), "result"),
    "report": (("here",), "result"),
    "bench": (("--repetitions", "0"), "--repetitions"),
    "statics": (("benchmark", "--shims", "flat"), "shims"),
    "verify": (("--out", "here/there.html"), "cannot be written"),
}
"""Arguments that each command refuses, beside a file called ``here``, and words of its message."""

SAID: dict[str, tuple[tuple[str, ...], set[str]]] = {
    "run": ((*RUN[1:-1], "made", "--json"), {"folder", "summary", "variants"}),
    "scenarios": (("--json",), {"scenarios"}),
    "schema": ((), {"$defs", "properties"}),
    "design": (("benchmark", "--architecture", "feedforward", *QUICK, "--json"), {"folder", "answers"}),
    "modes": (("benchmark", "--json"), {"modes", "bypassed"}),
    "paper": (("--json",), {"folder"}),
    "transmissibility": (
        ("benchmark", *QUICK[:4], "--dofs", "z", "--lines", "2", "--from", "20", "--to", "50", "--json"),
        {"folder", "attenuation_db"},
    ),
    "export": (("benchmark", "--mjcf", "model.xml", "--json"), {"files", "notes"}),
    "study": (("lateral", *QUICK[:4], "--points", "3", "--json"), {"study", "settings", "answers"}),
    "identify": (("rig.toml", "--json"), {"folder", "values", "tests"}),
    "merits": (("benchmark", *QUICK[:4], "--json"), {"merits"}),
    "replay": (("stored", "--json"), {"replay", "opened"}),
    "report": (("stored", "--json"), {"report", "results"}),
    "bench": (("--json",), {"ratio", "how_to_read"}),
    "statics": (("benchmark", "--shims", "level", "--json"), {"mounts", "shims"}),
    "verify": (("--json",), {"cases"}),
}
"""Arguments with which each command says JSON, and keys that it holds."""


def test_every_command_stands_in_both_lists() -> None:
    assert sorted(REFUSED) == COMMANDS
    assert sorted(SAID) == COMMANDS


@pytest.mark.parametrize("command", COMMANDS)
def test_a_refused_input_has_one_message_and_leaves_nothing(cli: Cli, command: str) -> None:
    Path("here").write_text("mine")
    arguments, words = REFUSED[command]
    said = cli(command, *arguments)
    assert (said.code, said.out) == (2, "")
    assert words in " ".join(said.err.split())
    assert "Traceback" not in said.err
    assert [path.name for path in Path().rglob("*")] == ["here"]


@pytest.mark.parametrize("command", COMMANDS)
def test_json_is_all_that_a_command_says(cli: Cli, command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """What takes a minute, in rooms that have tests of their own, is found here at once."""
    monkeypatch.setattr("ehamj.paper.reproduction.reproduce", lambda: SimpleNamespace(to_dict=dict, table=()))
    for name in ("page.write_paper", "amplitude.amplitude_response", "amplitude.write_amplitude"):
        monkeypatch.setattr(f"ehamj.paper.{name}", lambda *_: None)
    monkeypatch.setattr(ehamj.bench.bench, "measured", lambda repetitions, *_: {"engines": {"ratio": 1.0}})
    monkeypatch.setattr(ehamj.bench.bench, "bench_tables", lambda _: [])
    monkeypatch.setattr("ehamj.verify.verify", lambda **_: ())
    if command in ("replay", "report"):
        assert cli(*RUN).code == 0
    Path("rig.toml").write_text(RIG)
    arguments, keys = SAID[command]
    said = cli(command, *arguments)
    assert said.code == 0, said.err
    assert set(said.json) >= keys


@pytest.mark.parametrize("name", COMMANDS)
def test_help_lists_a_command_by_the_words_that_its_own_help_begins_with(name: str, cli: Cli) -> None:
    """What stands in the list is read from the source, without importing it."""
    listed: Any = typer.main.get_command(app)
    told = listed.get_command(None, name).help
    _, registered, _ = listed.resolve_command(None, [name])
    assert registered is not None
    assert registered.callback is not None
    assert registered.help.split() == told.split()
