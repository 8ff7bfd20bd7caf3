"""Variants that a scenario states itself: what of it is otherwise."""

import tomllib
from pathlib import Path
from typing import Any

import pytest

from ehamj.errors import InputError
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import Scenario
from ehamj.scenario.variants import labels

TABLE: dict[str, Any] = {
    "name": "hall",
    "duration": 0.05,
    "control": {"kind": "combined", "delay": 1.5e-4, "linearisation": {"band": 0.2}},
    "variants": {
        "heavy": {"machine": {"mass": 6000.0}, "mount": {"front-left": {"height": 1e-5}}},
        "plain": {"control": {"linearisation": False}},
        "ahead": {"control": {"kind": "feedforward", "rate": 5000.0}},
    },
    "compare": ["heavy", "plain", "ahead", "passive"],
}


def stored(scenario: Scenario) -> Scenario:
    return parse_scenario(tomllib.loads(scenario.to_toml()))


@pytest.mark.parametrize("read", [lambda one: one, stored], ids=["as written", "as stored"])
def test_a_variant_is_the_scenario_but_for_what_it_states(read: Any) -> None:
    scenario = read(parse_scenario(TABLE))
    own = {name: value for name, value in TABLE.items() if name not in ("variants", "compare")}
    heavy = {"machine": {"mass": 6000.0}, "mount": scenario.variant("heavy").model_dump()["mount"]}
    expected = {
        "heavy": {**own, **heavy},
        "plain": {**own, "control": {"kind": "combined", "delay": 1.5e-4}},  # added to what is there
        "ahead": {**own, "control": {"kind": "feedforward", "rate": 5000.0}},  # a kind begins anew
    }
    for name, table in expected.items():
        whole = parse_scenario({**table, "name": f"hall, {name}"})
        assert stored(scenario.variant(name)) == stored(whole)
    assert [one["height"] for one in heavy["mount"]] == [1e-5, 0.0, 0.0, 0.0]
    assert scenario.variant("passive").control.kind == "passive"


PLACES = {"a": [0.6, 0.4], "b": [0.6, -0.4], "c": [-0.6, 0.0]}


def test_files_that_a_variant_names_lie_beside_the_scenario(tmp_path: Path) -> None:
    file = tmp_path / "scenario.toml"
    file.write_text("[variants.other.control]\nkind = 'law'\nfile = 'law.json'\n")
    assert load_scenario(file).variants["other"]["control"]["file"] == str(tmp_path / "law.json")


def test_they_do_where_the_scenario_says_the_kind(tmp_path: Path) -> None:
    file = tmp_path / "scenario.toml"
    ground = "[ground]\nkind = 'record'\nfile = 'a.csv'\nunit = 'm/s'\n"
    file.write_text(f"{ground}[variants.other.ground]\nfile = 'b.csv'\n")
    assert load_scenario(file).variants["other"]["ground"]["file"] == str(tmp_path / "b.csv")


def test_a_variant_changes_an_actuator_whose_name_has_a_dot() -> None:
    mounts = [{"name": m, "position": p, "actuator": "v2.0"} for m, p in PLACES.items()]
    variants = {"airy": {"actuators": {"v2.0": {"air_fraction": 0.01}}}}
    scenario = parse_scenario({"actuators": {"v2.0": {}}, "mount": mounts, "variants": variants})
    assert scenario.variant("airy").actuators["v2.0"].air_fraction == 0.01


@pytest.mark.parametrize(
    ("variants", "said"),
    [
        ({"a": {"machine": {"mas": 1.0}}}, r"variants\.a: machine\.mas = 1\.0: unknown key; did you mean 'mass'"),
        ({"a": {"control": {"delay": -1.0}}}, r"variants\.a: control\.delay = -1"),
        ({"a": {"duration": 1.0, "compare": ["passive"]}}, r"variants\.a\.compare: cannot differ"),
        ({"a": {"mount": {"middle": {"height": 0.0}}}}, r"variants\.a: mount\.middle\.height.*'front-left'"),
        ({"passive": {}}, r"variants\.passive: is the name of a standard control"),
        ({"result.nc": {}}, r"variants: 'result\.nc' must be letters"),
        ({"figures": {}}, r"variants: 'figures' must be letters"),
        ({"a": {}, "A": {}}, r"variants\.a: another one has this name"),
        ({"../a": {}}, r"'\.\./a' must be letters"),
        ({"a": 3.0}, r"variants\.a = 3\.0: must be a table"),
    ],
)
def test_what_cannot_be_a_variant_is_refused_where_it_stands(variants: Any, said: str) -> None:
    with pytest.raises(InputError, match=said):
        parse_scenario({**TABLE, "compare": [], "variants": variants})


def test_a_name_of_no_variant_is_told_those_that_there_are() -> None:
    with pytest.raises(InputError, match=r"compare\.1 = 'light': must be one of 'heavy', 'plain', 'ahead', 'passive'"):
        parse_scenario({**TABLE, "compare": ["heavy", "light"]})
    with pytest.raises(InputError, match="variant 'light': must be one of 'heavy'"):
        parse_scenario(TABLE).variant("light")


def test_what_stands_side_by_side_is_called_by_what_it_is() -> None:
    hall, other = parse_scenario(TABLE), parse_scenario({"name": "rig", "control": {"kind": "skyhook"}})
    heavy, passive = hall.variant("heavy"), hall.variant("passive")
    assert labels([hall]) == ["combined"]
    assert labels([hall, heavy, passive]) == labels([stored(one) for one in (hall, heavy, passive)])
    assert labels([hall, heavy, passive]) == ["combined", "heavy", "passive"]
    assert labels([passive, hall]) == ["passive", "combined"]
    assert labels([hall, other, passive]) == ["hall", "rig", "hall, passive"]
    held = parse_scenario({"name": "hall"})
    assert labels([held, held.variant("passive")]) == ["hall", "hall, passive"]


def test_folders_tell_apart_what_is_alike() -> None:
    hall, passive = parse_scenario(TABLE), parse_scenario({"name": "hall"})
    folders = [Path("/runs/one/mill"), Path("/runs/two/mill"), Path("/runs/three")]
    assert labels([hall, passive], folders[:2]) == ["combined", "passive"]
    assert labels([hall, hall], folders[1:]) == ["combined (mill)", "combined (three)"]
    assert labels([hall, hall, passive], folders) == ["combined (one/mill)", "combined (two/mill)", "passive"]
