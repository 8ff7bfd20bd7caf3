"""The edges that a stranger meets in Python: strings for paths and scenarios, ten lines in print, saved folders."""

import json
from pathlib import Path

import pytest
from harness import Cli

import ehamj
from ehamj.errors import InputError
from ehamj.result import Result
from ehamj.scenario.model import Scenario


@pytest.fixture(scope="module")
def machine() -> Scenario:
    table = {"name": "a <machine>", "duration": 2.0, "plates": "tied", "compare": ["passive"]}
    quiet = {"output": {"replay": False, "report": False}, "ground": {"kind": "broadband", "level": "VC-C"}}
    return ehamj.parse_scenario(table | quiet | {"control": {"kind": "combined"}, "machine": {"mass": 4400.0}})


@pytest.fixture(scope="module")
def result(machine: Scenario) -> Result:
    return ehamj.simulate(machine)


def test_printed_it_is_ten_lines_with_the_numbers_of_the_summary(result: Result) -> None:
    lines = str(result).splitlines()
    assert len(lines) == 10
    said = dict(line.split(":", 1) for line in lines)
    assert said["run"].strip().startswith("a <machine>: 2 s simulated in ")
    assert f"{result.summary['attenuation_db']['z']['20']:.0f} dB at 20 Hz" in said["CG"]
    peak = max(abs(result.dataset.cg_velocity.sel(axis="z")).values)
    assert f"CG {1e6 * peak:.3g} µm/s" in said["peak motion"]
    assert f"gain {result.summary.margins.gain_db:.1f} dB" in said["margins"]  # type: ignore[union-attr]
    assert said["warnings"].strip().startswith(f"{len(result.summary.warnings)}: ")
    assert repr(result) == "<ehamj.Result 'a <machine>': 2 s, complete>"
    assert "a &lt;machine&gt;" in result._repr_html_()
    assert result._repr_html_().count("<tr>") == 10


def test_a_run_says_what_was_assumed_of_its_machine(result: Result) -> None:
    assert any("machine.inertia was not given" in warning for warning in result.summary.warnings)


def test_it_is_saved_as_the_command_line_saves(result: Result, machine: Scenario, tmp_path: Path) -> None:
    passive = ehamj.simulate(machine.variant("passive"))
    result.save(str(tmp_path / "new" / "run"), variants=[passive])
    again = ehamj.load_result(str(tmp_path / "new" / "run"))
    assert again.summary == result.summary
    assert again.scenario == machine
    assert ehamj.load_result(tmp_path / "new/run/passive").summary == passive.summary
    with pytest.raises(InputError, match=r"result\.save '.*run': exists already.*overwrite=True"):
        result.save(tmp_path / "new/run")
    result.save(tmp_path / "new/run", overwrite=True)
    assert not (tmp_path / "new/run/passive").exists()
    with pytest.raises(
        InputError, match="variants: 'a <machine>' must be one of the scenario's, 'a <machine>, passive'"
    ):
        result.save(tmp_path / "other", variants=[result])
    assert not (tmp_path / "other").exists()


def test_names_paths_and_tables_stand_for_scenarios(machine: Scenario, tmp_path: Path) -> None:
    machine.save(str(tmp_path / "mine.toml"))
    of_file, of_table = ehamj.linearise(str(tmp_path / "mine.toml")), ehamj.linearise(machine.model_dump())
    assert of_file.nstates == of_table.nstates == ehamj.linearise(machine).nstates
    assert ehamj.sampled_plant("recorded").dt == 1e-4
    with pytest.raises(InputError, match="scenario: is a int; it must be an"):
        ehamj.simulate(3)  # type: ignore[arg-type]


def test_a_law_is_saved_and_read_by_its_path_and_runs(result: Result, machine: Scenario, tmp_path: Path) -> None:
    law, path = result.controller, str(tmp_path / "law.json")
    assert law is not None
    law.save(path)
    assert ehamj.load_controller(path).inputs == ehamj.Controller.load(path).inputs == law.inputs
    short = machine.varied({"duration": 0.05, "name": "short"})
    one, other = ehamj.simulate(short), ehamj.simulate(short, controller=path)
    assert (one.dataset.valve_command == other.dataset.valve_command).all()


def test_the_command_line_notes_a_law_that_changed_with_its_machine(cli: Cli, tmp_path: Path) -> None:
    short = ["run", "recorded", "--set", "duration=0.05", "--set", "compare=[]", "--no-replay", "--no-report", "--json"]
    weaker = ["--set", "actuators.isolator.flow_gain=1.8e-6"]
    said = cli(*short, *weaker, "--out", "one")
    assert said.code == 0
    assert (
        "note: the combined law was derived anew for the changed machine and instruments (actuators.isolator.flow_gain"
        in said.err
    )
    json.loads(said.out)
    said = cli(*short, *weaker, "--set", "control.designed_for=recorded", "--out", "other")
    assert "derived anew" not in said.err
    assert any("the law is held" in warning for warning in said.json["summary"]["warnings"])
