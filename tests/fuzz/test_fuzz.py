"""A small part of `make fuzz`, the same cases every time; and that its judge sees what it is there to see."""

from pathlib import Path
from typing import Any

import pytest
from harness import Cli

from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario
from ehamj.scenario.places import by_kind, keys_of
from fuzz.case import chance
from fuzz.judge import findings
from fuzz.kinds import KINDS
from fuzz.scenarios import drawn

SOUND: dict[str, Any] = {
    "codes": [2], "said": "ehamj: machine.mass = 'a': must be a valid number\n", "seconds": [0.1], "memory": [1.0],
    "left": [], "whole": "", "complete": None, "executed": [], "keys": ["machine.mass"],
}  # fmt: skip


def test_mutated_scenarios_are_refused_by_name_or_run(
    cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in range(20):
        folder = tmp_path / str(number)
        folder.mkdir()
        case = KINDS["mutated"].make(chance("mutated", 0, number), tmp_path)
        case.lay(folder)
        monkeypatch.chdir(folder)
        said = cli(*case.commands[0])
        left = [str(path.relative_to(folder)) for path in folder.iterdir() if path.name not in case.files]
        outcome = SOUND | {"codes": [said.code], "said": said.err, "left": left, "keys": list(case.keys)}
        assert not list(findings("mutated", outcome)), f"python -m fuzz --kind mutated --case {number}"


def test_a_case_is_the_same_every_time() -> None:
    one, other = (KINDS["mutated"].make(chance("mutated", 3, 14), Path()) for _ in range(2))
    assert one == other


def test_every_kind_of_ground_control_force_fault_and_slide_is_drawn() -> None:
    tables = [drawn(chance("valid", 0, number))[0] for number in range(600)]
    types = keys_of(Scenario)
    for key in ("ground", "control"):
        assert {table[key]["kind"] for table in tables if key in table} == set(by_kind(types[key]))
    for key in ("force", "fault"):
        seen = {entry["kind"] for table in tables for entry in table.get(key, ())}
        assert seen == set(by_kind(types[key].__args__[0]))
    profiles = [slide.get("profile", {}) for table in tables for slide in table.get("slide", ())]
    assert {profile.get("kind") for profile in profiles} > {"moves", "table"}


def test_most_of_what_is_drawn_is_a_scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    refused = 0
    for number in range(40):
        table, files = drawn(chance("valid", 0, number))
        for name, content in files.items():
            (tmp_path / name).write_bytes(content)
        monkeypatch.chdir(tmp_path)
        try:
            parse_scenario(table)
        except ValueError:
            refused += 1
    assert refused < 20


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"codes": [1]}, "exit code 1"),
        ({"said": "Traceback (most recent call last)\nKeyError: 3\n"}, "traceback: KeyError: #"),
        ({"said": SOUND["said"] * 2}, "2 messages"),
        ({"said": "a.py:3: RuntimeWarning: overflow\n" + SOUND["said"]}, "warning: RuntimeWarning overflow"),
        ({"said": "ehamj: Error: this should not happen\n", "codes": [3]}, "unforeseen"),
        ({"said": "ehamj: something is wrong\n"}, "unnamed"),
        ({"seconds": [3.0]}, "slow refusal"),
        ({"memory": [400.0]}, "memory of a refusal"),
        ({"left": ["out"]}, "left by a refusal"),
        ({"left": ["MUJOCO_LOG.TXT"]}, "left: MUJOCO_LOG.TXT"),
        ({"left": ["out/.result.nc.unfinished-00112233-7-ab.nc"], "codes": [0]}, "left: "),
        ({"codes": [0], "complete": False}, "done, and the result says incomplete"),
        ({"codes": [0], "whole": "spool is not finite"}, "result: spool is not finite"),
        ({"executed": ["os.system"]}, "executed: os.system"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_the_judge_sees_what_is_wrong(change: dict[str, Any], found: str) -> None:
    assert not list(findings("mutated", SOUND))
    assert any(one.startswith(found) for one in findings("mutated", SOUND | change))
