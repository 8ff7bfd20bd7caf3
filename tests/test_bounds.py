"""Numbers that physics would not accept."""

import re
from typing import Any

import pytest

from ehamj.bounds import BOUNDS, INTEGER, OTHERS, check_magnitude, unit_of
from ehamj.errors import InputError
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.settings import Parameters, Settings


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("control.rate=1e300", r"control\.rate = 1e\+300: must be at most 1e\+07 Hz"),
        ("actuators.isolator.valve_frequency=1e200", r"actuators\.isolator\.valve_frequency = 1e\+200: .* rad/s"),
        ("actuators.isolator.area_ratio=1e300", r"area_ratio = 1e\+300: must be at most 1e\+09 in magnitude"),
        ("machine.mass=1e-16", r"machine\.mass = 1e-16: must be at least 0\.001 kg"),
        ("machine.cg=[1e300, 0.0, 0.5]", r"machine\.cg = .*: must be at most 100000 m"),
        ("ground.fade_in=1e-200", r"ground\.fade_in = 1e-200: must be zero or at least 1e-09 s"),
        (f"seed={10**400}", r"seed = .*: an integer must fit into 64 bits"),
    ],
)
def test_a_number_beyond_physics_is_refused_by_its_key(override: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        load_scenario("vc-c-floor", [override])


def test_endless_is_endless_and_a_rest_of_a_sum_is_small() -> None:
    scenario = load_scenario("vc-c-floor", ["actuators.isolator.foot_stiffness=1e30", "machine.cg=[6e-17, 0.0, 0.5]"])
    assert scenario.plant.actuators[0].foot_stiffness == 1e30
    assert scenario.machine.cg[0] == 6e-17


def test_units_and_numbers_within_lists() -> None:
    assert unit_of("from, to [of 2] [Hz]") == "Hz"
    assert unit_of("a name") is None
    assert check_magnitude((1.0, [True, INTEGER]), None) == (1.0, [True, INTEGER])
    with pytest.raises(ValueError, match=r"at most 1e\+07 Hz"):
        check_magnitude({"a": [0.0, [1e8]]}, "Hz")


def test_a_rest_of_a_sum_may_be_small_where_it_has_a_sign() -> None:
    inertia = [[2000.0, 1e-14, 0.0], [1e-14, 3000.0, 0.0], [0.0, 0.0, 4000.0]]
    assert parse_scenario({"machine": {"inertia": inertia}}).machine.inertia[0][1] == 1e-14  # type: ignore[index]


def test_what_is_a_factor_is_bounded_too() -> None:
    with pytest.raises(InputError, match=r"control\.gain = 1e\+300: must be at most 1e\+09 in magnitude"):
        parse_scenario({"control": {"kind": "feedforward", "gain": 1e300}})


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (
            {"ground": {"kind": "multisine", "frequencies": [9.0] * 10_001, "velocities": [1e-6]}},
            r"frequencies: .*10000",
        ),
        ({"force": [{"kind": "sine", "amplitude": 1.0, "frequency": 9.0}] * 1001}, r"^force: has 1001 .* at most 1000"),
        ({"points": {f"p{k}": [0.0, 0.0, 1.0] for k in range(1001)}}, r"^points: has 1001 entries; at most 1000"),
        ({"control": {"kind": "resonant", "lines": [9.0] * 101}}, r"^control.lines: .* at most 100 items"),
    ],
)
def test_a_list_that_nobody_writes_is_refused_before_it_is_read(changed: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        parse_scenario(changed)


def test_of_many_findings_the_first_are_said() -> None:
    with pytest.raises(InputError, match="and 880 more") as told:
        parse_scenario({"force": [{"kind": "sine"}] * 450})
    assert len(str(told.value).splitlines()) == 21


def _known(kind: type[Settings]) -> Any:
    yield kind
    for one in kind.__subclasses__():
        yield from _known(one)


def test_every_quantity_has_a_unit_that_has_bounds() -> None:
    """In brackets at the end of a description stands nothing but a unit, or a table's name."""
    load_scenario("recorded")
    units = {unit for kind in _known(Parameters) for unit, *_ in kind.quantities().values()}
    assert {"m", "kg", "Pa", "rad/s"} <= units
    assert units <= {*BOUNDS, *OTHERS}, (
        f"{sorted(units - {*BOUNDS, *OTHERS})}: state in src/ehamj/bounds.py which magnitudes a new unit may have"
    )
    described = [field.description or "" for kind in _known(Settings) for field in kind.model_fields.values()]
    written = {found[-1] for one in described if (found := re.findall(r"\[([^\[\]]+)\]$", one))}
    strange = {one for one in written if unit_of(f"[{one}]") is None} - {"supply", "actuators.NAME"}
    assert not strange, f"{sorted(strange)}: no unit of src/ehamj/bounds.py; state there which magnitudes it may have"
