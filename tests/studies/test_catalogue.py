"""Every registered study runs small, tells its units, draws and writes its folder; its settings come back."""

import json
import pkgutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import ehamj.studies
from ehamj.errors import InputError
from ehamj.scenario.load import load_scenario
from ehamj.studies.catalogue import STUDIES
from ehamj.studies.page import write_outcome
from ehamj.studies.study import Study

SCENARIO = load_scenario("recorded", ["plates=tied", "compare=[]"])


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
