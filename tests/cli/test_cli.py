"""The command line: exit codes, what goes to which stream, and folders that are written whole or not at all."""

import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import obspy
import pytest
import typer
from harness import Cli, Said

from ehamj.cli import app
from ehamj.plant.mounts import MOUNTS
from ehamj.result import Result, load_result
from ehamj.run.simulate import stepped
from ehamj.scenario.load import shipped_scenarios

pytestmark = pytest.mark.usefixtures("empty_folder")

COMMANDS = sorted(typer.main.get_command(app).commands)  # type: ignore[attr-defined]
PLAIN = ("--no-replay", "--no-report", "--set", "compare=[]")
QUICK = ("run", "benchmark", *PLAIN, "--set", "duration=0.01")
RECORD = ("run", "recorded", *PLAIN, "--set", "duration=0.05")

# The unstable run: the valve of one mount is opened with a jump, at a step far too long for the oil's 500 Hz.
UNSTABLE = (
    *("run", "benchmark", *PLAIN, "--set", "duration=1", "--set", "timestep=0.005", "--set", "record_rate=200"),
    *("--set", "actuators.isolator.moving_volume=true"),
    *("--set", "control.signals=[{kind='step', amplitude=5.0, mounts=['rear-left']}]"),
)


def process(*arguments: str) -> Said:
    """The installed program in a process of its own."""
    program = Path(sys.executable).with_name("ehamj")
    done = subprocess.run([program, *arguments], capture_output=True, text=True, encoding="utf-8", check=False)
    return Said(done.returncode, done.stdout, done.stderr)


def tree(folder: Path = Path()) -> dict[str, bytes | None]:
    """Everything below a folder: contents of files, None for folders."""
    return {str(path): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


# --- the installed program ----------------------------------------------------------------------------------------


def test_program_runs_and_says_json() -> None:
    said = process(*QUICK, "--out", "result", "--json")
    assert said.code == 0
    content = said.json
    assert content["folder"] == "result"
    assert content["summary"] == load_result("result").summary
    assert "simulating benchmark" in said.err  # progress goes there
    assert "Traceback" not in said.err


def test_program_refuses_bad_input() -> None:
    said = process(*QUICK, "--set", "machine.mas=1", "--json")
    assert said.message.startswith("machine.mas = 1: unknown key; did you mean 'mass'?")
    assert not tree()


def test_program_keeps_what_a_failing_run_has() -> None:
    said = process(*UNSTABLE, "--out", "result", "--json")
    assert said.code == 3
    assert said.json["folder"] == "result"
    assert "Traceback" not in said.err
    assert load_result("result").summary["complete"] is False


# --- a run --------------------------------------------------------------------------------------------------------


def test_run_writes_a_result_and_nothing_else(cli: Cli) -> None:
    said = cli(*QUICK, "--out", "a/b/result")
    assert said.code == 0
    assert set(tree()) == {
        *("a", "a/b", "a/b/result"),
        *(f"a/b/result/{name}" for name in ("scenario.toml", "result.nc", "summary.json", "model.xml")),
    }
    assert load_result("a/b/result").complete


def test_run_says_what_came_out_and_where(cli: Cli) -> None:
    said = cli(*QUICK, "--out", "result")
    assert "benchmark: 0.01 s simulated" in said.out
    assert "complete" in said.out
    assert "result: result" in said.out


def test_a_run_says_what_binds_where_the_time_went_and_what_to_open_next(cli: Cli) -> None:
    said = cli("run", "benchmark", "--set", "duration=0.01", "--set", "compare=[]", "--no-replay", "--out", "result")
    spool = load_result("result").summary.peak["spool"]
    mount = max(spool, key=lambda name: spool[name])
    assert re.search(rf"^limits: none was reached; nearest is \w+: [\d.]+ of [\d.]+ \w+ \({mount}\)$", said.out, re.M)
    spent = re.search(r"^time: ([\d.]+) s: (.*)$", said.out, re.MULTILINE)
    assert spent is not None
    stages = dict(re.findall(r"([a-z ]+[a-z]) ([\d.]+) s", spent[2]))
    assert "writing" in {stage.strip() for stage in stages}  # what took next to nothing is left out
    assert sum(map(float, stages.values())) == pytest.approx(float(spent[1]), rel=0.1, abs=0.5)
    assert "\nread: result/report.html\n" in said.out
    assert said.out.endswith("replay: none; `ehamj replay result` writes it\n")


def test_a_floor_whose_axes_are_scaled_each_by_itself_is_told_of(cli: Cli) -> None:
    quick = ["--set", "duration=0.1", "--set", "compare=[]", "--no-report", "--no-replay"]
    said = cli("run", "recorded", *quick, "--set", "ground.scale={z=2.0, x=-1.0}")
    assert said.code == 0
    assert "note: the recorded floor is scaled by 2 (z), -1 (x) (ground.scale)" in said.out


def test_the_version_is_one_line(cli: Cli) -> None:
    said = cli("--version")
    assert said.code == 0
    assert re.fullmatch(r"ehamj \S+, Python 3\.\d+\.\d+, MuJoCo \S+\n", said.out)


def test_json_is_all_of_standard_output(cli: Cli) -> None:
    content = cli(*QUICK, "--json").json
    assert content["folder"] == "runs/0001"
    assert content["summary"] == load_result("runs/0001").summary


def test_a_scenario_file_with_an_override(cli: Cli) -> None:
    Path("mine.toml").write_text('name = "mine"\nduration = 0.01\n[machine]\nmass = 3000.0\n')
    assert cli("run", "mine.toml", *PLAIN, "--out", "result", "--set", "machine.mass=5000").code == 0
    scenario = load_result("result").scenario
    assert (scenario.name, scenario.machine.mass, scenario.machine.sources["mass"]) == ("mine", 5000.0, "given")


def test_resolved_scenario_of_a_run_runs_again_to_the_same_result(cli: Cli) -> None:
    cli(*QUICK, "--out", "first")
    assert cli("run", "first/scenario.toml", "--out", "second").code == 0
    assert load_result("second").dataset.identical(load_result("first").dataset)


@pytest.mark.parametrize("name", ["[/] odd [bold]name[/bold] \\", "ünïcode µ²", "{braces} 100 %s"])
def test_names_are_printed_as_they_are(cli: Cli, name: str) -> None:
    said = cli(*QUICK, "--set", f"name='{name}'", "--out", "result")
    assert said.code == 0
    assert f"{name}: 0.01 s simulated" in said.out


def test_folders_are_printed_as_they_are(cli: Cli) -> None:
    said = cli(*QUICK, "--out", "a [/b] [red]c")
    assert said.code == 0
    assert "result: a [/b] [red]c" in said.out
    assert Path("a [/b] [red]c/summary.json").is_file()


def test_messages_keep_their_brackets(cli: Cli) -> None:
    said = cli(*QUICK, "--set", "name=['red', 'bold']")
    assert "name = ['red', 'bold']: " in said.message


# --- folders ------------------------------------------------------------------------------------------------------


def test_runs_are_numbered(cli: Cli) -> None:
    for _ in range(2):
        cli(*QUICK)
    assert sorted(path.name for path in Path("runs").iterdir()) == ["0001", "0002"]
    Path("runs/0041-kept").mkdir()
    Path("runs/notes.txt").write_text("mine")
    cli(*QUICK)
    assert sorted(path.name for path in Path("runs").iterdir()) == ["0001", "0002", "0041-kept", "0042", "notes.txt"]


@pytest.mark.parametrize("content", [(), ("notes.txt",), ("scenario.toml", "result.nc", "summary.json")])
def test_an_existing_folder_is_refused_and_untouched(cli: Cli, content: tuple[str, ...]) -> None:
    Path("there").mkdir()
    for name in content:
        Path("there", name).write_text("mine")
    before = tree()
    assert cli(*QUICK, "--out", "there").message.startswith("--out 'there': exists already")
    assert tree() == before


def test_overwrite_replaces_a_result(cli: Cli) -> None:
    cli(*QUICK, "--out", "result")
    Path("result/replay.rrd").write_bytes(b"of the old result")
    assert cli(*QUICK, "--out", "result", "--overwrite", "--set", "name=new").code == 0
    assert load_result("result").scenario.name == "new"
    assert {path.name for path in Path().rglob("*")} == {
        *("result", "scenario.toml", "result.nc", "summary.json", "model.xml"),
    }


def test_overwrite_makes_a_folder_that_is_not_there(cli: Cli) -> None:
    assert cli(*QUICK, "--out", "result", "--overwrite").code == 0
    assert load_result("result").complete


def test_overwrite_refuses_the_folder_one_stands_in(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    cli(*QUICK, "--out", "result")
    monkeypatch.chdir("result")
    before = tree()
    assert "is where you stand" in cli(*QUICK, "--out", ".", "--overwrite").message
    assert tree() == before


@pytest.mark.parametrize("name", ["notes.txt", "scenario.toml", "summary.json"])
def test_overwrite_refuses_a_folder_that_is_no_result(cli: Cli, name: str) -> None:
    # A folder with a scenario in it may well be where somebody keeps his own.
    Path("mine").mkdir()
    Path("mine", name).write_text("mine")
    before = tree()
    assert "replaces one of its own kind only" in cli(*QUICK, "--out", "mine", "--overwrite").message
    assert tree() == before


def test_overwrite_refuses_a_file(cli: Cli) -> None:
    Path("mine").write_text("mine")
    assert "is a file, not a folder" in cli(*QUICK, "--out", "mine", "--overwrite").message
    assert tree() == {"mine": b"mine"}


def test_a_folder_below_a_file_is_refused_before_anything_is_computed(cli: Cli) -> None:
    Path("mine").write_text("mine")
    said = cli(*QUICK, "--out", "mine/result")
    assert "cannot be written" in said.message
    assert "simulating" not in said.err
    assert tree() == {"mine": b"mine"}


# --- bad input ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (("run", "no-such"), ["'no-such'", "no such file", "recorded", "benchmark"]),
        ((*QUICK, "--set", "machine.mass=-4000"), ["machine.mass = -4000", "greater than 0"]),
        ((*QUICK, "--set", "machine.mass=4t"), ["machine.mass = '4t'", "number, in kg"]),
        ((*QUICK, "--set", "machine.weight=4000"), ["unknown key; allowed: mass, "]),
        (("replay",), ["RESULT: is missing", "`ehamj run` makes one"]),
        (("report", "runs/0007"), ["'runs/0007': there is no such folder"]),
        ((*QUICK, "--set", "machine.mass"), ["--set 'machine.mass'", "key=value"]),
        ((*QUICK, "--set", "mount.0.position=[1.5, 0.6]"), ["front-left", "[1.5, 0.6]", "±1.1 by ±0.8 m"]),
        ((*QUICK, "--set", "timestep=0.0003"), ["timestep = 0.0003", "record_rate", "0.000333333"]),
        ((*QUICK, "--set", "duration=1e-5"), ["duration = 1e-05", "at least one recording period, 0.001 s"]),
        (
            (*QUICK, "--set", "actuators.isolator.membrane_stiffness=0", "--set", "gravity=9.81"),
            ["cannot stand", "along z"],
        ),
    ],
)
def test_bad_input_is_refused_and_leaves_nothing(cli: Cli, arguments: tuple[str, ...], parts: list[str]) -> None:
    said = cli(*arguments).message
    for part in parts:
        assert part in said
    assert not tree()


@pytest.mark.parametrize("arguments", [("runn",), ("run", "--outt", "x"), ("run", "a", "b"), ("scenarios", "extra")])
def test_unknown_commands_and_options_are_refused(cli: Cli, arguments: tuple[str, ...]) -> None:
    said = cli(*arguments)
    assert (said.code, said.out) == (2, "")
    assert "Usage: ehamj" in said.err
    assert "Traceback" not in said.err
    assert not tree()


def test_a_key_that_was_taken_for_an_option_has_a_way_out(cli: Cli) -> None:
    said = cli("run", "--duration", "3")
    assert said.code == 2
    assert "keys of the scenario are set by --set, such as --set duration=3" in " ".join(said.err.split())


def test_the_latest_result_is_named_where_none_was(cli: Cli) -> None:
    for _ in range(2):
        cli(*QUICK)
    assert "the latest here is 'runs/0002'" in cli("replay").message


def test_no_command_shows_the_help(cli: Cli) -> None:
    said = cli()
    assert said.code == 2
    assert "Usage: ehamj" in said.out + said.err


# --- records ------------------------------------------------------------------------------------------------------


def csv(rows: int = 400, name: str = "floor.csv") -> str:
    """4 s of a sine at 5 Hz, sampled at 100 Hz."""
    time = np.arange(rows) / 100.0
    lines = [f"{t:.2f},{1e-4 * np.sin(2 * np.pi * 5 * t):.9e}" for t in time]
    Path(name).write_text("\n".join(["time [s], z [m/s]", *lines]) + "\n")
    return name


def recorded(name: str, **settings: str) -> tuple[str, ...]:
    """Arguments of a short run on a record of that name."""
    ground = {"kind": "'record'", "file": f"'{name}'", **settings}
    inline = ", ".join(f"{key}={value}" for key, value in ground.items())
    return (*RECORD, "--set", f"ground={{{inline}}}")


def test_a_record_in_the_working_directory_is_found(cli: Cli) -> None:
    assert cli(*recorded(csv()), "--out", "result").code == 0
    result = load_result("result")
    assert result.dataset["ground_velocity"].sel(axis="z").any()
    assert any("floor.csv" in warning for warning in result.summary["warnings"])


def test_a_missing_record(cli: Cli) -> None:
    assert "ground.file = 'floor.csv' cannot be read" in cli(*recorded("floor.csv")).message
    assert not tree()


def test_an_unreadable_record(cli: Cli) -> None:
    Path("floor.mseed").write_bytes(b"this is no record\n" * 40)
    before = tree()
    said = cli(*recorded("floor.mseed")).message
    assert "ground.file = 'floor.mseed' cannot be read" in said
    assert tree() == before


def test_a_truncated_table(cli: Cli) -> None:
    whole = Path(csv()).read_text()
    Path("floor.csv").write_text(whole[: whole.rindex(",")])
    before = tree()
    said = cli(*recorded("floor.csv")).message
    for part in ("ground.file = 'floor.csv'", "line 401", "truncated"):
        assert part in said
    assert tree() == before


def test_a_truncated_seismic_record(cli: Cli) -> None:
    obspy.read().write("floor.mseed", format="MSEED")
    whole = Path("floor.mseed").read_bytes()
    Path("floor.mseed").write_bytes(whole[:-300])
    before = tree()
    said = cli(*recorded("floor.mseed")).message
    for part in ("ground.file = 'floor.mseed'", "truncated"):
        assert part in said
    assert tree() == before


def test_a_record_shorter_than_the_run(cli: Cli) -> None:
    before = {csv(): Path("floor.csv").read_bytes()}
    said = cli(*recorded("floor.csv"), "--set", "duration=5").message
    for part in ("duration, 5 s", "floor.csv lasts 4 s"):
        assert part in said
    assert tree() == before


def test_a_record_without_the_response_that_is_asked_for(cli: Cli) -> None:
    stream = obspy.read()
    for trace in stream:
        trace.stats.pop("response", None)
    stream.write("floor.mseed", format="MSEED")
    before = tree()
    said = cli(*recorded("floor.mseed", remove_response="true")).message
    for part in ("ground.inventory is missing", "no response of BW.RJOB..EH", "ground.remove_response = false"):
        assert part in said
    assert tree() == before


# --- a run that fails ---------------------------------------------------------------------------------------------


def test_a_failing_run_says_what_where_and_when(cli: Cli) -> None:
    said = cli(*UNSTABLE, "--out", "result")
    assert said.code == 3
    assert "Traceback" not in said.err
    found = re.search(r"^ehamj: simulation failed at ([\d.e-]+) s, at ([a-z-]+): (.+); step 0\.005 s", said.err, re.M)
    assert found is not None
    assert 0 < float(found[1]) < 1
    assert found[2] in MOUNTS
    assert "chamber" in found[3]
    assert "INCOMPLETE" in said.out
    assert "nothing is judged" in said.out
    for words in ("vibration class", "attenuation", "about equilibrium", "would"):
        assert words not in said.out
    assert "`ehamj report result` writes it" in said.out


def test_a_failing_run_keeps_what_it_has_marked_incomplete(cli: Cli) -> None:
    said = cli(*UNSTABLE)
    result = load_result("runs/0001")
    assert result.summary["complete"] is False
    assert result.dataset.attrs["complete"] == 0
    assert result.summary["failure"] in said.err
    assert result.dataset.sizes["time"] >= 1
    failed_at = float(re.findall(r"failed at ([\d.e-]+) s", said.err)[0])
    assert result.dataset["time"].values[-1] < failed_at
    assert np.isfinite(result.dataset["stroke"]).all()


# --- what there is to know ----------------------------------------------------------------------------------------


def test_scenarios_one_line_each(cli: Cli) -> None:
    said = cli("scenarios")
    assert (said.code, said.err) == (0, "")
    assert [line.split()[0] for line in said.out.splitlines()] == list(shipped_scenarios())


def test_scenarios_as_json(cli: Cli) -> None:
    found = cli("scenarios", "--json").json["scenarios"]
    assert isinstance(found, list)
    assert [entry["name"] for entry in found] == list(shipped_scenarios())
    assert all(len(entry["description"]) > 20 for entry in found)


def test_schema_is_json_and_nothing_else(cli: Cli) -> None:
    said = cli("schema")
    assert (said.code, said.err) == (0, "")
    properties = said.json["properties"]
    assert isinstance(properties, dict)
    assert {"machine", "mount", "ground", "control"} <= set(properties)


def test_help_lists_the_commands(cli: Cli) -> None:
    said = cli("--help")
    assert (said.code, said.err) == (0, "")
    for command in COMMANDS:
        assert re.search(rf"\b{command}\b", said.out)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(cli: Cli, command: str) -> None:
    said = cli(command, "--help")
    assert (said.code, said.err) == (0, "")
    assert f"Usage: ehamj {command}" in said.out
    assert "--json" in said.out or command == "schema"  # what schema prints is JSON anyway
    assert not tree()


def test_help_of_run_teaches(cli: Cli) -> None:
    said = cli("run", "--help").out
    for part in ("--out", "--overwrite", "--set", "--no-replay", "summary.json", "result.nc", "machine.mass=4500"):
        assert part in said


# --- floor to machine ----------------------------------------------------------------------------------------------

RESPOND = ("transmissibility", "workshop", "--set", "plates=tied", "--lines", "4", "--from", "5", "--to", "50")


def test_transmissibility_writes_page_tables_and_figures(cli: Cli) -> None:
    said = cli(*RESPOND, "--dofs", "z,rx", "--out", "floor", "--json")
    assert said.code == 0
    content = said.json
    names = {"transmissibility.html", "transmissibility.nc", "transmissibility.csv", "attenuation.csv", "scenario.toml"}
    assert {path.name for path in Path("floor").iterdir()} == names | {"figures"}
    assert {path.stem for path in Path("floor/figures").iterdir()} == {
        f"transmissibility-{name}" for name in ("z", "rx", "matrix")
    }
    attenuation = content["attenuation_db"]
    assert isinstance(attenuation, dict)
    assert list(attenuation) == ["passive", "feedforward"]
    assert attenuation["feedforward"]["measured"]["z"]["50"] > 45.0
    deviation = content["largest_deviation"]
    assert isinstance(deviation, dict)
    assert deviation["passive"]["cg_displacement z"]["magnitude_db"] < 0.17  # 2 %
    assert deviation["passive"]["cg_displacement z"]["phase_deg"] < 1.2
    assert deviation["feedforward"]["cg_displacement z"]["of_floor_db"] < -34.0
    again = cli(*RESPOND, "--dofs", "z", "--out", "floor")
    assert "exists already" in again.message
    printed = cli(*RESPOND, "--dofs", "z", "--out", "floor", "--overwrite")
    assert printed.code == 0
    assert float(re.findall(r"passive: measured within ([\d.]+) dB and 1° of linear", printed.out)[0]) <= 0.2
    assert re.search(r"^ ?z +feedforward +measured( +[\d.–−]+)+", printed.out, re.MULTILINE)


def test_transmissibility_of_a_stored_run_is_its_own(cli: Cli) -> None:
    quiet = ("--set", "compare=[]", "--set", "duration=3", "--set", "plates=tied")
    assert cli("run", "workshop", *quiet, "--no-replay", "--no-report", "--out", "run").code == 0
    said = cli("transmissibility", "run", "--dofs", "z", "--out", "floor", "--json")
    assert said.code == 0
    content = said.json
    assert content["method"] == {"passive": [], "feedforward": ["Welch, 29 averages of 0.169 s or more, H1"]}


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("workshop", "--dofs", "z,w"), "dofs.1 = 'w': must be"),
        (("workshop", "--realisations", "1"), "realisations = 1: must be greater than or equal to 2"),
        (("workshop", "--confidence", "1.5"), "confidence = 1.5: must be less than 1"),
        (("workshop", "--joint"), "--joint: belongs to --method welch; this measures by multisine"),
        (("workshop", "--method", "welch", "--lines", "9"), "--lines: belongs to --method multisine"),
        (("workshop", "--from", "50", "--to", "5"), "must be below"),
        (("nowhere",), "no such file"),
    ],
)
def test_transmissibility_refuses_and_writes_nothing(cli: Cli, arguments: tuple[str, ...], expected: str) -> None:
    assert expected in cli("transmissibility", *arguments, "--out", "floor").message
    assert tree() == {}


# --- report of stored results --------------------------------------------------------------------------------------

WORKSHOP = ("run", "workshop", "--engine", "small-motion", "--set", "duration=2", "--no-replay", "--no-report")


def test_a_report_is_built_of_a_stored_result_and_its_variants(cli: Cli) -> None:
    assert cli(*WORKSHOP, "--out", "run").code == 0
    before = tree()
    said = cli("report", "run", "--json")
    assert said.code == 0
    assert said.json == {"report": "run/report.html", "results": ["feedforward", "passive"]}
    after = tree()
    assert {name: after[name] for name in before} == before
    new = {Path(name).parts[1] for name in set(after) - set(before)}
    assert new == {"report.html", "figures"}
    shutil.rmtree("run/passive")
    alone = cli("report", "run", "--json")
    assert alone.json["results"] == ["feedforward"]
    assert "the variant run/passive is gone" in alone.err


def test_a_comparison_has_a_page_of_its_own(cli: Cli) -> None:
    assert cli(*WORKSHOP, "--set", "compare=[]", "--out", "a/run").code == 0
    assert cli(*WORKSHOP, "--set", "compare=[]", "--set", "machine.mass=5000", "--out", "b/run").code == 0
    Path("a/run/report.html").write_text("its own page")
    Path("a/run/figures").mkdir()
    Path("a/run/figures/own.svg").write_text("its own figure")
    own = tree(Path("a/run"))
    said = cli("report", "a/run", "--compare", "b/run", "--json")
    labels = ["feedforward (a/run)", "feedforward (b/run)"]
    assert said.json == {"report": "a/run/report-compare.html", "results": labels}
    after = tree(Path("a/run"))
    assert {name: after[name] for name in own} == own
    assert {Path(name).parts[2] for name in set(after) - set(own)} == {"report-compare.html", "figures-compare"}
    text = Path("a/run/report-compare.html").read_text()
    assert "4000 kg" in text
    assert "5000 kg" in text
    assert "is named twice" in cli("report", "a/run", "--compare", "a/../a/run").message
    assert tree(Path("a/run")) == after


def test_a_report_of_no_result_is_refused(cli: Cli) -> None:
    Path("empty").mkdir()
    assert "is no result folder" in cli("report", "empty").message
    assert tree() == {"empty": None}


def test_a_band_that_passes_as_it_is_has_zero_decibels(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    """And no minus zero; what is amplified keeps its sign."""

    def passed(*arguments: Any, **options: Any) -> Result:
        result = stepped(*arguments, **options)
        bands = {"5": -0.3, "10": 0.3, "20": -0.6}
        return replace(result, summary=result.summary.changed(attenuation_db={"z": bands}))

    monkeypatch.setattr("ehamj.run.simulate.stepped", passed)
    said = cli(*QUICK)
    assert re.search(r"5 Hz +10 Hz +20 Hz *\n─+\nvertical +worst place +0 +0 +−1\n", said.out)
