"""Mounts that have any name, and what calls them by it: one message says where a name is left that no mount has."""

import tomllib
from typing import Any

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.scenario.load import parse_scenario

PLACES = {"north": [0.9, 0.6], "east": [0.9, -0.6], "south-west": [-0.9, 0.0]}
MOUNTS = [{"name": name, "position": at} for name, at in PLACES.items()]


def calling(mount: str) -> dict[str, Any]:
    """Everything that may call a mount by its name."""
    signals = [{"kind": "step", "amplitude": 0.1, "mounts": ["north", mount]}]
    record = {"kind": "record", "file": "floor.csv", "axes": {"a": "x", "b": f"{mount} z", "c.d": f"{mount} y"}}
    return {
        "mount": MOUNTS,
        "control": {"kind": "open-loop", "signals": signals},
        "ground": {"kind": "sum", "parts": [{"kind": "rest"}, record]},
        "fault": [
            {"kind": "valve-stuck", "mount": mount, "time": 1.0},
            {"kind": "sensor-dead", "sensor": f"foot_velocity {mount} z", "time": 2.0},
            {"kind": "sensor-dead", "sensor": "cg_velocity z", "time": 2.0},
        ],
        "relative": [{"name": "laser", "from": "spindle-nose", "to": f"ground {mount}"}],
    }


def test_everything_takes_the_scenarios_own_names() -> None:
    scenario = parse_scenario(calling("south-west"))
    assert parse_scenario(tomllib.loads(scenario.to_toml())).plant.mounts == tuple(PLACES)


def test_a_name_that_is_left_is_told_once_with_every_place_where_it_stands() -> None:
    with pytest.raises(InputError) as caught:
        parse_scenario(calling("rear-left"))
    assert str(caught.value) == (
        "no mount has this name: 'rear-left' in ground.parts.1.axes.b, ground.parts.1.axes.\"c.d\", "
        "control.signals.0.mounts, fault.0.mount, fault.1.sensor, relative.0.to; [[mount]] has north, east, south-west"
    )


@pytest.mark.parametrize(
    ("table", "told"),
    [
        ({"points": {"north": [0.0, 0.0, 1.0]}}, "points: the name 'north' must .* not be one of .*north"),
        ({"relative": [{"name": "east", "from": "cg", "to": "ground east"}]}, "relative.0.name: the name 'east' must"),
        ({"mount": [*MOUNTS[:2], {**MOUNTS[2], "name": "my mount"}]}, "mount.2.name = 'my mount': must consist of"),
        ({"mount": [*MOUNTS[:2], {**MOUNTS[2], "name": "cg"}]}, "mount.2.name = 'cg': must .* not be one of"),
        (
            {"ground": {"kind": "record", "file": "a.csv", "axes": {"1": "north up"}}},
            "ground.axes.1 = 'north up': must be one of x, y, z, or that of one mount by its name",
        ),
    ],
)
def test_names_that_cannot_be_told_apart_are_refused(table: dict[str, Any], told: str) -> None:
    with pytest.raises(InputError, match=told):
        parse_scenario({"mount": MOUNTS, **table})


def test_a_command_without_mounts_is_for_all_of_them() -> None:
    control = {"kind": "open-loop", "signals": [{"kind": "step", "amplitude": 0.1}]}
    commands = parse_scenario({"mount": MOUNTS, "control": control}).commands()
    assert len(commands) == 3
    assert [one.sample(np.ones(1))[0].item() for one in commands] == [0.1] * 3
