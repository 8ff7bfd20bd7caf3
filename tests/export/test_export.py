"""What is exported comes out as it was named, whole, beside nothing that was there."""

import json
import shutil
from pathlib import Path

import mujoco
import numpy as np
import pytest
from harness import Cli, sealed_anew

import ehamj
from ehamj.export import formats
from ehamj.export.formats import FORMATS
from ehamj.export.subject import subject_of
from ehamj.result import Result

QUICK = {"duration": 0.01, "plates": "tied", "compare": [], "output": {"report": False, "replay": False}}

SHORT = ("--set", "duration=0.01", "--set", "plates='tied'")


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    """A stored run under a law of its own, and what it was."""
    made = ehamj.simulate({**QUICK, "name": "a run -- 7 kHz", "control": {"kind": "feedforward", "rate": 7000.0}})
    folder = tmp_path_factory.mktemp("runs") / "0001"
    folder.mkdir()
    made.write(folder)
    return folder, made


def test_a_result_is_exported_with_the_law_and_the_step_that_it_ran_with(result: tuple[Path, Result]) -> None:
    folder, made = result
    subject = subject_of(folder)
    assert subject.controller is not None
    assert made.controller is not None
    assert subject.controller.to_dict() == made.controller.to_dict()
    assert subject.timestep == made.summary.timing.timestep_s
    assert subject.name == "a-run-7-kHz"


def test_a_result_that_was_changed_or_is_to_be_is_refused(result: tuple[Path, Result], tmp_path: Path) -> None:
    copy = shutil.copytree(result[0], tmp_path / "copy")
    with pytest.raises(ehamj.InputError, match=r"exported as it is, with its own law; name '.*scenario\.toml'"):
        subject_of(copy, ["machine.mass=5000"])
    sealed_anew(copy, lambda summary: summary.update(python_law=True))
    with pytest.raises(ehamj.InputError, match="its commands came from a Python function, which no file holds"):
        subject_of(copy)
    law = copy / "controller.json"
    law.write_text(law.read_text() + "\n")
    with pytest.raises(ehamj.InputError, match=r"controller\.json is not as its run wrote it"):
        subject_of(copy)


def test_a_design_is_exported_with_exactly_its_law(result: tuple[Path, Result], tmp_path: Path) -> None:
    table = json.loads((result[0] / "controller.json").read_text())
    table["C"] = [[3.0 * value for value in row] for row in table["C"]]
    for name in ("design.json", "design.html"):
        (tmp_path / name).write_text("")
    (tmp_path / "controller.json").write_text(json.dumps(table))
    shutil.copy(result[0] / "scenario.toml", tmp_path)
    found = subject_of(tmp_path).controller
    assert found is not None
    assert found.to_dict()["C"] == table["C"]


def test_the_mjcf_is_the_machine_that_runs(cli: Cli, result: tuple[Path, Result]) -> None:
    said = cli("export", str(result[0]), "--mjcf", "machine.xml", "--json")
    assert list(said.json["files"]) == ["machine.xml"]
    assert "--mjcf=machine.xml" in said.json["files"]["machine.xml"]
    model = mujoco.MjModel.from_xml_path("machine.xml")
    own = mujoco.MjModel.from_xml_string(result[1].model_xml)
    np.testing.assert_array_equal(model.actuator_user, own.actuator_user)
    np.testing.assert_array_equal(model.body_mass, own.body_mass)
    assert model.opt.timestep == pytest.approx(result[1].summary.timing.timestep_s, rel=1e-5)


def test_nothing_is_replaced_unless_asked(cli: Cli) -> None:
    Path("machine.xml").write_text("mine")
    assert "exists already" in cli("export", "benchmark", "--mjcf", "machine.xml").message
    assert Path("machine.xml").read_text() == "mine"
    assert cli("export", "benchmark", "--mjcf", "machine.xml", "--overwrite").code == 0
    assert Path("machine.xml").read_text() != "mine"


def test_what_a_person_put_into_a_folder_of_c_stays(cli: Cli) -> None:
    assert cli("export", "recorded", *SHORT, "--c", "law").code == 0
    law = Path("law")
    (law / "sub").mkdir()
    for name in ("tick.c", "sub/notes"):
        (law / name).write_text("mine")
    (law / "link").symlink_to("tick.c")
    written = (law / "ehamj_law.c").read_text()
    (law / "ehamj_law.c").write_text("changed")
    assert cli("export", "recorded", *SHORT, "--c", "law", "--overwrite").code == 0
    assert (law / "ehamj_law.c").read_text() == written
    assert (law / "tick.c").read_text() == (law / "sub/notes").read_text() == (law / "link").read_text() == "mine"
    assert (law / "link").is_symlink()
    assert [path.name for path in Path().iterdir()] == ["law"]
    (law / "main.c").unlink()
    (law / "main.c").mkdir()
    said = cli("export", "recorded", *SHORT, "--c", "law", "--overwrite")
    assert (said.code, "is a folder where a file is written" in said.message) == (2, True)
    assert (law / "tick.c").is_file()


def test_a_file_within_a_folder_that_is_written_too_is_refused(cli: Cli) -> None:
    for targets in (("--c", "law", "--mjcf", "law/m.xml"), ("--mjcf", "law/../law/sub/m.xml", "--c", "law/")):
        said = cli("export", "recorded", *targets, "--overwrite")
        assert said.code == 2
        assert "--mjcf" in said.message
        assert "which --c writes whole" in said.message


def test_a_format_that_fails_leaves_none_of_the_others(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> formats.Written:
        raise ehamj.InputError("nothing to write")

    monkeypatch.setitem(FORMATS._entries, "other", FORMATS["mjcf"]._replace(write=fail))
    from ehamj.cli.progress import doing
    from ehamj.export.placed import check_targets, export_to

    targets = {"mjcf": Path("one.xml"), "other": Path("two.xml")}
    check_targets(targets, False)
    with doing("x") as progress, pytest.raises(ehamj.InputError, match="nothing to write"):
        export_to(subject_of("benchmark"), targets, False, progress)
    assert not list(Path().iterdir())
    with pytest.raises(ehamj.InputError, match=r"--mjcf writes 'one\.xml' too"):
        check_targets({"mjcf": Path("one.xml"), "other": Path("one.xml")}, False)


def test_without_a_format_all_are_listed(cli: Cli) -> None:
    said = cli("export", "benchmark").message
    assert all(one.option in said for one in FORMATS.values())
