"""Scenarios: reading, presets and overrides, writing back complete, and one clear message for every bad input."""

import json
import math
import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from ehamj.errors import InputError
from ehamj.isolator.presets import FIRST_GENERATION, RECOMMENDED
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.load import changed, load_scenario, parse_scenario, scenario_schema, shipped_scenarios
from ehamj.scenario.model import Scenario

CORNERS = {"front-left": [0.9, 0.6], "front-right": [0.9, -0.6], "rear-left": [-0.9, 0.6], "rear-right": [-0.9, -0.6]}


def mounts(**changes: Any) -> list[dict[str, Any]]:
    """The four mounts as tables; ``front_left={...}`` changes keys of one."""
    return [
        {"name": name, "position": list(at), **changes.get(name.replace("-", "_"), {})} for name, at in CORNERS.items()
    ]


def refusal(table: dict[str, Any]) -> str:
    with pytest.raises(InputError) as caught:
        parse_scenario(table)
    return str(caught.value)


def written(folder: Path, text: str, name: str = "machine.toml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


# --- what ships ---------------------------------------------------------------------------------------------------


def test_what_ships() -> None:
    assert {"benchmark", "recorded"} <= set(shipped_scenarios())


@pytest.mark.parametrize("name", shipped_scenarios())
def test_shipped_scenarios_load_by_name_and_say_what_they_are(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario.name == name
    assert len(scenario.description) > 20
    assert "\n" not in scenario.description


def test_shipped_benchmark_is_the_stated_case() -> None:
    # Typed from the benchmark's definition.
    plant = load_scenario("benchmark").plant
    assert (plant.total_mass, plant.gravity, plant.plates) == (4056.0, 0.0, "tied")
    assert (plant.machine.inertia, plant.machine.cg) == ((2000.0, 3000.0, 4000.0), (0.0, 0.0, 0.6))
    assert plant.positions == tuple((x, y, 0.0) for x, y in CORNERS.values())
    assert (plant.supply.pressure, plant.supply.tank_pressure) == (210e5, 0.0)
    for actuator in plant.actuators:
        assert (actuator.cross_leakage, actuator.edge_leakage, actuator.moving_volume) == (6.6e-11, 0.0, False)
        assert (actuator.valve_gain, actuator.spool_drive_limit) == (1.0, math.inf)


def test_a_scenario_of_nothing_is_the_default_machine() -> None:
    plant = parse_scenario({}).plant
    assert plant.total_mass == 4056.0
    for actuator in plant.actuators:
        assert actuator.model_dump(exclude={"preset", "oil", "valve"}) == FIRST_GENERATION.model_dump()


# --- presets and mounts -------------------------------------------------------------------------------------------


def test_preset_fills_what_is_not_given() -> None:
    table = {"actuators": {"isolator": {"preset": "recommended", "piston_area": 0.05}}}
    actuator = parse_scenario(table).actuators["isolator"]
    assert (actuator.piston_area, actuator.sources["piston_area"]) == (0.05, "given")
    for name in set(RECOMMENDED.quantities()) - {"piston_area"}:
        assert (getattr(actuator, name), actuator.sources[name]) == (
            getattr(RECOMMENDED, name),
            RECOMMENDED.sources[name],
        )


def test_a_valve_changes_nothing_but_the_valve_and_says_that_it_is_assumed() -> None:
    """Whatever cylinder and oil it is fitted to; a value that is given stays, and another valve takes all away."""
    real = {"preset": "recommended", "oil": "mineral", "valve": "proportional", "threshold": 0.01}
    scenario = parse_scenario({"actuators": {"isolator": real}})
    one = scenario.actuators["isolator"]
    own = {"overlap": (0.4,) * 4, "hysteresis": 0.1}
    assert {name: getattr(one, name) for name in own} == own
    assert (one.threshold, one.sources["threshold"], one.sources["overlap"]) == (0.01, "given", "assumed")
    assert [one.flow_curve[k] for k in (0, 1, 10)] == [(0.0, 0.0), (0.1, 0.064), (1.0, 1.0)]
    ideal = changed(scenario, {"actuators.isolator.valve": "paper"}).actuators["isolator"]
    assert ideal == parse_scenario({"actuators": {"isolator": {**real, "valve": "paper"}}}).actuators["isolator"]
    other = {name for name in type(one).model_fields if getattr(one, name) != getattr(ideal, name)}
    assert other == {"overlap", "hysteresis", "flow_curve", "valve"}


def test_a_value_of_the_other_preset_is_given() -> None:
    table = {"actuators": {"isolator": {"preset": "recommended", "piston_area": FIRST_GENERATION.piston_area}}}
    assert parse_scenario(table).actuators["isolator"].piston_area == FIRST_GENERATION.piston_area


def test_each_mount_may_have_its_own_actuator() -> None:
    table = {
        "mount": mounts(rear_left={"actuator": "strong"}, front_left={"actuator": "weak"}),
        "actuators": {"isolator": {}, "weak": {"bulk_modulus": 1e9}, "strong": {"preset": "recommended"}},
    }
    areas = [(actuator.piston_area, actuator.bulk_modulus) for actuator in parse_scenario(table).plant.actuators]
    assert areas == [(3.18e-2, 1e9), (3.18e-2, 1.4e9), (6.36e-2, 1.4e9), (3.18e-2, 1.4e9)]


@given(st.permutations(mounts()))
def test_the_order_in_which_mounts_are_written_does_not_matter(order: list[dict[str, Any]]) -> None:
    assert parse_scenario({"mount": order}).plant.positions == tuple((x, y, 0.0) for x, y in CORNERS.values())


# --- overrides ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("override", "read", "value"),
    [
        ("machine.mass=4500", lambda s: s.machine.mass, 4500.0),
        (" machine.mass = 4_500.0 ", lambda s: s.machine.mass, 4500.0),
        ("plates=sliding", lambda s: s.plates, "sliding"),
        ('plates="sliding"', lambda s: s.plates, "sliding"),
        ("name=two words, a = sign and # hash", lambda s: s.name, "two words, a = sign and # hash"),
        ("timestep=0.0001", lambda s: s.timestep, 0.0001),
        ("timestep=auto", lambda s: s.timestep, "auto"),
        ("actuators.isolator.foot_stiffness=inf", lambda s: s.plant.actuators[0].foot_stiffness, math.inf),
        ("actuators.isolator.preset=recommended", lambda s: s.plant.actuators[0].piston_area, 6.36e-2),
        ("machine.cg=[0.1, -0.2, 0.5]", lambda s: s.machine.cg, (0.1, -0.2, 0.5)),
        ("machine.cg.2=0.5", lambda s: s.machine.cg, (0.0, 0.0, 0.5)),
        ("control.signals.2.amplitude=0.25", lambda s: s.control.signals[2].amplitude, 0.25),
        ("control.signals.1.mounts=['rear-left']", lambda s: s.control.signals[1].mounts, ("rear-left",)),
        ("control={kind='passive'}", lambda s: s.control.kind, "passive"),
        ("ground.kind=sine", lambda s: s.ground.kind, "sine"),
        ("mount.3.position=[-0.8, -0.5]", lambda s: s.plant.positions[3], (-0.8, -0.5, 0.0)),
        ("mount.3.position.0=-0.8", lambda s: s.plant.positions[3], (-0.8, -0.6, 0.0)),
    ],
)
def test_override(override: str, read: Any, value: Any) -> None:
    assert read(load_scenario("benchmark", [override])) == value


def test_later_overrides_win() -> None:
    assert load_scenario("benchmark", ["machine.mass=1", "machine.mass=2"]).machine.mass == 2.0


def test_an_override_adds_a_table() -> None:
    scenario = load_scenario("benchmark", ["actuators.soft.membrane_stiffness=1e8", "mount.0.actuator=soft"])
    assert [actuator.membrane_stiffness for actuator in scenario.plant.actuators] == [1e8, 6.8e8, 6.8e8, 6.8e8]


def test_an_overridden_value_is_given_also_in_a_resolved_scenario(tmp_path: Path) -> None:
    path = written(tmp_path, parse_scenario({}).to_toml())
    machine = load_scenario(path, ["machine.mass=4500"]).machine
    assert (machine.sources["mass"], machine.sources["inertia"]) == ("given", "assumed")


@pytest.mark.parametrize(
    ("override", "parts"),
    [
        ("machine.mass", ["key=value", "machine.mass=4500"]),
        ("=4500", ["key=value"]),
        ("machine..mass=4500", ["key=value"]),
        (".=1", ["key=value"]),
        ("machine.mass.kg=4500", ["machine.mass is a value, not a table"]),
        ("control.signals.4.amplitude=1", ["'4'", "index from 0 to 3"]),
        ("control.signals.first.amplitude=1", ["'first'", "index from 0 to 3"]),
        ("control.signals.-1.amplitude=1", ["'-1'", "index from 0 to 3"]),
        ("machine.cg.3=1", ["'3'", "index from 0 to 2"]),
    ],
)
def test_bad_form_of_an_override(override: str, parts: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        load_scenario("benchmark", ["machine.cg=[0.0, 0.0, 0.6]", override])
    for part in [repr(override), *parts]:
        assert part in str(caught.value)


def test_changed_values_are_as_overridden_ones() -> None:
    own = load_scenario("benchmark")
    values = {"machine.mass": 4500.0, "mount.2.position": (-0.8, 0.6), "machine.size": (2.4, 1.6, 1.9)}
    overrides = ["machine.mass=4500.0", "mount.2.position=[-0.8, 0.6]", "machine.size=[2.4, 1.6, 1.9]"]
    assert changed(own, values) == load_scenario("benchmark", overrides)
    assert changed(own, {}) == own


def test_changed_values_are_checked() -> None:
    with pytest.raises(InputError, match=r"machine\.mass = -1\.0: .*greater than 0"):
        changed(parse_scenario({}), {"machine.mass": -1.0})
    with pytest.raises(InputError, match=r"machine\.cg\.3 = 1\.0: '3' must be an index from 0 to 2"):
        changed(parse_scenario({}), {"machine.cg.3": 1.0})


def test_an_override_cannot_smuggle_in_a_second_key() -> None:
    with pytest.raises(InputError, match=r"machine\.mass = "):
        load_scenario("benchmark", ["machine.mass=4500\nduration=1"])


# --- files --------------------------------------------------------------------------------------------------------


def test_file_of_a_record_is_relative_to_the_scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    path = written(tmp_path, '[ground]\nkind = "record"\nfile = "floor.csv"\n')
    assert load_scenario(path).ground.file == str(tmp_path / "floor.csv")  # type: ignore[union-attr]
    assert load_scenario("../machine.toml").ground.file == str(tmp_path / "floor.csv")  # type: ignore[union-attr]


def test_file_of_a_record_in_an_override_is_relative_to_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    overrides = ["ground.file=floor.csv"]
    assert load_scenario("recorded", overrides).ground.file == str(tmp_path / "floor.csv")  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("table", "key"),
    [
        ('[ground]\nkind = "record"\nfile = "r"\ninventory = "a"', ("ground", "inventory")),
        ('[ground]\nkind = "shaped"\ntarget = { kind = "file", file = "a" }', ("ground", "target", "file")),
        ('[[ground.parts]]\nkind = "record"\nfile = "a"\n[ground]\nkind = "sum"', ("ground", "parts", 0, "file")),
        ('[control]\nkind = "law"\nfile = "a"', ("control", "file")),
    ],
)
def test_every_file_is_relative_to_the_scenario(tmp_path: Path, table: str, key: tuple[str | int, ...]) -> None:
    found: Any = load_scenario(written(tmp_path, table)).model_dump()
    for part in key:
        found = found[part]
    assert found == str(tmp_path / "a")


def test_the_example_record_is_no_file() -> None:
    assert load_scenario("recorded").ground.file == "example:BW.RJOB"  # type: ignore[union-attr]


def test_missing_scenario_names_what_ships(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"'recordet': no such file.*benchmark.*recorded"):
        load_scenario("recordet")
    with pytest.raises(InputError, match="no such file"):
        load_scenario(tmp_path)


def test_invalid_toml_says_where(tmp_path: Path) -> None:
    path = written(tmp_path, "duration = 1.0\n[machine\nmass = 1.0\n")
    with pytest.raises(InputError, match=r"machine\.toml: not valid TOML: .*line 2"):
        load_scenario(path)


def test_a_file_that_is_not_text_cannot_be_read(tmp_path: Path) -> None:
    path = tmp_path / "machine.toml"
    path.write_bytes(b"\x89HDF\r\n\x1a\n\xff\xfe")
    with pytest.raises(InputError, match=r"machine\.toml: cannot be read"):
        load_scenario(path)


# --- resolved scenario --------------------------------------------------------------------------------------------

number = st.floats(1e-2, 1e3)  # within what every unit allows
actuator_tables = st.fixed_dictionaries(
    {},
    optional={
        "preset": st.sampled_from(["first-generation", "recommended"]),
        "piston_area": number,
        "plate_mass": number,
        "moving_volume": st.booleans(),
        "foot_stiffness": st.one_of(number, st.just(math.inf)),
        "edge_leakage_share": st.floats(0, 1),
    },
)
signals = st.one_of(
    st.fixed_dictionaries(
        {"kind": st.just("sine"), "amplitude": number, "frequency": number}, optional={"phase": st.floats(-7, 7)}
    ),
    st.fixed_dictionaries(
        {"kind": st.just("multisine"), "amplitude": number, "frequencies": st.lists(number, min_size=1, max_size=3)}
    ),
    st.fixed_dictionaries(
        {"kind": st.just("step"), "amplitude": number, "start": st.floats(-1, 1)},
        optional={"mounts": st.lists(st.sampled_from(MOUNTS), min_size=1, max_size=4)},
    ),
    st.fixed_dictionaries(
        {"kind": st.just("chirp"), "amplitude": number, "first": number, "last": number, "sweep_time": number}
    ),
)
grounds = st.one_of(
    st.just({"kind": "rest"}),
    st.fixed_dictionaries(
        {"kind": st.just("sine")},
        optional={"dof": st.sampled_from(["x", "y", "z", "rx", "ry", "rz"]), "frequency": number, "amplitude": number},
    ),
    st.fixed_dictionaries(
        {"kind": st.just("record"), "file": st.just("example:BW.RJOB")},
        optional={"scale": number, "start": number, "pre_filter": st.just([0.1, 0.2, 30.0, 40.0])},
    ),
)
tables = st.fixed_dictionaries(
    {},
    optional={
        "name": st.text(st.characters(codec="utf-8"), min_size=1),
        "description": st.text(st.characters(codec="utf-8")),
        "duration": number,
        "seed": st.integers(0, 2**40),
        "timestep": st.one_of(st.just("auto"), number),
        "record_rate": number,
        "plates": st.sampled_from(["sliding", "tied"]),
        "machine": st.fixed_dictionaries({}, optional={"mass": number, "cg": st.just([0.1, 0, 0.5])}),
        "actuators": st.fixed_dictionaries({"isolator": actuator_tables}),
        "mount": st.permutations(mounts()),
        "supply": st.fixed_dictionaries({}, optional={"pressure": st.floats(1.0, 1e8)}),
        "ground": grounds,
        "control": st.one_of(
            st.just({"kind": "passive"}),
            st.fixed_dictionaries({"kind": st.just("open-loop"), "signals": st.lists(signals, min_size=1, max_size=3)}),
        ),
        "output": st.fixed_dictionaries({}, optional={"replay": st.booleans(), "exaggeration": number}),
    },
)


@given(tables)
def test_resolved_scenario_is_a_fixed_point(table: dict[str, Any]) -> None:
    scenario = parse_scenario(table)
    text = scenario.to_toml()
    again = parse_scenario(tomllib.loads(text))
    assert again == scenario
    assert again.to_toml() == text


@given(tables)
def test_resolved_scenario_holds_what_was_written(table: dict[str, Any]) -> None:
    def check(wanted: Any, found: Any) -> None:
        if isinstance(wanted, dict):
            for key, value in wanted.items():
                check(value, found[key])
        elif isinstance(wanted, list):
            assert len(wanted) == len(found)
            for one, other in zip(wanted, found, strict=True):
                check(one, other)
        else:
            assert found == wanted

    check(table, tomllib.loads(parse_scenario(table).to_toml()))


def test_resolved_scenario_is_complete() -> None:
    resolved = tomllib.loads(parse_scenario({}).to_toml())
    assert set(resolved) >= {"name", "duration", "seed", "gravity", "timestep", "record_rate", "plates"}
    assert set(resolved["machine"]) == {"mass", "inertia", "cg", "size", "sources"}
    assert set(resolved["actuators"]["isolator"]) > set(FIRST_GENERATION.quantities())
    assert [mount["name"] for mount in resolved["mount"]] == list(MOUNTS)


@pytest.mark.parametrize("name", shipped_scenarios())
def test_resolved_file_loads_from_anywhere(name: str, tmp_path: Path) -> None:
    scenario = load_scenario(name)
    assert load_scenario(written(tmp_path, scenario.to_toml())) == scenario


def test_using_a_scenario_does_not_change_it() -> None:
    used, fresh = load_scenario("benchmark"), load_scenario("benchmark")
    used.plant, used.commands(), used.motion()
    assert used == fresh
    assert used.to_toml() == fresh.to_toml()


# --- bad input ----------------------------------------------------------------------------------------------------

RECORD = {"kind": "record", "file": "floor.csv"}
SINE = {"kind": "sine", "amplitude": 1.0, "frequency": 5.0}


def driven(**changes: Any) -> dict[str, Any]:
    return {"control": {"kind": "open-loop", "signals": [{**SINE, **changes}]}}


BAD: dict[str, tuple[dict[str, Any], list[str]]] = {
    "unknown top key": ({"durration": 5}, ["durration = 5", "did you mean 'duration'", "timestep", "ground"]),
    "unknown key": ({"machine": {"mas": 5}}, ["machine.mas = 5", "did you mean 'mass'", "inertia, cg, size"]),
    "unknown key, nothing near": ({"machine": {"colour": 5}}, ["machine.colour = 5", "allowed: ", "mass"]),
    "unknown actuator key": (
        {"actuators": {"isolator": {"piston_aera": 1}}},
        ["actuators.isolator.piston_aera = 1", "did you mean 'piston_area'"],
    ),
    "unknown mount key": (
        {"mount": mounts(front_left={"shim": 1})},
        ["mount.0.shim = 1", "name, position, direction, height, actuator"],
    ),
    "unknown ground key": ({"ground": {"kind": "sine", "freq": 1}}, ["ground.freq = 1", "did you mean 'frequency'"]),
    "unknown key in what may be left out": (
        {"ground": {"kind": "sine", "wave": {"sped": 200.0}}},
        ["ground.wave.sped = 200.0", "did you mean 'speed'"],
    ),
    "unknown signal key": (driven(amplitud=1), ["control.signals.0.amplitud = 1", "did you mean 'amplitude'"]),
    "text for a number": ({"machine": {"mass": "4000"}}, ["machine.mass = '4000'", "number"]),
    "truth for a number": ({"machine": {"mass": True}}, ["machine.mass = True", "number"]),
    "date for a number": (tomllib.loads("duration = 2020-01-01"), ["duration = ", "2020", "number"]),
    "number for text": ({"name": 5}, ["name = 5", "string"]),
    "number for truth": ({"output": {"replay": 1}}, ["output.replay = 1", "boolean"]),
    "fraction for a count": ({"seed": 1.5}, ["seed = 1.5", "integer"]),
    "value for a table": ({"machine": 5}, ["machine = 5", "table"]),
    "value for the ground": ({"ground": "rest"}, ["ground = 'rest'", "table"]),
    "value for an actuator": ({"actuators": {"isolator": 5}}, ["actuators.isolator = 5", "table"]),
    "value for actuators": ({"actuators": 5}, ["actuators = 5", "table"]),
    "value for sources": ({"machine": {"sources": 5}}, ["machine.sources = 5", "table"]),
    "value for an actuator's sources": (
        {"actuators": {"isolator": {"sources": 5}}},
        ["actuators.isolator.sources = 5", "table"],
    ),
    "table for a list": ({"mount": {"a": 1}}, ["mount = {'a': 1}", "list"]),
    "list too short": ({"machine": {"cg": [0, 0]}}, ["machine.cg = [0, 0]", "entry 3 is missing"]),
    "list too long": ({"machine": {"cg": [0, 0, 1, 1]}}, ["machine.cg = [0, 0, 1, 1]", "at most 3"]),
    "wrong entry": ({"machine": {"cg": [0, "left", 1]}}, ["machine.cg.1 = 'left'", "number"]),
    "negative mass": ({"machine": {"mass": -4.0}}, ["machine.mass = -4.0", "greater than 0"]),
    "not a number": ({"machine": {"mass": math.nan}}, ["machine.mass = nan", "finite"]),
    "infinite mass": ({"machine": {"mass": math.inf}}, ["machine.mass = inf", "finite"]),
    "zero duration": ({"duration": 0}, ["duration = 0", "greater than 0"]),
    "negative seed": ({"seed": -1}, ["seed = -1", "greater than or equal to 0"]),
    "negative gravity": ({"gravity": -9.81}, ["gravity = -9.81", "greater than or equal to 0"]),
    "zero rate": ({"record_rate": 0}, ["record_rate = 0", "greater than 0"]),
    "negative step": ({"timestep": -1e-3}, ["timestep = -0.001", "greater than 0", "'auto'"]),
    "step in words": ({"timestep": "small"}, ["timestep = 'small'", "number", "'auto'"]),
    "negative exaggeration": ({"output": {"exaggeration": -1}}, ["output.exaggeration = -1", "greater than 0"]),
    "unknown plates": ({"plates": "glued"}, ["plates = 'glued'", "'sliding'", "'tied'"]),
    "empty name": ({"name": ""}, ["name = ''", "at least 1 character"]),
    "no body's inertia": ({"machine": {"inertia": [1, 1, 3]}}, ["machine", "inertia = [1.0, 1.0, 3.0]", "sum"]),
    "cg outside": ({"machine": {"cg": [9, 0, 0]}}, ["machine", "cg = [9.0, 0.0, 0.0]", "size = [2.2, 1.6, 1.9]"]),
    "supply below the tank": (
        {"supply": {"pressure": 1e5, "tank_pressure": 2e5}},
        ["supply", "pressure = 100000", "tank_pressure = 200000"],
    ),
    "mount outside": (
        {"mount": mounts(front_left={"position": [1.5, 0.6]})},
        ["front-left", "position = [1.5, 0.6]", "±1.1 by ±0.8 m"],
    ),
    "machine too small for its mounts": ({"machine": {"size": [1, 2, 2]}}, ["front-left", "±0.5 by ±1 m"]),
    "mount with a wrong name": (
        {"mount": mounts(front_left={"name": "front left"})},
        ["mount.0.name = 'front left'", "32 letters, digits"],
    ),
    "mount named twice": ({"mount": mounts(front_left={"name": "rear-left"})}, ["rear-left", "must be unique"]),
    "two mounts": ({"mount": mounts()[2:]}, ["mount: there are 2", "3 to 32"]),
    "mount without position": ({"mount": [{"name": "front-left"}, *mounts()[1:]]}, ["mount.0.position", "missing"]),
    "front and rear swapped": (
        {"mount": [{**m, "position": [-m["position"][0], m["position"][1]]} for m in mounts()]},
        ["x of the front mounts", "larger"],
    ),
    "left and right swapped": (
        {"mount": [{**m, "position": [m["position"][0], -m["position"][1]]} for m in mounts()]},
        ["y of the left mounts", "larger"],
    ),
    "unknown actuator": (
        {"mount": mounts(rear_left={"actuator": "strong"})},
        ["rear-left", "actuator = 'strong'", "isolator"],
    ),
    "unknown preset": (
        {"actuators": {"isolator": {"preset": "second"}}},
        ["actuators.isolator.preset = 'second'", "'first-generation'", "'recommended'"],
    ),
    "list for a preset": (
        {"actuators": {"isolator": {"preset": [1]}}},
        ["actuators.isolator.preset = [1]", "'first-generation'", "'recommended'"],
    ),
    "unknown source": (
        {"machine": {"sources": {"mass": "guess"}}},
        ["machine.sources.mass = 'guess'", "'paper'", "'given'"],
    ),
    "unknown ground": ({"ground": {"kind": "shake"}}, ["ground.kind = 'shake'", "'rest'", "'sine'", "'record'"]),
    "ground without kind": ({"ground": {"dof": "z"}}, ["ground.kind", "missing", "'rest'", "'sine'", "'record'"]),
    "unknown control": ({"control": {"kind": "magic"}}, ["control.kind = 'magic'", "'passive'", "'open-loop'"]),
    "control without kind": ({"control": {}}, ["control.kind", "missing", "'passive'", "'open-loop'"]),
    "unknown signal": (driven(kind="noise"), ["control.signals.0.kind = 'noise'", "'sine'", "'chirp'"]),
    "no signals": ({"control": {"kind": "open-loop", "signals": []}}, ["control.signals = []", "at least 1"]),
    "signal without frequency": (
        {"control": {"kind": "open-loop", "signals": [{"kind": "sine", "amplitude": 1.0}]}},
        ["control.signals.0.frequency", "missing"],
    ),
    "signal on an unknown mount": (
        driven(mounts=["middle"]),
        ["'middle' in control.signals.0.mounts", *MOUNTS],
    ),
    "signal on no mount": (driven(mounts=[]), ["control.signals.0.mounts = []", "at least 1"]),
    "record without file": ({"ground": {"kind": "record"}}, ["ground.file", "missing"]),
    "record with an empty name": ({"ground": {**RECORD, "file": ""}}, ["ground.file = ''", "at least 1 character"]),
    "record on an unknown axis": ({"ground": {**RECORD, "axes": {"E": "q"}}}, ["ground.axes.E = 'q'", "x, y, z"]),
    "falling band": ({"ground": {**RECORD, "pre_filter": [4, 3, 2, 1]}}, ["ground", "pre_filter = [4", "rising"]),
}


@pytest.mark.parametrize(("table", "parts"), BAD.values(), ids=BAD)
def test_bad_input_names_key_value_and_what_is_allowed(table: dict[str, Any], parts: list[str]) -> None:
    message = refusal(table)
    for part in parts:
        assert part in message


@pytest.mark.parametrize(("table", "parts"), BAD.values(), ids=BAD)
def test_messages_are_for_people(table: dict[str, Any], parts: list[str]) -> None:
    message = refusal(table)
    assert len(message.splitlines()) == 1
    assert not re.search(
        r"pydantic|Traceback|https?:|validation|Input should|[Tt]uple|constrained|literal\[|\bTag\b", message
    )


def test_several_faults_are_all_named() -> None:
    lines = refusal({"machine": {"mass": -1}, "supply": {"pressure": 0}, "sead": 1}).splitlines()
    assert [line.split(" ")[0] for line in lines] == ["machine.mass", "supply.pressure", "sead"]


def test_an_actuator_may_be_named_like_a_kind() -> None:
    assert "actuators.step.piston_area = -1" in refusal({"actuators": {"step": {"piston_area": -1}}})


def test_bad_files_are_bad_input_too(tmp_path: Path) -> None:
    path = written(tmp_path, "[machine]\nmass = -4.0\n")
    with pytest.raises(InputError, match=r"machine\.mass = -4\.0: must be greater than 0"):
        load_scenario(path)


keys = st.sampled_from(
    [
        "name",
        "duration",
        "seed",
        "timestep",
        "machine",
        "mass",
        "cg",
        "size",
        "sources",
        "mount",
        "position",
        "actuator",
        "actuators",
        "isolator",
        "preset",
        "piston_area",
        "supply",
        "pressure",
        "ground",
        "kind",
        "file",
        "axes",
        "dof",
        "control",
        "signals",
        "amplitude",
        "frequencies",
        "mounts",
        "output",
        "exaggeration",
        "nonsense",
    ]
)
words = st.sampled_from(
    ["rest", "sine", "record", "passive", "open-loop", "step", "auto", "recommended", "front-left", ""]
)
values = st.recursive(
    st.one_of(words, st.integers(-3, 3), st.floats(), st.booleans()),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(keys, inner, max_size=4)),
    max_leaves=12,
)


def outcome(read: Callable[[], Scenario]) -> Scenario | str:
    """A scenario, or the message of an InputError; anything else that is raised fails the test."""
    try:
        return read()
    except InputError as error:
        return str(error)


@given(st.dictionaries(keys, values, max_size=5))
def test_any_table_is_a_scenario_or_bad_input(table: dict[str, Any]) -> None:
    assert outcome(lambda: parse_scenario(table))


def places(node: Any, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    """Every place in nested tables and lists."""
    inside = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    return [path] * bool(path) + [deeper for key, value in inside for deeper in places(value, (*path, key))]


WHOLE = load_scenario("benchmark", ["ground={kind='record', file='example:BW.RJOB', axes={EHZ='z'}}"]).to_toml()


@settings(max_examples=300)
@given(st.sampled_from(places(tomllib.loads(WHOLE))), values)
def test_anything_at_any_place_gives_a_scenario_or_bad_input(place: tuple[str | int, ...], value: Any) -> None:
    table: Any = tomllib.loads(WHOLE)
    node = table
    for part in place[:-1]:
        node = node[part]
    node[place[-1]] = value
    assert outcome(lambda: parse_scenario(table))


@given(
    st.lists(st.one_of(keys, st.integers(-1, 5).map(str), st.text(max_size=3)), max_size=4).map(".".join),
    st.one_of(st.text(max_size=8), values.map(lambda value: tomli_w.dumps({"a": value})[4:].strip()), words),
)
def test_any_override_gives_a_scenario_or_bad_input(key: str, value: str) -> None:
    assert outcome(lambda: load_scenario("benchmark", [f"{key}={value}"]))


# --- schema -------------------------------------------------------------------------------------------------------


def schema() -> dict[str, Any]:
    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is no JSON")

    found: dict[str, Any] = json.loads(scenario_schema(), parse_constant=refuse)
    return found


def test_schema_is_a_json_schema() -> None:
    Draft202012Validator.check_schema(schema())


@pytest.mark.parametrize("name", shipped_scenarios())
def test_schema_accepts_what_ships_as_written_and_resolved(name: str) -> None:
    validator = Draft202012Validator(schema())
    validator.validate(tomllib.loads(shipped_scenarios()[name].read_text(encoding="utf-8")))
    validator.validate(tomllib.loads(load_scenario(name).to_toml()))


@pytest.mark.parametrize(
    "case", ["unknown key", "text for a number", "negative mass", "unknown ground", "list too short", "unknown preset"]
)
def test_schema_refuses_what_the_reader_refuses(case: str) -> None:
    assert not Draft202012Validator(schema()).is_valid(BAD[case][0])


def test_an_oil_sets_what_belongs_to_it_and_yields_to_what_is_given() -> None:
    table = {"actuators": {"isolator": {"oil": "mineral", "air_fraction": 0.01}}}
    actuator = parse_scenario(table).actuators["isolator"]
    assert (actuator.bulk_modulus, actuator.sources["bulk_modulus"]) == (1.6e9, "assumed")
    assert (actuator.air_fraction, actuator.sources["air_fraction"]) == (0.01, "given")
    assert actuator.piston_area == FIRST_GENERATION.piston_area
    with pytest.raises(InputError, match=r"actuators\.isolator\.oil = 'olive'"):
        parse_scenario({"actuators": {"isolator": {"oil": "olive"}}})


def test_a_scenario_of_megabytes_is_refused_before_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "long.toml"
    path.write_text("# " + 2**20 * "x")
    with pytest.raises(InputError, match=r"long\.toml: it has 1048578 bytes, 1048576 are allowed; long series belong"):
        load_scenario(path)
