"""`ehamj modes`: what it prints for people and for programs."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from harness import Cli

from ehamj.cli import frame
from ehamj.rig import modal_test


@pytest.fixture
def cli(cli: Cli) -> Cli:
    """The command in the common harness."""
    return partial(cli, "modes")


def test_tables_say_the_modes_and_what_moves(cli: Cli) -> None:
    code, said, _ = cli("benchmark", "--point", "spindle=0.2,0,1.4")
    assert code == 0
    for word in ("heave", "rocking about y", "valve front-left", "translates", "leakage", "spindle", "25% each"):
        assert word in said
    assert "valves held" in said
    assert "membranes only" in said


def test_json_holds_every_variant(cli: Cli) -> None:
    code, said, _ = cli("passing-wave", "--json", "--point", "spindle=0.2,0,1.4")
    assert code == 0
    table: dict[str, Any] = json.loads(said)
    assert set(table) == {"modes", "bypassed", "closed_loop"}
    heave = next(mode for mode in table["modes"] if mode["name"] == "heave")
    assert heave["frequency_hz"] == pytest.approx(528.0, rel=1e-3)
    assert heave["points"]["spindle"]["z"] == pytest.approx([1.0, 0.0], abs=1e-9)
    assert heave["centre_of_rotation"] is None
    assert sum(heave["energy"]["damping_ratio_per_actuator"].values()) == pytest.approx(heave["damping_ratio"])


def test_json_holds_the_sensitivity_of_every_mode(cli: Cli) -> None:
    table: dict[str, Any] = json.loads(cli("benchmark", "--json", "--sensitivity")[1])
    slopes = table["sensitivity"]["modes"]["machine.inertia.2"]
    assert (slopes["value"], slopes["unit"]) == (4000.0, "kg m²")
    yaw = [mode["name"] for mode in table["modes"]].index("yaw")
    assert slopes["frequency"][yaw] == pytest.approx(-0.5, abs=1e-5)
    assert len(table["sensitivity"]["bypassed"]["machine.mass"]["damping"]) == len(table["bypassed"])


def test_a_passive_scenario_has_no_closed_loop(cli: Cli) -> None:
    assert set(json.loads(cli("benchmark", "--json")[1])) == {"modes", "bypassed"}


def test_the_steepest_parameters_are_named(cli: Cli) -> None:
    said = cli("benchmark", "--sensitivity")[1]
    for parameter in ("lateral_stiffness", "valve_frequency", "footprint.x"):
        assert parameter in said
    assert "+1.00" in said


@pytest.mark.parametrize("point", ["spindle", "spindle=1,2", "=1,2,3", "spindle=1,2,nan", "cg=0,0,1"])
def test_a_point_that_is_none_is_refused(cli: Cli, point: str) -> None:
    code, said, error = cli("benchmark", "--point", point)
    assert (code, said) == (2, "")
    assert repr(point) in error


def test_identified_modes_stand_beside_the_computed(cli: Cli) -> None:
    code, said, _ = cli("benchmark", "--measured", "ring-down", "--json")
    assert code == 0
    measured = json.loads(said)["measured"]
    assert measured["missed"] == []
    for mode in measured["modes"]:
        assert mode["frequency_hz"] == pytest.approx(mode["computed_frequency_hz"], rel=2e-3)


@pytest.fixture
def narrow(empty_folder: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """A terminal of eighty columns."""
    monkeypatch.setattr(frame.out, "_width", 80)


@pytest.mark.usefixtures("narrow")
def test_a_measurement_prints_one_table_of_eighty_columns(cli: Cli) -> None:
    """The computed value beside the found one in the same row, and nothing else."""
    lines = cli("passing-wave", "--measured", "ring-down")[1].splitlines()
    assert max(map(len, lines)) <= 80 or lines[-1].startswith("found: ")
    assert sum("─────" in line for line in lines) == 1
    (heave,) = (line.split() for line in lines if line.startswith("heave"))
    assert float(heave[1]) == pytest.approx(528.0, abs=0.1)
    assert float(heave[2]) == pytest.approx(float(heave[1]), rel=2e-3)
    assert heave[-1] == "1.000"


@pytest.mark.usefixtures("narrow")
def test_poles_of_the_controller_are_named_in_a_line_unless_all_are_wanted(cli: Cli) -> None:
    short, long = (cli("passing-wave", *more)[1] for more in ((), ("--all",)))
    assert "controller 1 " not in short
    assert "of the controller alone, least damped" in short
    assert "controller 1 " in long
    assert "controller alone" not in long
    for said in (short, long):
        assert [line for line in said.splitlines() if len(line) > 80] == []


def test_an_unknown_measurement_is_refused(cli: Cli) -> None:
    code, said, error = cli("benchmark", "--measured", "shaker")
    assert (code, said) == (2, "")
    assert "must be one of ring-down, random, sweep, hammer" in error


TABLE = """frequency [Hz];frequency deviation [Hz];damping [%];foot_velocity front-left x;foot_velocity front-left y;\
foot_velocity rear-right x;foot_velocity rear-right y;spindle-nose x;spindle-nose y;spindle-nose z
70.5;0.2;3.1;1;0;1;0;1.02;0;0
71.1;;4.1;0;1;0;1;0;1.03;0
76.1;0.2;;-0.6;0.9;0.6;-0.9;0;0.3;0
150;1;1;0;0;0;0;1;0;0
"""


def test_modes_of_a_file_stand_beside_the_computed_by_their_shapes(cli: Cli) -> None:
    """Not by frequency: the slower one measured is the faster one computed."""
    Path("modes.csv").write_text(TABLE)
    code, said, _ = cli("vc-c-floor", "--set", "control={kind='passive'}", "--measured", "modes.csv", "--json")
    assert code == 0
    paired = json.loads(said)["paired"]
    names = ["sway-rocking about y", "sway-rocking about x", "yaw", None]
    assert [row["name"] for row in paired["modes"]] == names
    assert min(row["mac"] for row in paired["modes"][:3]) > 0.99
    assert [name.split(" (")[0] for name in paired["not_measured"]] == ["rocking about x", "heave", "rocking about y"]
    code, said, _ = cli("vc-c-floor", "--set", "control={kind='passive'}", "--measured", "modes.csv")
    lines = said.splitlines()
    assert "71.10 ±0.36 sway-rocking about x  70.03 −1.51" in said
    assert "150 Hz has no pair: no computed mode is like it" in lines
    assert max(map(len, lines[:9])) <= 80


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--measured", "modes.csv", "--noise", "0.1"), "not to a file of modes; leave it out"),
        (("--measured", "none.csv"), "there is no such file"),
        (("--measured", "hamer"), "did you mean 'hammer'? must be one of"),
    ],
)
def test_a_file_that_is_none_is_refused(cli: Cli, arguments: tuple[str, ...], said: str) -> None:
    code, printed, error = cli("vc-c-floor", *arguments)
    assert (code, printed) == (2, "")
    assert said in error


def test_help_names_every_measurement(cli: Cli) -> None:
    said = cli("--help")[1]
    assert all(kind in said for kind in modal_test.KINDS)


def test_noise_without_a_measurement_is_refused(cli: Cli) -> None:
    code, said, error = cli("benchmark", "--noise", "0.01")
    assert (code, said) == (2, "")
    assert "--noise 0.01: belongs to a measurement" in error
