"""Parameters: the paper's values, where each value comes from, what is derived, and what is refused."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from ehamj.isolator.actuator import Actuator
from ehamj.isolator.presets import ACTUATOR_PRESETS, ELASTIC_MOUNT, FIRST_GENERATION, PNEUMATIC_MOUNT, RECOMMENDED
from ehamj.isolator.supply import Supply
from ehamj.plant.machine import Machine
from ehamj.plant.mounts import DEFAULT_MOUNTS, MOUNTS, Mount
from ehamj.plant.plant import Plant
from ehamj.settings import Parameters

TABLE_I = {
    "piston_area": 3.18e-2,
    "membrane_damping": 3900.0,
    "chamber_volume": 5.39e-4,
    "membrane_stiffness": 6.8e8,
    "flow_gain": 1.94e-6,
    "valve_frequency": 1571.0,
    "valve_damping": 0.65,
    "valve_gain": 2.0,
    "bulk_modulus": 1.4e9,
    "flow_pressure": 6.6e-11,
}
"""Typed from the paper, SI with the spool in mA."""

PAPER_MASS = 4056.0  # kg, on one actuator

# Every value of an actuator, by what may be written there.
POSITIVE = (
    "piston_area",
    "chamber_volume",
    "bulk_modulus",
    "flow_gain",
    "valve_gain",
    "valve_frequency",
    "valve_damping",
    "spool_stroke",
    "voltage_limit",
    "area_ratio",
    "rated_drop",
)
ZERO_TOO = (
    "vapour_pressure",
    "membrane_stiffness",
    "membrane_damping",
    "lateral_stiffness",
    "lateral_damping",
    "plate_mass",
    "foot_damping",
    "flow_pressure",
    "edge_leakage_share",
    "laminar_ratio",
    "hysteresis",
    "threshold",
    "rated_flow",
    "air_fraction",
    "outside_leakage_1",
    "outside_leakage_2",
    "null_drift_from",
    "null_drift_limit",
)
INFINITE_TOO = ("foot_stiffness", "spool_drive_limit", "wall_modulus")
SPECIAL = (
    "volume_share",
    "overlap",
    "null_offset",
    "flow_curve",
    "polytropic_exponent",
    "null_drift",
    "spool_stuck_at",
)  # limits of their own, tested with the options

positive = st.floats(min_value=1e-4, max_value=1e-3)  # within what every unit allows


def natural_frequency(actuator: Actuator) -> float:
    """sqrt(K_h/M)/2π [Hz] of one actuator under the paper's mass."""
    return math.sqrt(actuator.hydraulic_stiffness / PAPER_MASS) / (2 * math.pi)


# --- values and sources -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "value"), TABLE_I.items())
def test_first_generation_is_table_one(name: str, value: float) -> None:
    assert (getattr(FIRST_GENERATION, name), FIRST_GENERATION.sources[name]) == (value, "paper")


def test_nothing_else_claims_to_be_from_the_paper() -> None:
    assert {name for name, source in FIRST_GENERATION.sources.items() if source == "paper"} == {
        *TABLE_I,
        "area_ratio",  # section 2: both areas are identical,
        "volume_share",  # and the piston is centred
    }


def test_every_value_has_unit_symbol_and_source() -> None:
    for kind in (Actuator, Machine, Supply):
        instance = kind()
        for name, (unit, symbol, source) in kind.quantities().items():
            assert unit, name
            assert symbol, name
            assert instance.sources[name] == source
        assert set(instance.sources) == set(kind.quantities())


def test_recommended_differs_from_the_first_generation_as_the_paper_says() -> None:
    factors = {
        name: getattr(RECOMMENDED, name) / getattr(FIRST_GENERATION, name)
        for name in Actuator.quantities()
        if getattr(RECOMMENDED, name) != getattr(FIRST_GENERATION, name)
    }
    assert factors == {"chamber_volume": 0.5, "piston_area": 2.0, "flow_pressure": 2.0}
    assert {RECOMMENDED.sources[name] for name in factors} == {"paper"}


def test_presets_are_named() -> None:
    assert ACTUATOR_PRESETS == {
        "first-generation": FIRST_GENERATION,
        "recommended": RECOMMENDED,
        "elastic-mount": ELASTIC_MOUNT,
        "pneumatic-mount": PNEUMATIC_MOUNT,
    }


@given(st.dictionaries(st.sampled_from(POSITIVE), positive))
def test_changed_values_are_given_and_the_others_keep_their_source(values: dict[str, float]) -> None:
    changed = FIRST_GENERATION.with_values(values)
    for name in Actuator.quantities():
        before = getattr(FIRST_GENERATION, name)
        assert getattr(changed, name) == values.get(name, before)
        source = FIRST_GENERATION.sources[name] if values.get(name, before) == before else "given"
        assert changed.sources[name] == source


def test_a_value_changed_back_is_still_given() -> None:
    there = FIRST_GENERATION.with_values({"plate_mass": 20.0})
    assert there.with_values({"bulk_modulus": 1e9}).sources["plate_mass"] == "given"


def test_a_source_may_be_stated() -> None:
    assert Machine(mass=4100.0, sources={"mass": "identified"}).sources["mass"] == "identified"
    assert FIRST_GENERATION.with_values({"sources": {"plate_mass": "given"}}).sources["plate_mass"] == "given"


def test_a_source_of_nothing_is_refused() -> None:
    with pytest.raises(ValidationError, match="'weight', which is not one of mass, inertia, cg, size"):
        Machine(sources={"weight": "given"})


@pytest.mark.parametrize("settings", [FIRST_GENERATION, Machine(), Supply(), DEFAULT_MOUNTS[0]], ids=repr)
def test_settings_cannot_be_changed_in_place(settings: Any) -> None:
    name = next(iter(type(settings).model_fields))
    with pytest.raises(ValidationError, match="frozen"):
        setattr(settings, name, getattr(settings, name))


# --- derived values -----------------------------------------------------------------------------------------------


def test_hydraulic_stiffness_of_the_paper() -> None:
    # The published figures have four and two digits: half a unit of the last one.
    assert FIRST_GENERATION.hydraulic_stiffness == pytest.approx(1.051e10, abs=0.0005e10)
    ratio = FIRST_GENERATION.membrane_stiffness / FIRST_GENERATION.hydraulic_stiffness
    assert ratio == pytest.approx(0.065, abs=0.0005)


def test_hydraulic_frequencies_of_the_paper() -> None:
    # Computed twice from Table I, given to 0.1 Hz (the paper rounds them to 257 and 726 Hz).
    assert natural_frequency(FIRST_GENERATION) == pytest.approx(256.2, abs=0.05)
    assert natural_frequency(RECOMMENDED) == pytest.approx(724.5, abs=0.05)


@given(st.floats(0.0, 1.0), st.floats(0.0, 1e-6))
def test_leakages_add_up_to_the_flow_pressure_coefficient(share: float, coefficient: float) -> None:
    actuator = Actuator(edge_leakage_share=share, flow_pressure=coefficient)
    assert actuator.edge_leakage >= 0.0
    assert actuator.cross_leakage >= 0.0
    # Two products and a sum, each rounded; below the normal range a rounding is absolute.
    assert actuator.edge_leakage + actuator.cross_leakage == pytest.approx(coefficient, rel=4e-16, abs=1e-320)


def test_maximum_stroke_empties_one_chamber() -> None:
    # V_t/(2 A_p) by hand: 539 cm³ / 2 / 318 cm² = 8.475 mm, to its last digit.
    assert FIRST_GENERATION.maximum_stroke == pytest.approx(8.475e-3, abs=0.5e-6)


def test_an_infinite_foot_is_rigid() -> None:
    assert Actuator().rigid_foot
    assert not Actuator(foot_stiffness=1e9).rigid_foot


def test_flow_is_rated_at_half_the_supply_above_the_tank() -> None:
    assert Supply(pressure=71e5, tank_pressure=1e5).rating_pressure == 35e5


def test_total_mass_counts_every_plate() -> None:
    masses = (1.0, 2.0, 4.0, 8.0)
    actuators = tuple(Actuator(plate_mass=mass) for mass in masses)
    positions = tuple(mount.place for mount in DEFAULT_MOUNTS)
    plant = Plant(Machine(mass=4000.0), positions, actuators, Supply(), 9.81, "tied")
    assert plant.total_mass == 4015.0


def test_default_machine_weighs_what_the_paper_states() -> None:
    actuators = (FIRST_GENERATION,) * 4
    assert Plant(Machine(), ((0.0, 0.0),) * 4, actuators, Supply(), 0.0, "tied").total_mass == PAPER_MASS


def test_default_mounts_are_the_four_in_order_with_front_and_left_positive() -> None:
    assert tuple(mount.name for mount in DEFAULT_MOUNTS) == MOUNTS
    for mount in DEFAULT_MOUNTS:
        x, y = mount.position
        assert (x > 0, y > 0) == (mount.name.startswith("front"), mount.name.endswith("left"))


# --- what is refused ----------------------------------------------------------------------------------------------


def test_lists_of_limits_cover_every_value() -> None:
    assert sorted(POSITIVE + ZERO_TOO + INFINITE_TOO + SPECIAL) == sorted(Actuator.quantities())


@pytest.mark.parametrize("name", POSITIVE + INFINITE_TOO)
@pytest.mark.parametrize("value", [0.0, -1e-3, -math.inf, math.nan])
def test_positive_values_refuse_what_is_not(name: str, value: float) -> None:
    with pytest.raises(ValidationError, match=name):
        Actuator(**{name: value})


@pytest.mark.parametrize("name", ZERO_TOO)
@pytest.mark.parametrize("value", [-1e-3, -math.inf, math.nan])
def test_values_that_may_be_zero_refuse_what_is_below(name: str, value: float) -> None:
    assert getattr(Actuator(**{name: 0.0}), name) == 0.0
    with pytest.raises(ValidationError, match=name):
        Actuator(**{name: value})


@pytest.mark.parametrize("name", POSITIVE + ZERO_TOO)
def test_most_values_must_be_finite(name: str) -> None:
    with pytest.raises(ValidationError, match=name):
        Actuator(**{name: math.inf})


@pytest.mark.parametrize("name", INFINITE_TOO)
def test_infinity_means_without_limit(name: str) -> None:
    assert math.isinf(getattr(Actuator(**{name: math.inf}), name))


@pytest.mark.parametrize(("name", "largest"), [("edge_leakage_share", 1.0), ("laminar_ratio", 0.1)])
def test_shares_have_a_largest_value(name: str, largest: float) -> None:
    assert getattr(Actuator(**{name: largest}), name) == largest
    with pytest.raises(ValidationError, match=name):
        Actuator(**{name: math.nextafter(largest, 2.0)})


@pytest.mark.parametrize("value", ["0.03", True, None, [0.03], {"value": 0.03}], ids=repr)
def test_only_a_number_is_a_number(value: Any) -> None:
    with pytest.raises(ValidationError, match="piston_area"):
        Actuator(piston_area=value)


def test_a_whole_number_is_a_number() -> None:
    given = Machine(mass=4000, inertia=[2000, 3000, 4000])  # type: ignore[arg-type]
    assert given.model_dump(exclude={"sources"}) == Machine().model_dump(exclude={"sources"})


@pytest.mark.parametrize("kind", [Actuator, Machine, Supply])
def test_unknown_keys_are_refused(kind: type[Parameters]) -> None:
    with pytest.raises(ValidationError, match=r"stiffnes\n.*not permitted"):
        kind(stiffnes=1.0)  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("pressure", "tank"), [(0.0, 0.0), (-1.0, 0.0), (70e5, -1.0), (70e5, 70e5), (70e5, 71e5), (math.inf, 0.0)]
)
def test_supply_must_lie_above_the_tank_and_vacuum(pressure: float, tank: float) -> None:
    with pytest.raises(ValidationError, match="pressure"):
        Supply(pressure=pressure, tank_pressure=tank)


@pytest.mark.parametrize("mass", [0.0, -4000.0, math.nan, math.inf])
def test_mass_must_be_positive(mass: float) -> None:
    with pytest.raises(ValidationError, match="mass"):
        Machine(mass=mass)


@pytest.mark.parametrize("name", ["inertia", "size"])
@pytest.mark.parametrize("entry", range(3))
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_inertia_and_size_must_be_positive_in_each_entry(name: str, entry: int, value: float) -> None:
    entries = [2.0, 2.0, 2.0]
    entries[entry] = value
    with pytest.raises(ValidationError, match=name):
        Machine(**{name: entries})


@pytest.mark.parametrize("entries", [(1.0, 2.0), (1.0, 2.0, 2.0, 1.0), 5.0])
def test_inertia_has_three_entries(entries: Any) -> None:
    with pytest.raises(ValidationError, match="inertia"):
        Machine(inertia=entries)


point = st.tuples(*(st.floats(-10, 10),) * 3)


@given(st.lists(point, min_size=1, max_size=6), st.floats(0.01, 10.0))
def test_inertia_of_any_body_is_accepted(points: list[tuple[float, float, float]], depth: float) -> None:
    # A cube of its own at each point keeps the body from being flat, where rounding would decide.
    inertia = tuple(
        sum(p[(axis + 1) % 3] ** 2 + p[(axis + 2) % 3] ** 2 + depth**2 / 6 for p in points) for axis in range(3)
    )
    assert Machine(inertia=inertia).inertia == inertia  # type: ignore[arg-type]


@given(st.permutations([1.0, 2.0]), st.integers(0, 2), st.floats(3.001, 1e6))
def test_inertia_of_no_body_is_refused(two: list[float], at: int, largest: float) -> None:
    with pytest.raises(ValidationError, match="at most the sum of the other two"):
        Machine(inertia=[*two[:at], largest, *two[at:]])  # type: ignore[arg-type]


def test_inertia_of_a_flat_body_is_accepted() -> None:
    assert Machine(inertia=(1.0, 2.0, 3.0)).inertia == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    "cg", [(1.01, 0, 0.5), (-1.01, 0, 0.5), (0, 1.01, 0.5), (0, -1.01, 0.5), (0, 0, -0.01), (0, 0, 2.01)]
)
def test_cg_outside_the_outline_is_refused(cg: tuple[float, float, float]) -> None:
    with pytest.raises(ValidationError, match="outside the machine's outline"):
        Machine(size=(2.0, 2.0, 2.0), cg=cg)


@pytest.mark.parametrize("cg", [(1.0, -1.0, 0.0), (-1.0, 1.0, 2.0)])
def test_cg_on_the_outline_is_accepted(cg: tuple[float, float, float]) -> None:
    assert Machine(size=(2.0, 2.0, 2.0), cg=cg).cg == cg


def test_a_mount_has_a_place_a_direction_of_some_length_and_a_thin_shim() -> None:
    mount = Mount(name="skew", position=(0.5, -0.25, 0.75), direction=(0.0, 3.0, 4.0), height=1e-4)
    assert (mount.place, mount.along) == ((0.5, -0.25, 0.75), (0.0, 0.6, 0.8))
    for bad, words in (
        ({"position": (0.0,)}, "at least 2"),
        ({"position": (0.0,) * 4}, "at most 3"),
        ({"direction": (0.0, 0.0, 0.0)}, "no length"),
        ({"height": 0.2}, "at most 0.05 m"),
    ):
        with pytest.raises(ValidationError, match=words):
            Mount.model_validate({"name": "front", "position": (0.0, 0.0), **bad})


@pytest.mark.parametrize("name", ["", "front left", "machine"])
def test_a_mount_has_a_name_that_fits_into_names_of_channels(name: str) -> None:
    assert Mount(name="front_1", position=(0.0, 0.0)).name == "front_1"
    with pytest.raises(ValidationError, match="letters, digits, - and _"):
        Mount(name=name, position=(0.0, 0.0))
