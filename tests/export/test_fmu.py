"""The unit for co-simulation: validated and driven by FMPy, against the run that the same held inputs make."""

import shutil
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.validation import validate_fmu
from harness import Cli

import ehamj
from ehamj.control.channels import channel_names
from ehamj.control.law import silent
from ehamj.export.fmu.interface import outputs
from ehamj.export.fmu.unit import Unit
from ehamj.export.fmu.units import unit
from ehamj.export.fmu.write import _pack, write_fmu
from ehamj.export.subject import Subject, subject_of
from ehamj.ground.records import RecordGround
from ehamj.mujoco.hold import installed
from ehamj.records.files import named_by
from ehamj.result import Result
from ehamj.run.simulate import observed
from ehamj.scenario.model import Scenario

END, EVERY = 0.02, 0.002
CHANGES = [
    *(f"duration={END}", "compare=[]", "record_rate=500", "plates='tied'", "name='tied -- machine'"),
    "control={kind='skyhook',rate=5000.0,delay=2e-4}",
    "mount=[{name='front-left',position=[0.9,0.6]},{name='front-right',position=[0.9,-0.6]},"
    "{name='rear',position=[-0.9,0.0]}]",
]


def scenario_of(*changes: str) -> Scenario:
    """Three mounts, one of them with a name like no identifier, on a wave."""
    with pytest.warns(ehamj.DerivedAnew):
        return ehamj.load_scenario("vc-c-floor", [*CHANGES, *changes])


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Under a law, with noisy sensors, on a wave."""
    path = tmp_path_factory.mktemp("unit") / "unit.fmu"
    write_fmu(Subject(scenario_of()), path)
    assert [one.name for one in path.parent.iterdir()] == ["unit.fmu"]
    return path


class Driven:
    """An instance that is driven by hand, as a master drives it."""

    def __init__(self, path: Path, folder: Path, **start: Any) -> None:
        self.description = fmpy.read_model_description(path)
        self.numbers = {one.name: one.valueReference for one in self.description.modelVariables}
        fmpy.extract(path, folder)
        self.said: list[str] = []
        own = {"guid": self.description.guid, "modelIdentifier": self.description.coSimulation.modelIdentifier}
        self.slave = FMU2Slave(unzipDirectory=str(folder), instanceName="one", **own)
        callbacks = fmi2CallbackFunctions.from_buffer_copy(fmpy.fmi2.defaultCallbacks)
        callbacks.logger = fmi2CallbackLoggerTYPE(lambda *told: self.said.append(told[-1].decode()))
        self.slave.instantiate(callbacks=callbacks, loggingOn=True)
        self.begin(**start)

    def begin(self, **start: Any) -> None:
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.put(**start)
        self.slave.exitInitializationMode()

    def put(self, **values: Any) -> None:
        for name, value in values.items():
            if isinstance(value, bool):
                self.slave.setBoolean([self.numbers[name]], [value])
            else:
                self.slave.setReal([self.numbers[name]], [value])

    def get(self, *names: str) -> list[float]:
        return self.slave.getReal([self.numbers[name] for name in names])


def test_fmpy_finds_nothing_wrong_with_it(fmu: Path) -> None:
    assert validate_fmu(str(fmu)) == []
    told = fmpy.read_model_description(fmu)
    assert told.coSimulation.canGetAndSetFMUstate is False
    assert (told.fmiVersion, told.modelName) == ("2.0", "tied_machine")
    known = {one.name: one for one in told.modelVariables}
    assert all(one.description for one in told.modelVariables)
    assert {known[name].unit for name in ("held.ground.rear.x", "ground_acceleration.rear.x")} == {"m/s2"}
    assert known["machine.mass"].start == "4000"
    noises = [one for one in told.modelVariables if "√" in one.description]
    assert noises
    assert all(one.unit is None and one.description.endswith("]") for one in noises)
    assert known["mount[3].position[1]"].description.startswith("mount.2.position.0: ")
    assert (known["measured.foot_velocity.rear.z"].unit, known["machine_velocity.rx"].unit) == ("m/s", "rad/s")
    own = zipfile.ZipFile(fmu).namelist()
    assert {"resources/scenario.toml", "resources/controller.json", "documentation/index.html"} <= set(own)


def test_it_is_the_stepped_machine_whatever_the_communication_step(fmu: Path, tmp_path: Path) -> None:
    """Inputs held in FMPy, 10 timesteps a communication step, against the machine that `tests/run/test_stepper.py`
    holds against whole runs; two units in turn; a reset begins anew."""
    rng = np.random.default_rng(7)
    steps = round(END / EVERY)
    commands, ground, force = (
        rng.normal(0, 0.3, (steps, 3)),
        rng.normal(0, 0.02, (steps, 3, 3)),
        rng.normal(0, 99, (steps, 6)),
    )
    names = [f"held.command.{one}" for one in ("front_left", "front_right", "rear")]
    names += [f"held.ground.{one}.{axis}" for one in ("front_left", "front_right", "rear") for axis in "xyz"]
    names += [f"held.{one}.{axis}" for one in ("force", "moment") for axis in "xyz"]
    one, other = Driven(fmu, tmp_path / "one"), Driven(fmu, tmp_path / "other")
    outputs = [v.name for v in one.description.modelVariables if v.causality == "output"]

    def end(units: list[Driven]) -> np.ndarray:
        found = np.zeros((len(units), steps, len(outputs)))
        for k in range(steps):
            for number, driven in enumerate(units):
                row = (*commands[k], *ground[k].ravel(), *force[k])
                driven.put(**dict(zip(names, row, strict=True)))
                driven.slave.doStep(k * EVERY, EVERY)
                found[number, k] = driven.get(*outputs)
        return found

    found = end([one, other])
    machine, wanted = ehamj.Stepper(scenario_of()), []
    channels = [
        "cg_velocity",
        "foot_acceleration",
        "chamber_pressure",
        "measured",
        "valve_command",
        "ground_displacement",
    ]
    for k in range(steps):
        now = machine.step((k + 1) * EVERY, commands=commands[k], ground=ground[k], force=force[k])
        wanted.append(np.concatenate([now[name].ravel() for name in channels]))
    at = [number for name in channels for number, one in enumerate(outputs) if one.startswith(f"{name}.")]
    np.testing.assert_array_equal(found[0][:, at], wanted)
    np.testing.assert_array_equal(found[1], found[0])
    other.slave.terminate()
    other.slave.freeInstance()
    one.slave.reset()
    one.begin()
    np.testing.assert_array_equal(end([one])[0], found[0])
    assert not any(installed().values())
    one.slave.terminate()
    one.slave.freeInstance()


def test_parameters_change_what_is_run(fmu: Path, tmp_path: Path) -> None:
    """A heavier machine under the same law; the ground at rest; without the law, whose readings stay."""
    unit = Driven(fmu, tmp_path, **{"machine.mass": 5000.0, "use_ground": False, "use_control": False})
    unit.put(**{"held.force.z": 50.0})
    unit.slave.doStep(0.0, EVERY)
    scenario = scenario_of("machine.mass=5000", "ground={kind='rest'}")
    law = scenario.controller()
    assert law is not None
    machine = ehamj.Stepper(scenario.variant("passive"), reads=law.reads, reads_every=law.parts[0].period)
    now = machine.step(EVERY, force=[0.0, 0.0, 50.0, 0.0, 0.0, 0.0])
    assert unit.get("cg_velocity.z", "measured.foot_velocity.rear.z") == [
        now.value("cg_velocity", "z"),
        now.value("measured", "foot_velocity rear z"),
    ]
    assert unit.get("ground_velocity.rear.z", "valve_command.rear") == [0.0, 0.0]
    unit.slave.freeInstance()


def test_what_cannot_be_is_said_in_one_line(fmu: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """A step that cannot be is discarded, and the host may go on; a machine that cannot be is not begun."""
    unit = Driven(fmu, tmp_path / "unit")
    for do, words in (
        (lambda one: one.doStep(0.0, 1.5e-4), "communication step 0.00015 s: must be a multiple of the timestep, "),
        (lambda one: one.doStep(EVERY, EVERY), "the machine stands at 0 s, and steps on from there only"),
        (lambda one: one.doStep(0.0, 2 * END), "must be at most the scenario's duration = 0.02 s"),
    ):  # fmt: skip
        with pytest.raises(fmpy.fmi1.FMICallException) as failed:
            do(unit.slave)
        assert failed.value.status == fmpy.fmi2.fmi2Discard
        assert words in unit.said[-1]
    unit.slave.doStep(0.0, EVERY)
    unit.slave.freeInstance()
    with pytest.raises(fmpy.fmi1.FMICallException):
        Driven(fmu, tmp_path / "mass", **{"machine.mass": -1.0})
    assert capfd.readouterr().err.endswith("ehamj: machine.mass = -1.0: must be greater than 0\n")


def test_a_python_without_ehamj_says_so(fmu: Path, tmp_path: Path) -> None:
    """As the host finds it: the script is imported by another Python, which has none of the packages."""
    fmpy.extract(fmu, tmp_path)
    script = next((tmp_path / "resources").glob("ehamj_*.py"))
    text = script.read_text()
    assert f"\nVERSION, PLACES = {sys.version_info[:2]}, {[sysconfig.get_path('purelib')]!r}\n" in text
    script.write_text(text.replace("VERSION, PLACES = ", "VERSION, PLACES = (0, 0), [] #"))
    code = f"import {script.stem} as m; m.EhamjUnit(instance_name='x', resources='.')"
    base = [sys.executable, "-I", "-S", "-c", f"import sys; sys.path.insert(0, '.'); {code}"]
    ended = subprocess.run(base, cwd=script.parent, capture_output=True, text=True, check=False)
    assert "ImportError: ehamj: is not installed" in ended.stderr
    assert "pip install 'ehamj==" in ended.stderr


def test_files_of_a_scenario_are_in_it(tmp_path: Path) -> None:
    """The floor's record goes with the unit, and a result's own law."""
    times = np.arange(0.0, 3.0, 1e-3)
    rows = "\n".join(f"{t:.3f},{1e-6 * np.sin(60 * t):.9g}" for t in times)
    (tmp_path / "floor.csv").write_text(f"time [s],z [m/s]\n{rows}\n")
    changes = [*CHANGES[:1], "compare=[]", "output.report=false", "output.replay=false", "control={kind='feedforward'}"]
    ground = f"ground={{kind='record',file='{tmp_path / 'floor.csv'}'}}"
    scenario = ehamj.load_scenario("vc-c-floor", [*changes, "plates='tied'", ground])
    result: Result = ehamj.simulate(scenario)
    result.save(tmp_path / "0001")
    write_fmu(subject_of(tmp_path / "0001"), tmp_path / "unit.fmu")
    shutil.rmtree(tmp_path / "0001")
    (tmp_path / "floor.csv").unlink()
    unit = Driven(tmp_path / "unit.fmu", tmp_path / "extracted")
    unit.slave.doStep(0.0, 0.01)
    row = round(0.01 * scenario.record_rate)
    assert unit.get("cg_velocity.z")[0] == float(result.dataset["cg_velocity"].sel(axis="z")[row])
    assert not [one for one in unit.numbers if one.startswith("control")]
    unit.slave.freeInstance()


def packed(scenario: Scenario, folder: Path) -> Unit:
    """What a unit of a scenario has, without building the unit."""
    folder.mkdir()
    list(_pack(Subject(scenario), folder))
    return Unit(folder)


def test_all_files_that_a_pattern_names_are_packed_and_no_other(tmp_path: Path) -> None:
    for name in ("RSN1_UP.AT2", "RSN1_000.AT2", "secret.txt"):
        (tmp_path / name).write_text(name)
    ground = f"ground={{kind='record',file='{tmp_path}/RSN1_*.AT2'}}"
    passive = "control={kind='passive'}"
    scenario = ehamj.load_scenario("vc-c-floor", [ground, passive, f"description='{tmp_path}/secret.txt'"])
    own = packed(scenario, tmp_path / "own").scenario
    assert own.description == scenario.description
    assert isinstance(own.ground, RecordGround)
    assert [str(one.relative_to(tmp_path)) for one in named_by(Path(own.ground.file))] == [
        "own/file-1/RSN1_000.AT2",
        "own/file-1/RSN1_UP.AT2",
    ]
    assert sorted(one.name for one in (tmp_path / "own").iterdir()) == ["file-1", "scenario.toml"]
    (tmp_path / "RSN1_UP.AT2").unlink()
    (tmp_path / "RSN1_000.AT2").unlink()
    with pytest.raises(ehamj.InputError, match=r"RSN1_\*\.AT2', and there is no such file"):
        packed(scenario, tmp_path / "other")


def test_parameters_that_others_follow_from_are_set_beside_these(tmp_path: Path) -> None:
    """A mass and one moment of inertia; a size that unstated points follow; outputs of the machine as it is then."""
    passive = ["control={kind='passive'}", f"duration={END}"]
    unit = packed(ehamj.load_scenario("vc-c-floor", passive), tmp_path / "unit")
    begun = [unit.output(number) for number in range(len(unit.outputs))]
    former = unit.scenario.machine.inertia
    for name, value in {"machine.mass": 4500.0, "machine.inertia[1]": 3000.0, "machine.size[3]": 2.5}.items():
        unit.set_value(name, value)
    pressures = [number for number, one in enumerate(unit.outputs) if one.name.startswith("actuator_force")]
    assert unit.output(pressures[0]) != begun[pressures[0]]
    own, size = unit.machine.scenario, [*unit.scenario.machine.size[:2], 2.5]
    assert own.machine.inertia == (3000.0, *former[1:])
    wanted = ehamj.load_scenario("vc-c-floor", [*passive, f"machine.size={size}"]).points
    assert own.points == wanted != unit.scenario.points
    pushed = next(number for number, one in enumerate(unit.inputs) if one.name == "held.force.z")
    lifted = next(number for number, one in enumerate(unit.outputs) if one.name == "cg_acceleration.z")
    before = unit.output(lifted)
    unit.hold(pushed, 900.0)
    with pytest.raises(ehamj.InputError, match="must be at most the scenario's duration"):
        unit.step(0.0, 2 * END)
    assert unit.output(lifted) - before == pytest.approx(900.0 / 4500.0, rel=0.02)  # plates and feet give a little
    unit.set_value("mount[2].position[1]", 1e9)
    with pytest.raises(ehamj.InputError, match=r"^mount\[2\]\.position = \[1000000000.0, .*: must be at most"):
        unit.begin()


def test_without_pythonfmu_it_is_refused(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pythonfmu", None)
    assert "pip install 'ehamj[export]'" in cli("export", "benchmark", "--fmu", "unit.fmu").message
    assert not list(Path().iterdir())


@pytest.mark.parametrize(
    ("text", "name", "factor", "exponents"),
    [
        ("m/s²", "m/s2", 1.0, {"m": 1, "s": -2}),
        ("m³/s/mA", "m3/(s.mA)", 1e3, {"m": 3, "s": -1, "A": -1}),
        ("N m", "N.m", 1.0, {"kg": 1, "m": 2, "s": -2}),
        ("m^3/s", "m3/s", 1.0, {"m": 3, "s": -1}),
        ("-", "1", 1.0, {}),
        ("dB", "dB", 1.0, None),
        ("m/s/√Hz", "1", 1.0, {}),
        ("m/s or rad/s", "1", 1.0, {}),
    ],
)
def test_units_are_those_of_fmi(text: str, name: str, factor: float, exponents: dict[str, int] | None) -> None:
    found = unit(text)
    assert (found.name, found.exponents) == (name, exponents)
    assert found.factor == pytest.approx(factor)


@pytest.mark.parametrize("every", [1e-3, 4e-3])
def test_fmpy_simulates_what_a_whole_run_under_the_same_held_commands_does(tmp_path: Path, every: float) -> None:
    """Commands that a Python law holds in a run, from its sample until the next: outputs that do not jump with them."""
    changes = [
        "name='class'",
        "control={kind='passive'}",
        f"duration={END}",
        "compare=[]",
        f"record_rate={1 / every}",
        "plates='tied'",
    ]
    scenario = ehamj.load_scenario("vc-c-floor", changes)
    volts = np.random.default_rng(3).normal(0.0, 0.5, (round(END / every) + 1, 4))
    law = ehamj.PythonController(
        lambda time, measured, limited: volts[round(time / every)], ["stroke front-left"], every, 0.0, bits=None
    )
    whole = observed(scenario, law).dataset
    write_fmu(Subject(scenario), tmp_path / "unit.fmu")
    names = [f"held.command.{mount.replace('-', '_')}" for mount in scenario.plant.mounts]
    held = np.zeros(len(volts), [("time", float), *((name, float) for name in names)])
    held["time"] = every * np.arange(len(volts))
    for name, own in zip(names, volts.T, strict=True):
        held[name] = own
    shown = {"cg_velocity": "xyz", "cg_acceleration": "xyz", "machine_displacement": ["z", "rx", "ry"]}
    shown |= {name: ["front_left", "rear_right"] for name in ("stroke", "spool", "actuator_force")}
    outputs = {f"{name}.{label}": (name, label.replace("_", "-")) for name, labels in shown.items() for label in labels}
    given = {"output_interval": every, "input": held, "output": list(outputs), "stop_time": END}
    found = fmpy.simulate_fmu(str(tmp_path / "unit.fmu"), **given)
    for output, (name, label) in outputs.items():
        wanted = whole[name].sel({whole[name].dims[1]: label}).values
        peak = np.abs(whole[name].values).max()
        np.testing.assert_allclose(found[output], wanted, 0.0, 1e-9 * peak, err_msg=output)


def test_a_reading_of_every_channel_has_its_unit() -> None:
    """What a law may read and no run records, as well."""
    scenario = ehamj.load_scenario("benchmark")
    reader = silent(channel_names(), scenario.plant.mounts, 1e-3)
    units = {one.text: one.unit for one in outputs(scenario, reader) if one.text.startswith("reading of ")}
    assert len(units) == len(channel_names())
    assert units["reading of machine_acceleration rx"] == "rad/s^2"
    assert units["reading of machine_acceleration z"] == "m/s^2"
    assert units["reading of load_pressure front-left"] == "Pa"
    assert units["reading of edges rear-right"] == "mA"
