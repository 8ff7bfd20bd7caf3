"""Standard deviations of identified values: written, read, shown, and lost with the value that they are of."""

from typing import Any

import pytest

from ehamj.errors import InputError
from ehamj.isolator.presets import FIRST_GENERATION
from ehamj.pages.words import plain_within, within
from ehamj.plain.text import toml_of
from ehamj.report.sections.inputs import TABLES
from ehamj.scenario.load import load_scenario, parse_scenario

KNOWN: dict[str, Any] = {
    "machine": {
        "mass": 4210.0,
        "cg": [0.02, 0.0, 0.71],
        "sources": {"mass": "identified", "cg": "identified"},
        "deviations": {"mass": 12.4, "cg": [0.003, 0.0, 0.01]},
    },
    "actuators": {
        "isolator": {
            "flow_gain": 1.9432e-6,
            "sources": {"flow_gain": "identified"},
            "deviations": {"flow_gain": 1.2e-8},
        }
    },
}


def test_they_come_back_from_toml_and_stand_only_where_there_are_any(tmp_path: Any) -> None:
    scenario = parse_scenario(KNOWN)
    table = toml_of(scenario.to_toml())
    assert table["machine"]["deviations"] == KNOWN["machine"]["deviations"]
    assert "deviations" not in table["supply"]
    (file := tmp_path / "known.toml").write_text(scenario.to_toml(), encoding="utf-8")
    assert load_scenario(file) == scenario
    assert scenario.plant.actuators[0].deviations == {"flow_gain": 1.2e-8}


@pytest.mark.parametrize(
    ("override", "left"),
    [
        ("machine.mass=4300", {"cg": (0.003, 0.0, 0.01)}),
        ("machine.cg.2=0.8", {"mass": 12.4}),
        ("machine.cg=[0.0, 0.0, 0.8]", {"mass": 12.4}),
        ("machine.size.2=2.1", {"mass": 12.4, "cg": (0.003, 0.0, 0.01)}),
    ],
)
def test_a_replaced_value_loses_source_and_deviation(override: str, left: dict[str, Any], tmp_path: Any) -> None:
    (file := tmp_path / "known.toml").write_text(parse_scenario(KNOWN).to_toml(), encoding="utf-8")
    machine = load_scenario(file, [override]).machine
    assert machine.deviations == left
    assert {name for name in ("mass", "cg") if machine.sources[name] == "given"} == {"mass", "cg"} - left.keys()


def test_another_preset_leaves_what_was_measured(tmp_path: Any) -> None:
    (file := tmp_path / "known.toml").write_text(parse_scenario(KNOWN).to_toml(), encoding="utf-8")
    isolator = load_scenario(file, ["actuators.isolator.preset=recommended"]).actuators["isolator"]
    assert (isolator.flow_gain, isolator.deviations) == (1.9432e-6, {"flow_gain": 1.2e-8})
    assert isolator.piston_area == 2 * FIRST_GENERATION.piston_area


def test_a_variant_changes_them_as_set_does() -> None:
    lighter = parse_scenario(KNOWN | {"variants": {"lighter": {"machine": {"mass": 3000.0}}}}).variant("lighter")
    assert (lighter.machine.deviations, lighter.machine.sources["mass"]) == ({"cg": (0.003, 0.0, 0.01)}, "given")


def test_with_values_drops_and_states_them() -> None:
    told = {"sources": {"flow_gain": "identified"}, "deviations": {"flow_gain": 1e-8}}
    known = FIRST_GENERATION.with_values({"flow_gain": 2e-6, **told})
    assert known.deviations == {"flow_gain": 1e-8}
    assert known.with_values({"plate_mass": 20.0}).deviations == {"flow_gain": 1e-8}
    assert known.with_values({"flow_gain": 2.1e-6}).deviations == {}
    assert known.with_values({"sources": {"flow_gain": "given"}}).deviations == {}


@pytest.mark.parametrize(
    ("machine", "said"),
    [
        ({"deviations": {"weight": 1.0}}, "deviations names 'weight', which is not one of mass, inertia"),
        ({"deviations": {"mass": 1.0}}, "machine.deviations.mass = 1.0: the value's source is 'assumed'"),
        ({"sources": {"mass": "identified"}, "deviations": {"mass": [1.0]}}, "must be as mass = 4000.0"),
        ({"sources": {"cg": "identified"}, "deviations": {"cg": [1.0, 2.0]}}, "must be as cg = "),
        ({"sources": {"mass": "identified"}, "deviations": {"mass": -1.0}}, "machine.deviations.mass"),
        ({"sources": {"mass": "identified"}, "deviations": {"mass": float("inf")}}, "machine.deviations.mass"),
    ],
)
def test_what_no_deviation_can_be_is_refused(machine: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as refused:
        parse_scenario({"machine": machine})
    assert said in str(refused.value)


@pytest.mark.parametrize(
    ("value", "deviation", "text"),
    [
        (4210.3, 12.4, "4210 ± 12"),
        (0.71234, 0.0123, "0.712 ± 0.012"),
        (1.94321e-6, 1.2e-8, "(1.943 ± 0.012) × 10⁻⁶"),
        (-2.5e9, 3.1e7, "(−2.500 ± 0.031) × 10⁹"),
        (1.0, 0.0999, "1.00 ± 0.10"),
        (0.0, 2e-5, "(0.0 ± 2.0) × 10⁻⁵"),
        (0.5, 0.0, "0.5"),
    ],
)
def test_numbers_are_written_as_exactly_as_they_are_known(value: float, deviation: float, text: str) -> None:
    assert within(value, deviation) == text


def test_the_report_shows_them() -> None:
    assert plain_within((0.02, 0.0, 0.71), (0.003, 0.0, 0.01)) == "0.0200 ± 0.0030, 0, 0.710 ± 0.010"
    scenario = parse_scenario(KNOWN)
    rows = {row[0]: row[2:] for table in TABLES for one in table(scenario) for row in one.rows if len(row) == 4}
    (shown,) = [cells for name, cells in rows.items() if "<code>flow_gain<" in name]
    assert shown[0] == "(1.943 ± 0.012) × 10⁻⁶ m³/s/mA"
    assert "identified" in shown[1]
    assert not any("deviations" in name for name in rows)
