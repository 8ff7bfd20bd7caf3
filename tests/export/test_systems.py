"""Plant and law read back from the files that other tools take: poles, names, responses, and the same run."""

import json
import tomllib
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
import xarray as xr
from harness import SKEW_MOUNTS, Cli
from scipy.io import loadmat, savemat

import ehamj
from ehamj.control import Controller, ControllerBank
from ehamj.control.blocks import response
from ehamj.export.matlab import write_matlab
from ehamj.export.python_control import write_python_control
from ehamj.export.subject import Subject
from ehamj.export.systems import what_to_know
from ehamj.linear.loop import Loop, linear_under
from ehamj.linear.plants import LinearPlant
from ehamj.linear.sampled import sampled_loop
from ehamj.run.simulate import observed

HERTZ = np.array([0.5, 5.0, 50.0, 700.0])
REAL: dict[str, Any] = {
    "name": "real",
    "duration": 0.02,
    "seed": 3,
    "plates": "tied",
    "ground": {"kind": "broadband", "level": "VC-C"},
    "sensors": {"inertial": {"kind": "geophone"}},
    "actuators": {"isolator": {"valve": "proportional"}},
    "control": {"kind": "combined", "delay": 1.5e-4, "fade": 0.01, "linearisation": {}},
}
"""A law with a stage, a delay of its own, a fade, and instruments."""


@pytest.fixture(scope="module")
def subject() -> Subject:
    return Subject(ehamj.parse_scenario(REAL))


@pytest.fixture(scope="module")
def folder(subject: Subject, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The subject in both forms: real.mat and real.json."""
    within = tmp_path_factory.mktemp("exported")
    write_matlab(subject, within / "real.mat")
    write_python_control(subject, within / "real.json")
    return within


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    """What the subject's scenario does under its own law."""
    return observed(ehamj.parse_scenario(REAL)).dataset


def from_mat(folder: Path) -> dict[str, Any]:
    """What SciPy's own reader makes of the file: systems as python-control has them, names taken from the structs."""
    content = loadmat(folder / "real.mat", simplify_cells=True)
    return {name: one for name, one in content.items() if not name.startswith("__")}


def from_json(folder: Path) -> dict[str, Any]:
    return dict(json.loads((folder / "real.json").read_text()))


def test_the_plant_reads_back_as_it_was_in_physical_units(tmp_path: Path) -> None:
    """Of a machine on mounts of other names, in any direction, with ideal valves."""
    own = Subject(ehamj.parse_scenario({"mount": SKEW_MOUNTS, "points": {"nose": [0.3, 0.0, 1.0]}}))
    write_matlab(own, tmp_path / "real.mat")
    write_python_control(own, tmp_path / "real.json")
    plant = ehamj.linearise(own.scenario, points=own.scenario.points)
    mat, plain = loadmat(tmp_path / "real.mat", simplify_cells=True)["plant"], from_json(tmp_path)["plant"]
    assert list(mat["InputName"]) == plain["inputs"] == plant.input_labels
    assert list(mat["OutputName"]) == plain["outputs"] == plant.output_labels
    assert list(mat["StateName"]) == plain["states"] == plant.state_labels
    assert mat["dt"] == plain["dt"] == 0
    assert dict(zip(mat["OutputName"], mat["OutputUnit"], strict=True))["nose_velocity x"] == "m/s"
    at = plant.output_labels.index("stroke level"), plant.input_labels.index("valve_command level")
    for found in (mat, plain):
        A, B, C, D = (np.array(found[name]) for name in "ABCD")
        back = LinearPlant.scaled((A, B, C, D), plant.scales, plant.operating_point, plant.state_units)
        for name in "ABCD":
            np.testing.assert_array_equal(getattr(back, name), getattr(plant, name))  # not a digit is lost
        answer = response(2j * np.pi * HERTZ, A, B, C, D)[:, at[0], at[1]]
        np.testing.assert_allclose(answer, plant[at](2j * np.pi * HERTZ), rtol=1e-12)
    names: dict[str, Any] = {"json": json, "control": control}
    exec(from_json(tmp_path)["load"].replace("real.json", str(tmp_path / "real.json")), names)  # as the command says
    poles = np.sort_complex(names["plant"].poles())
    np.testing.assert_allclose(poles, np.sort_complex(np.linalg.eigvals(plain["A"])), rtol=1e-12)


def test_every_signal_has_its_unit(folder: Path) -> None:
    plant = from_mat(folder)["plant"]
    of = dict(zip(plant["OutputName"], plant["OutputUnit"], strict=True))
    of |= dict(zip(plant["InputName"], plant["InputUnit"], strict=True))
    of |= dict(zip(plant["StateName"], plant["StateUnit"], strict=True))
    assert from_json(folder)["units"]["plant"]["inputs"] == list(plant["InputUnit"])
    expected = {
        "machine_velocity rx": "rad/s", "machine_acceleration x": "m/s^2", "spindle-nose_displacement z": "m",
        "load_pressure rear-left": "Pa", "chamber_pressure rear-left 1": "Pa", "edges rear-left": "mA",
        "spool_rate rear-left": "mA/s", "valve_command rear-left": "V", "cg_force y": "N", "cg_force ry": "N m",
        "ground_velocity rear-left x": "m/s", "displacement rz": "rad", "supply_pressure": "Pa",
    }  # fmt: skip
    assert {name: of[name] for name in expected} == expected


def test_law_and_plant_as_it_sees_it_close_the_loop_that_runs(subject: Subject, folder: Path) -> None:
    scenario, law = subject.scenario, subject.controller
    assert isinstance(law, Controller)
    expected = np.linalg.eigvals(sampled_loop(linear_under(scenario.plant, law), Loop.of(scenario, law)).A)
    expected = expected[np.abs(expected) > 0.3]
    plain, mat = from_json(folder), from_mat(folder)
    seen, own = ({**plain[name]} for name in ("plant_sampled", "law"))
    systems = [control.ss(*[one.pop(key) for key in "ABCD"], **one) for one in (seen, own)]
    assert systems[0].output_labels == systems[1].input_labels == list(law.inputs)
    closed = np.linalg.eigvals(control.feedback(*systems, sign=1).A)
    closed = closed[np.abs(closed) > 0.3]
    apart = np.abs(closed[:, None] - expected)
    assert closed.size == expected.size
    assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-6  # equal instruments: double eigenvalues
    behind = mat["plant_linearised"]
    assert not mat["plant"]["B"][:, :4].any()  # within threshold and overlap valves pass nothing
    expected = linear_under(scenario.plant, law)
    np.testing.assert_array_equal(behind["A"], expected.A)
    np.testing.assert_array_equal(behind["B"], expected.B)
    assert any("in plant their commands do nothing" in note for note in mat["ehamj"]["notes"])
    for key in "ABCD":
        np.testing.assert_array_equal(mat["law"][key], getattr(law, key))
        np.testing.assert_array_equal(mat["plant_sampled"][key], plain["plant_sampled"][key])
    assert (mat["law"]["dt"], mat["law"]["delay_s"], mat["law"]["bits"]) == (1e-4, 1.5e-4, 16)
    assert any("stage that makes good" in note for note in np.atleast_1d(mat["ehamj"]["notes"]))
    assert ehamj.parse_scenario(tomllib.loads(mat["ehamj"]["toml"])) == scenario


def test_the_operating_point_is_where_a_run_begins(run: xr.Dataset, folder: Path) -> None:
    run = run.isel(time=0)
    for rest in (from_mat(folder)["plant"]["operating_point"], from_json(folder)["operating_point"]["plant"]):
        assert list(rest["mounts"]) == run["mount"].values.tolist()
        np.testing.assert_allclose(rest["strokes"]["values"], run["stroke"], rtol=1e-9)
        np.testing.assert_allclose(rest["pressure_2"]["values"], run["chamber_pressure"][:, 1], rtol=1e-9)


@pytest.mark.parametrize("name", ["real.mat", "real.json"])
def test_a_law_that_went_out_and_came_back_gives_the_same_run(
    subject: Subject, run: xr.Dataset, folder: Path, name: str
) -> None:
    law = ehamj.load_controller(folder / name)
    assert subject.controller is not None
    assert law.to_dict() == subject.controller.to_dict()
    table = REAL | {"control": {"kind": "law", "file": str(folder / name)}}
    found = observed(ehamj.parse_scenario(table)).dataset
    assert all(np.array_equal(found[channel], run[channel]) for channel in run.data_vars)


def test_an_unchanged_law_commands_the_same_by_every_way_back(tmp_path: Path) -> None:
    """The exported files whole: to the bit. Matrices, period and names alone, as MATLAB's ``get(sys)`` has them: to a
    step of the converter, since readings count from rest; of unloaded membranes they would command most of a volt."""
    plain = {"name": "back", "duration": 0.05, "plates": "tied", "ground": {"kind": "broadband", "level": "VC-A"}}
    own = Subject(ehamj.parse_scenario(plain | {"control": {"kind": "combined"}}))
    write_python_control(own, tmp_path / "real.json")
    write_matlab(own, tmp_path / "real.mat")
    expected = observed(own.scenario).dataset["valve_command"]

    def apart(file: str) -> float:
        table = plain | {"control": {"kind": "law", "file": str(tmp_path / file)}}
        return float(abs(observed(ehamj.parse_scenario(table)).dataset["valve_command"] - expected).max())

    assert apart("real.json") == apart("real.mat") == 0.0
    law = from_json(tmp_path)["law"]
    (tmp_path / "alone.json").write_text(json.dumps({name: law[name] for name in (*"ABCD", "dt", "inputs", "outputs")}))
    assert float(abs(expected).max()) > 0.01
    assert apart("alone.json") < 20.0 / 2**16
    fields = loadmat(tmp_path / "real.mat")["law"][0, 0]
    names = ("A", "B", "C", "D", "dt", "InputName", "OutputName")
    savemat(tmp_path / "alone.mat", {"s": {name: fields[name] for name in names}})
    assert apart("alone.mat") < 20.0 / 2**16
    (tmp_path / "loaded.json").write_text(json.dumps(law | {"from_rest": False}))
    assert apart("loaded.json") > 0.5


def test_what_matrices_alone_leave_behind_is_said() -> None:
    control = {"kind": "combined", "delay": 1.5e-4, "bits": 12, "linearisation": {}}
    said = [note for note in what_to_know(Subject(ehamj.parse_scenario({"control": control}))) if "alone" in note]
    assert len(said) == 1
    assert "without delay_s = 0.00015, bits = 12" in said[0]
    assert "from_rest" not in said[0]


def test_several_rates_and_a_law_without_states_come_back_too(tmp_path: Path) -> None:
    empty = {"A": np.zeros((0, 0)), "B": np.zeros((0, 4)), "C": np.zeros((4, 0)), "D": -1e3 * np.eye(4)}
    inputs = tuple(f"stroke {mount}" for mount in ("front-left", "front-right", "rear-left", "rear-right"))
    slow = {"A": 0.9 * np.eye(1), "B": np.ones((1, 4)), "C": np.ones((4, 1)), "D": np.zeros((4, 4))}
    bank = ControllerBank((
        Controller(**empty, inputs=inputs, bits=None), Controller(**slow, inputs=inputs, period=5e-4, bits=None)
    ))  # fmt: skip
    bank.save(tmp_path / "law.json")
    subject = Subject(ehamj.parse_scenario({"control": {"kind": "law", "file": str(tmp_path / "law.json")}}))
    write_matlab(subject, tmp_path / "bank.mat")
    write_python_control(subject, tmp_path / "bank.json")
    for name in ("bank.mat", "bank.json"):
        assert ehamj.load_controller(tmp_path / name).to_dict() == bank.to_dict()
    content = loadmat(tmp_path / "bank.mat", simplify_cells=True)
    seen = ehamj.sampled_plant(subject.scenario, rate=2000.0)
    slower = content["plant_sampled"][1]
    np.testing.assert_array_equal(slower["A"] * seen.scales / seen.scales[:, None], seen.A)
    assert (list(slower["InputName"]), list(slower["OutputName"])) == (seen.input_labels, seen.output_labels)
    assert [one["dt"] for one in content["law"]] == [one["dt"] for one in content["plant_sampled"]] == [1e-4, 5e-4]


def test_a_machine_without_a_law_is_exported_as_a_plant(cli: Cli) -> None:
    said = cli("export", "benchmark", "--matlab", "my plant.mat", "--python-control", "plant.json", "--json").json
    assert list(said["files"]) == ["my plant.mat", "my_plant_load.m", "plant.json"]
    assert not {"law", "plant_sampled"} & loadmat("my plant.mat").keys()
    assert "'my plant.mat'" in Path("my_plant_load.m").read_text()
    with pytest.raises(ehamj.InputError, match=r"plant\.json': controller: holds a plant and no law"):
        ehamj.load_controller("plant.json")
    with pytest.raises(ehamj.InputError, match=r"holds ehamj, plant, and no law: a struct of A, B, C, D"):
        ehamj.load_controller("my plant.mat")


def test_the_same_export_is_the_same_file(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        write_matlab(Subject(ehamj.parse_scenario({})), tmp_path / name / "plant.mat")
    assert (tmp_path / "one/plant.mat").read_bytes() == (tmp_path / "two/plant.mat").read_bytes()
