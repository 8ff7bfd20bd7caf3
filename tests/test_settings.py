"""What the program states itself without a validator is what a validator would have made of it."""

from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np
import pytest

from ehamj.control.sensors import IDEAL
from ehamj.ground.floors import FLOORS
from ehamj.isolator.presets import ACTUATOR_PRESETS
from ehamj.plant.mounts import DEFAULT_MOUNTS
from ehamj.records.choices import SILENT
from ehamj.records.table_choices import UNSAID
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings
from ehamj.synthesis.kinds import STANDARD


def classes(of: type[Settings] = Settings) -> Iterator[type[Settings]]:
    for one in of.__subclasses__():
        if one.__module__.startswith("ehamj."):
            yield one
        yield from classes(one)


def settings_in(value: Any) -> Iterator[Settings]:
    if isinstance(value, Settings):
        yield value
        value = tuple(getattr(value, name) for name in type(value).model_fields)
    for entry in value.values() if isinstance(value, dict) else value if isinstance(value, tuple) else ():
        yield from settings_in(entry)


STATED = {
    "controls": tuple(STANDARD.values()),
    "floors": tuple(part for floor in FLOORS.values() for part in floor.parts),
    "presets": tuple(ACTUATOR_PRESETS.values()),
    "others": (*DEFAULT_MOUNTS, IDEAL, SILENT, UNSAID),
    "defaults": tuple(field.default for one in (Scenario, *classes()) for field in one.model_fields.values()),
}


@pytest.mark.parametrize("which", STATED)
def test_what_is_stated_is_valid(which: str) -> None:
    found = list(settings_in(STATED[which]))
    assert len(found) > 3
    for one in found:
        own = {name: getattr(one, name) for name in one.model_fields_set}
        again = type(one).model_validate({type(one).model_fields[name].alias or name: own[name] for name in own})
        assert again == one, type(one).__name__
        assert again.model_fields_set == one.model_fields_set


class Cached(Settings):
    value: float

    @cached_property
    def table(self) -> Any:
        return np.arange(3.0)


def test_settings_are_equal_by_their_values_whatever_they_have_computed() -> None:
    ones = [Cached(value=1.0), Cached(value=1.0), Cached(value=2.0)]
    for one in ones:
        _ = one.table
    assert ones[0] == ones[1]
    assert hash(ones[0]) == hash(ones[1])
    assert ones[1] != ones[2]
    assert ones[0] != 1.0
