"""Each hydraulic option where it matters (a closed form or a limit) and where it must not."""

import math
from typing import Any

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.linear.machine import linear_model
from ehamj.result import Result
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

ATMOSPHERE = 101325.0

NEEDLE = {"piston_area": 1e-9, "flow_pressure": 1e-16, "laminar_ratio": 0.0}
"""A cylinder that neither moves nor leaks: its chambers only see the valve."""


def scenario_of(isolator: dict[str, Any] | None = None, volts: float = 0.0, **table: Any) -> Scenario:
    """Tied plates, no gravity, and a step of all commands at the start."""
    control = {"kind": "open-loop", "signals": [{"kind": "step", "amplitude": volts}]}
    basis = {"gravity": 0.0, "plates": "tied", "duration": 0.05, "control": control, "timestep": 1e-4}
    return parse_scenario({**basis, "actuators": {"isolator": isolator or {}}, **table})


def run(isolator: dict[str, Any] | None = None, volts: float = 0.0, **table: Any) -> Result:
    return simulate(scenario_of(isolator, volts, **table))


def pressures(result: Result) -> np.ndarray:
    return result.dataset["chamber_pressure"].values[:, 0]


def flow(isolator: dict[str, Any], volts: float) -> np.ndarray:
    """Flow into both chambers of a motionless cylinder at mid pressure, once the spool has settled; over K_Q [mA].

    The chambers are so large that their pressures stay: 1e3 m³ takes in 1e-6 m³ at 1 Pa.
    """
    result = run({**NEEDLE, "chamber_volume": 1e3, **isolator}, volts, timestep="auto")
    return result.dataset["chamber_flow"].values[-1, 0] / 1.94e-6


@pytest.mark.parametrize("volts", [2.0, -2.0])
def test_overlap_takes_its_length_from_each_edge(volts: float) -> None:
    """An edge lets through K_Q·(x − x_0): of 4 mA, 3 and 3.5 remain, or 2 and 2.5."""
    laps = [1.0, 2.0, 1.5, 0.5]
    one, two = flow({"overlap": laps}, volts)
    feeds, drains = (laps[0], laps[3]) if volts > 0 else (laps[1], laps[2])
    expected = (4.0 - feeds, -(4.0 - drains)) if volts > 0 else (-(4.0 - feeds), 4.0 - drains)
    assert one == pytest.approx(expected[0], rel=1e-6)
    assert two == pytest.approx(expected[1], rel=1e-6)


def test_within_its_overlap_a_valve_is_closed() -> None:
    assert np.abs(flow({"overlap": [3.0] * 4}, 1.0)).max() < 1e-6


def test_underlap_lets_oil_through_at_null_and_holds_mid_pressure() -> None:
    result = run({"overlap": [-1.0] * 4})
    assert np.ptp(pressures(result), axis=0) == pytest.approx(0.0, abs=1.0)
    drawn = 8 * (1.94e-6 + 0.05 * 6.6e-11 * 35e5)  # over eight supply edges: 1 mA each, and their leak
    assert result.summary["oil"]["mean_flow_m3_s"] == pytest.approx(drawn, rel=1e-4)


def test_null_offset_acts_as_a_spool_out_of_centre() -> None:
    """Held where the offset is made good, then moved by 3.5 mA."""
    signals = [{"kind": "step", "amplitude": -0.75, "start": -1.0}, {"kind": "step", "amplitude": 1.75}]
    result = run(
        {"piston_area": 1e-9, "chamber_volume": 1e3, "null_offset": 1.5},
        control={"kind": "open-loop", "signals": signals},
    )
    found = result.dataset["chamber_flow"].values[:, 0] / 1.94e-6
    assert np.abs(found[0]).max() < 1e-6
    assert found[-1] == pytest.approx([3.5, -3.5], rel=1e-4)  # 2 Pa between the chambers leak 2e-5 of it


def test_threshold_leaves_the_spool_short_of_its_target() -> None:
    """Without overshoot it ends at the target less the threshold, and it does not move for less."""
    spool = run({"threshold": 0.5, "valve_damping": 1.5}, 1.0).dataset["spool"].values
    assert spool[-1] == pytest.approx(1.5, abs=1e-6)
    assert not run({"threshold": 0.5}, 0.2).dataset["spool"].values.any()


def test_hysteresis_loses_half_its_play_when_the_spool_turns() -> None:
    """Out by 4 mA: the edges follow to 4 − w/2; back at 0, they stay w/2 behind."""
    width = 1.0
    assert flow({"hysteresis": width, "valve_damping": 2.0}, 2.0) == pytest.approx([3.5, -3.5], rel=1e-4)
    there = [{"kind": "step", "amplitude": 2.0}, {"kind": "step", "amplitude": -2.0, "start": 0.1}]
    result = run(
        {**NEEDLE, "chamber_volume": 1e3, "hysteresis": width, "valve_damping": 1.0},
        control={"kind": "open-loop", "signals": there},
        duration=0.2,
    )
    assert result.dataset["chamber_flow"].values[-1, 0] / 1.94e-6 == pytest.approx([0.5, -0.5], rel=1e-4)


def test_hysteresis_does_not_touch_a_spool_that_moves_one_way() -> None:
    """Beyond its first half width it only shifts the opening: the flow is K_Q·(x − w/2) all the way."""
    result = run({**NEEDLE, "chamber_volume": 1e3, "hysteresis": 0.2, "valve_damping": 1.0}, 2.0)
    spool, found = result.dataset["spool"].values[:, 0], result.dataset["chamber_flow"].values[:, 0, 0] / 1.94e-6
    moved = spool > 0.1
    assert moved.sum() > 40
    np.testing.assert_allclose(found[moved], spool[moved] - 0.1, rtol=1e-6, atol=1e-9)


def test_end_stops_hold_the_spool_at_its_stroke_without_a_bounce() -> None:
    """A lightly damped spool would overshoot 18 mA by half; it stops at 20 mA, and returns from there."""
    free = run({"valve_damping": 0.2}, 9.0).dataset["spool"].values[:, 0]
    held = run({"valve_damping": 0.2, "end_stops": True}, 9.0).dataset["spool"].values[:, 0]
    assert free.max() > 21.0
    assert held.max() == 20.0
    assert held[-1] == pytest.approx(18.0, abs=0.1)


def test_end_stops_that_are_not_reached_change_nothing() -> None:
    one, other = (run({"end_stops": stops}, 5.0).dataset for stops in (False, True))
    np.testing.assert_array_equal(one["spool"].values, other["spool"].values)
    np.testing.assert_array_equal(one["chamber_pressure"].values, other["chamber_pressure"].values)


def test_a_flow_curve_is_followed_between_its_points() -> None:
    """10 % of the flow at half stroke, and straight from there to all of it."""
    curve = {"flow_curve": [[0.0, 0.0], [0.5, 0.1], [1.0, 1.0]]}
    assert flow(curve, 5.0) == pytest.approx([2.0, -2.0], rel=1e-6)
    assert flow(curve, 7.5) == pytest.approx([11.0, -11.0], rel=1e-6)
    assert flow(curve, -2.5) == pytest.approx([-1.0, 1.0], rel=1e-6)


def test_rated_flow_is_met_at_its_drop() -> None:
    """Supply and tank 70 bar apart leave 35 bar per edge at mid pressure."""
    q = flow({"rated_flow": 5e-5, "rated_drop": 35e5, "voltage_limit": 10.0}, 10.0) * 1.94e-6
    assert q == pytest.approx([5e-5, -5e-5], rel=1e-6)
    quarter = flow({"rated_flow": 5e-5, "rated_drop": 140e5}, 10.0) * 1.94e-6
    assert quarter == pytest.approx([2.5e-5, -2.5e-5], rel=1e-6)


def test_air_softens_the_oil_by_its_share() -> None:
    """1/β_e = (1 − s)/β + s/(n p), s the air's share of the volume at p; seen in the pressure's first rise."""
    air, n, p, beta = 0.05, 1.3, 35e5, 1.4e9
    gas = air * (ATMOSPHERE / p) ** (1 / n)
    share = gas / (gas + (1 - air) * math.exp((ATMOSPHERE - p) / beta))
    expected = 1.0 / ((1 - share) / beta + share / (n * p)) / beta
    rise = [
        np.ptp(pressures(run({**NEEDLE, "air_fraction": a, "polytropic_exponent": n}, 0.001))[:, 0]) for a in (0.0, air)
    ]
    assert rise[1] / rise[0] == pytest.approx(expected, rel=1e-3)


def test_elastic_walls_soften_the_chamber() -> None:
    """1/β + 1/(β_w·w), w the walls' stretch at 35 bar."""
    wall = 2e9
    stretch = 1 + (35e5 - ATMOSPHERE) / wall
    rise = [np.ptp(pressures(run({**NEEDLE, "wall_modulus": w}, 0.001))[:, 0]) for w in (math.inf, wall)]
    assert rise[0] / rise[1] == pytest.approx(stretch + 1.4e9 / wall, rel=1e-3)


def test_chambers_of_unequal_volume_fill_at_unequal_rates() -> None:
    one, two = np.ptp(pressures(run({**NEEDLE, "volume_share": 0.2}, 0.001)), axis=0)
    assert one / two == pytest.approx(4.0, rel=1e-3)


def test_unequal_areas_push_with_the_difference() -> None:
    """At mid pressure in both, the force is P·A_p·(1 − A_2/A_1)."""
    result = run({"area_ratio": 0.8})
    p = pressures(result)[0]
    assert result.dataset["actuator_force"].values[0, 0] == pytest.approx(3.18e-2 * (p[0] - 0.8 * p[1]), rel=1e-9)
    assert p == pytest.approx([35e5, 35e5], rel=1e-9)


def test_oil_pulled_apart_stands_at_its_vapour_pressure_and_comes_back() -> None:
    """Chambers drained to a tank below the vapour pressure go no lower than it; others do not notice."""
    isolator = {**NEEDLE, "vapour_pressure": 2e5}
    there = [{"kind": "step", "amplitude": 2.0}, {"kind": "step", "amplitude": -4.0, "start": 0.3}]
    result = run(isolator, control={"kind": "open-loop", "signals": there}, duration=0.6, timestep="auto")
    two = pressures(result)[:, 1]
    assert two.min() == 2e5
    assert result.dataset["chamber_void"].values.max() > 0
    assert two[-1] > 10e5
    mild = run({"vapour_pressure": 2e5}, 0.5).dataset["chamber_pressure"].values
    np.testing.assert_array_equal(mild, run({}, 0.5).dataset["chamber_pressure"].values)


def test_four_valves_that_draw_together_pull_the_supply_down() -> None:
    """Slowly, the manifold falls to where the pump's droop and the line's loss give what the valves draw."""
    pulled = []
    for mounts in (["front-left"], ["front-left", "front-right", "rear-left", "rear-right"]):
        signals = [{"kind": "step", "amplitude": 8.0, "mounts": mounts}]
        result = run({}, supply={"dynamic": True}, control={"kind": "open-loop", "signals": signals}, duration=0.2)
        supply = result.dataset["supply_pressure"].values
        pulled.append(float(supply[0] - supply.min()))
    assert pulled[1] > 3.0 * pulled[0] > 0.0


def test_a_stiff_pump_and_a_short_wide_line_hold_the_supply() -> None:
    """In the limit the shared supply is the constant one."""
    stiff = {"dynamic": True, "pump_flow": 1e-2, "pump_droop": 1e4, "line_diameter": 0.05}
    shared, constant = (run({}, 2.0, supply=table).dataset["chamber_pressure"].values for table in (stiff, {}))
    assert np.abs(shared - constant).max() < 1e-3 * 70e5


def test_tank_pressure_lifts_mid_pressure() -> None:
    assert pressures(run({}, supply={"tank_pressure": 4e5}))[0] == pytest.approx([37e5, 37e5], rel=1e-9)


UNITS = np.repeat([1e-7, 1e-4], 6).tolist() + [1.0, 1e3, 1e4, 1e4] * 4
"""States in units of which each matters: 0.1 µm, 0.1 mm/s, 1 mA, 1 A/s, 0.1 bar."""


def changed(one: dict[str, Any], other: dict[str, Any]) -> float:
    """Largest change of the linear model at null, over the largest entry of its row, in `UNITS`."""
    first, second = (linear_model(scenario_of(isolator).plant).A * np.array(UNITS) for isolator in (one, other))
    return float((np.abs(second - first).max(axis=1) / np.abs(first).max(axis=1)).max())


@pytest.mark.parametrize(
    "isolator",
    [
        {"overlap": [0.0] * 4},
        {"end_stops": True},
        {"vapour_pressure": 2e5},
        {"hysteresis": 0.0},
        {"threshold": 0.0},
        {"null_offset": 0.0},
        {"flow_curve": [[0.0, 0.0], [1.0, 1.0]]},
        {"flow_curve": [[0.0, 0.0], [0.3, 0.3], [1.0, 1.0]]},
        {"air_fraction": 0.0, "polytropic_exponent": 1.1},
        {"wall_modulus": 1e30},
        {"area_ratio": 1.0, "volume_share": 0.5},
        {"rated_flow": 1.94e-6 * 20.0, "rated_drop": 35e5},
        {"spool_drive_limit": 1e7},
    ],
    ids=str,
)
def test_an_option_at_its_neutral_value_leaves_the_linear_model(isolator: dict[str, Any]) -> None:
    """To the rounding of differences."""
    assert changed({}, isolator) < 1e-7


@pytest.mark.parametrize(
    "isolator",
    [
        {"overlap": [0.5] * 4},
        {"null_offset": 1.0},
        {"flow_curve": [[0.0, 0.0], [0.5, 0.1], [1.0, 1.0]]},
        {"air_fraction": 0.05},
        {"wall_modulus": 2e9},
        {"area_ratio": 0.8},
        {"volume_share": 0.3},
        {"rated_flow": 5e-5},
    ],
    ids=str,
)
def test_an_option_whose_physics_says_so_changes_the_linear_model(isolator: dict[str, Any]) -> None:
    assert changed({}, isolator) > 1e-3


@pytest.mark.parametrize(
    ("table", "names"),
    [
        ({"supply": {"pressure": 1e5, "tank_pressure": 2e5}}, ("supply", "pressure", "tank_pressure")),
        ({"supply": {"dynamic": True, "accumulator_precharge": 80e5}}, ("accumulator_precharge", "pressure")),
        ({"supply": {"pump_flow": 0.0}}, ("pump_flow", "greater than 0")),
        ({"actuators": {"isolator": {"overlap": [0.0, 0.0, 0.0, 25.0]}}}, ("overlap", "spool_stroke")),
        ({"actuators": {"isolator": {"overlap": [-20.0, 0.0, 0.0, 0.0]}}}, ("overlap", "spool_stroke")),
        ({"actuators": {"isolator": {"overlap": [0.0, 0.0]}}}, ("overlap",)),
        ({"actuators": {"isolator": {"null_offset": 20.0}}}, ("null_offset", "spool_stroke")),
        ({"actuators": {"isolator": {"hysteresis": -0.1}}}, ("hysteresis", "greater than or equal to 0")),
        ({"actuators": {"isolator": {"threshold": 30.0}}}, ("threshold", "spool_stroke")),
        ({"actuators": {"isolator": {"air_fraction": 1.0}}}, ("air_fraction", "less than 1")),
        ({"actuators": {"isolator": {"air_fraction": -0.1}}}, ("air_fraction", "greater than or equal to 0")),
        ({"actuators": {"isolator": {"polytropic_exponent": 0.9}}}, ("polytropic_exponent", "greater than or equal")),
        ({"actuators": {"isolator": {"wall_modulus": 0.0}}}, ("wall_modulus", "greater than 0")),
        ({"actuators": {"isolator": {"volume_share": 1.0}}}, ("volume_share", "less than 1")),
        ({"actuators": {"isolator": {"area_ratio": 0.0}}}, ("area_ratio", "greater than 0")),
        ({"actuators": {"isolator": {"rated_flow": -1e-5}}}, ("rated_flow", "greater than")),
        ({"actuators": {"isolator": {"flow_curve": [[0.0, 0.0], [0.5, 0.6], [0.4, 0.7], [1.0, 1.0]]}}}, ("increase",)),
        ({"actuators": {"isolator": {"flow_curve": [[0.0, 0.0], [0.5, 0.6], [0.7, 0.5], [1.0, 1.0]]}}}, ("not fall",)),
        ({"actuators": {"isolator": {"flow_curve": [[0.1, 0.0], [1.0, 1.0]]}}}, ("flow_curve", "from [0, 0]")),
    ],
    ids=lambda entry: str(entry)[:60],
)
def test_bad_parameters_are_refused_with_a_reason(table: dict[str, Any], names: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as refused:
        parse_scenario(table)
    for name in names:
        assert name in str(refused.value)
