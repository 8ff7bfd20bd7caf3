"""Every registered study runs small, tells its units, draws and writes its folder; its settings come back."""

import json
import pkgutil
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ehamj.studies
from ehamj.errors import InputError
from ehamj.plant.mounts import DEFAULT_MOUNTS
from ehamj.scenario.load import changed, load_scenario
from ehamj.studies.catalogue import STUDIES
from ehamj.studies.failed import FailedSettings, at_mount, moving_floor, turns_of
from ehamj.studies.page import write_outcome
from ehamj.studies.study import Study

SCENARIO = load_scenario("recorded", ["plates=tied", "engine=small-motion", "compare=[]"])


@pytest.mark.parametrize("name", STUDIES)
def test_every_study_answers_small(name: str, tmp_path: Path) -> None:
    """Labels and units on everything; a page, a drawing and a table of each name; settings that make it again."""
    study = STUDIES[name]
    settings = study.with_settings(study.small)
    outcome = study(SCENARIO, settings)
    assert outcome.answers
    assert all(answer.endswith(".") and "nan" not in answer.split() for answer in outcome.answers)
    for table in outcome.tables.values():
        for column in table.data_vars.values():
            assert column.attrs["long_name"], column.name
            assert ("units" in column.attrs) == np.issubdtype(column.dtype, np.number), column.name
    write_outcome(tmp_path, name, outcome, SCENARIO)
    files = {path.name for path in tmp_path.iterdir()}
    assert files >= {"study.html", "study.json", "scenario.toml"}
    assert files >= {f"{table}.{kind}" for table in outcome.tables for kind in ("nc", "csv")}
    assert files >= {f"{drawing}.svg" for drawing in outcome.drawings}
    stored = json.loads((tmp_path / "study.json").read_text("utf-8"))
    assert study.with_settings(stored["settings"]) == settings
    assert load_scenario(tmp_path / "scenario.toml") == SCENARIO


THREE: list[dict[str, Any]] = [
    {"name": "nose", "position": [0.9, 0.0]},
    {"name": "left", "position": [-0.8, 0.6]},
    {"name": "right", "position": [-0.8, -0.6]},
]
LEVEL: list[dict[str, Any]] = [
    {"name": "bow", "position": [0.9, 0.0], "direction": [0, 1, 0]},
    {"name": "stern", "position": [-0.9, 0.0], "direction": [0, 1, 0]},
    {"name": "port", "position": [0.0, 0.6], "direction": [1, 0, 0]},
    {"name": "starboard", "position": [0.0, -0.6, 0.2], "direction": [1, 0, 0]},
]
LAYOUTS = {"three": THREE, "eight in six directions": [*(mount.model_dump() for mount in DEFAULT_MOUNTS), *LEVEL]}
REFUSED = {
    ("soft-mounts", "eight in six directions"): r"mount bow: .*needs upright mounts in the mount plane.*'rocking'"
}


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("name", STUDIES)
def test_every_study_answers_for_any_mounts(name: str, layout: str) -> None:
    """Its answers are words and numbers, or it is refused in words that say what it needs."""
    # A law that has no loop: margins of eight loops would take most of the time.
    table = {"mount": LAYOUTS[layout], "control": {"kind": "feedforward"}}
    study, scenario = STUDIES[name], changed(SCENARIO, table)
    small = dict(study.small) | ({"number": 1} if name == "tolerances" else {})
    if refusal := REFUSED.get((name, layout)):
        with pytest.raises(InputError, match=refusal):
            study(scenario, study.with_settings(small))
        return
    outcome = study(scenario, study.with_settings(small))
    assert outcome.answers
    for answer in outcome.answers:
        assert not {"nan", "inf", "-0.0", "four"} & set(re.split(r"[\s,;:]+", answer)), answer
    mounts = set(scenario.plant.mounts)
    assert all(set(one["mount"].values) <= mounts for one in outcome.tables.values() if "mount" in one.coords)


def test_a_level_mount_fails_beside_a_floor_that_sways() -> None:
    """Its floor moves along it, yaw counts, and passive mounts cannot fail."""
    tables = {"mount": LAYOUTS["eight in six directions"], "actuators": {"isolator": {}}}
    scenario = changed(SCENARIO, tables | {"control": {"kind": "passive"}})
    assert moving_floor(scenario, "bow") == "y"
    assert turns_of(scenario.plant) == ("rx", "ry", "rz")
    settings = FailedSettings(mount="bow", failures=("membrane only",), lines=(20.0,))
    outcome = STUDIES["failed-actuator"](scenario, settings)
    assert "one of its 8 actuators, at bow" in outcome.question
    assert "a floor that moves along y at 20 Hz" in outcome.answers[0]
    # Without a law nothing is quantised: the step's error alone.
    assert outcome.numbers["largest_difference"] < 1e-4
    own = {"rear-right": {"actuator": "spring"}}
    spring = [one | own.get(one["name"], {}) for one in tables["mount"]]
    passive = {"mount": spring, "actuators": {"isolator": {}, "spring": {"preset": "elastic-mount"}}}
    with pytest.raises(InputError, match=r"'rear-right' \(it is passive\): must be one of front-left"):
        at_mount(changed(scenario, passive), "rear-right")


def studies_in(module: str) -> list[Study[Any]]:
    """Studies that a module of the room defines."""
    __import__(module)
    return [one for one in vars(sys.modules[module]).values() if isinstance(one, Study)]


def test_every_study_of_the_room_is_registered() -> None:
    modules = [f"ehamj.studies.{found.name}" for found in pkgutil.iter_modules(ehamj.studies.__path__)]
    assert {one.name for module in modules for one in studies_in(module)} == set(STUDIES)


@pytest.mark.parametrize("name", STUDIES)
def test_every_setting_says_what_it_is(name: str) -> None:
    """Its description is what --help shows."""
    for key, field in STUDIES[name].settings.model_fields.items():
        assert field.description, f"{name}: {key}"


def test_an_unknown_setting_is_refused() -> None:
    with pytest.raises(InputError, match=r"no_such = 1: unknown key.*points"):
        STUDIES["lateral"].with_settings({"no_such": 1})
