"""Points of the unit cube become values of a scenario's keys, alone and together."""

from typing import Any

import numpy as np
import pytest
from scipy import stats

from ehamj.campaign.correlations import Correlation
from ehamj.campaign.parameters import Space
from ehamj.campaign.spreads import Vary
from ehamj.errors import InputError
from ehamj.scenario.explain import checked
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario
from ehamj.settings import Settings


class Table(Settings):
    """As a study file has them."""

    vary: Vary
    correlations: tuple[Correlation, ...] = ()


@pytest.fixture(scope="module")
def scenario() -> Scenario:
    """A machine on four isolators of one kind, on a floor by name."""
    return load_scenario("vc-c-floor")


def space(scenario: Scenario, vary: dict[str, Any], *together: tuple[str, str, float]) -> Space:
    """As a study makes it."""
    pairs = [{"between": [one, other], "coefficient": number} for one, other, number in together]
    table = checked(Table, {"vary": vary, "correlations": pairs})
    return Space.of(scenario, table.vary, table.correlations)


FLOW = "actuators.isolator.flow_gain"
AREA = "actuators.isolator.piston_area"
POINTS = np.random.default_rng(7).random((20_000, 12))


def columns(space: Space) -> dict[str, np.ndarray]:
    """Values of many designs by key."""
    rows = space.values(POINTS[:, : len(space.keys)])
    return {key: np.array([row[key] for row in rows], float) for key in space.keys}


def test_values_have_the_types_of_their_keys(scenario: Scenario) -> None:
    vary = {
        "machine.mass": {"tolerance": 0.1},
        "seed": {"low": 0, "high": 9},
        "ground.level": {"values": ["VC-C", "VC-D"]},
    }
    (row,) = space(scenario, vary).values(np.array([[0.5, 0.999, 0.2]]))
    assert row == {"machine.mass": pytest.approx(4000.0), "seed": 9, "ground.level": "VC-C"}
    assert [type(value) for value in row.values()] == [float, int, str]


def test_units_are_those_of_the_keys(scenario: Scenario) -> None:
    vary = {
        "machine.mass": {"tolerance": 0.1},
        "machine.cg.0": {"off": 0.1},
        "footprint.x": {"tolerance": 0.1},
        "control.delay": {"low": 0.0, "high": 1e-4},
        "mount.front-left.position.1": {"off": 0.01},
        "ground.level": {"values": ["VC-C", "VC-D"]},
    }
    assert space(scenario, vary).units == ("kg", "m", "m", "s", "m", "1")


def test_no_point_is_the_value_of_the_scenario(scenario: Scenario) -> None:
    own = space(scenario, {"machine.mass": {"low": 1000.0, "high": 2000.0}, "footprint.x": {"off": 0.1}})
    assert own.values(np.full((1, 2), np.nan)) == [own.nominal] == [{"machine.mass": 4000.0, "footprint.x": 1.8}]


def test_each_isolator_has_a_value_by_itself(scenario: Scenario) -> None:
    own = space(scenario, {FLOW: {"tolerance": 0.05, "each": True}})
    assert own.keys == tuple(f"mount.{mount.name}.actuator.flow_gain" for mount in scenario.mount)
    (row,) = own.values(np.array([[0.0, 0.5, 0.75, 1.0]]))
    np.testing.assert_allclose(np.array(list(row.values())) / 1.94e-6, [0.95, 1.0, 1.025, 1.05])


def test_correlated_normals_have_the_stated_correlation(scenario: Scenario) -> None:
    vary = {FLOW: {"deviation": 1e-8}, AREA: {"deviation": 1e-5}, "machine.mass": {"deviation": 10.0}}
    found = np.corrcoef([*columns(space(scenario, vary, (FLOW, AREA, 0.8), (AREA, "machine.mass", -0.4))).values()])
    np.testing.assert_allclose(found, [[1.0, 0.8, 0.0], [0.8, 1.0, -0.4], [0.0, -0.4, 1.0]], atol=0.03)


def test_correlated_ranges_have_the_rank_correlation_of_the_copula(scenario: Scenario) -> None:
    vary = {FLOW: {"tolerance": 0.1}, AREA: {"low": 0.005, "high": 0.02, "scale": "log"}}
    found = stats.spearmanr(*columns(space(scenario, vary, (FLOW, AREA, 0.6))).values()).statistic
    assert found == pytest.approx(6.0 / np.pi * np.arcsin(0.3), abs=0.02)


def test_correlated_values_keep_their_own_distributions(scenario: Scenario) -> None:
    vary = {FLOW: {"tolerance": 0.1}, AREA: {"tolerance": 0.1}}
    found = columns(space(scenario, vary, (FLOW, AREA, 0.9)))
    for values in found.values():
        middle = values.mean()
        assert stats.kstest(values, stats.uniform(0.9 * middle, 0.2 * middle).cdf).statistic < 0.015


def test_isolators_of_one_batch_go_together(scenario: Scenario) -> None:
    own = space(scenario, {FLOW: {"deviation": 1e-8, "each": True}}, (FLOW, FLOW, 0.7))
    found = np.corrcoef([*columns(own).values()])
    np.testing.assert_allclose(found[np.triu_indices(4, 1)], 0.7, atol=0.03)


def test_two_values_of_each_isolator_go_together_isolator_by_isolator(scenario: Scenario) -> None:
    vary = {FLOW: {"deviation": 1e-8, "each": True}, AREA: {"deviation": 1e-5, "each": True}}
    found = np.corrcoef([*columns(space(scenario, vary, (FLOW, AREA, 0.7))).values()])
    np.testing.assert_allclose(found[:4, 4:], 0.7 * np.eye(4), atol=0.03)


def test_a_design_has_the_same_values_to_the_bit_in_any_company(scenario: Scenario) -> None:
    vary = {
        FLOW: {"tolerance": 0.1, "shape": "normal", "each": True},
        AREA: {"low": 0.005, "high": 0.02, "scale": "log"},
        "machine.mass": {"low": 3000.0, "mode": 4000.0, "high": 4500.0},
        "machine.cg.0": {"mean": 0.0, "deviation": 0.01},
    }
    own = space(scenario, vary, (FLOW, FLOW, 0.7), (AREA, "machine.mass", 0.4))
    points = POINTS[:100, :7]
    alone = [own.values(points[k : k + 1])[0] for k in range(100)]
    assert own.values(points) == alone == [*own.values(points[:37]), *own.values(points[37:])]


MASS = {"machine.mass": {"tolerance": 0.1}}
THREE = {key: {"tolerance": 0.1} for key in ("machine.mass", FLOW, AREA)}


@pytest.mark.parametrize(
    ("vary", "together", "said"),
    [
        ({}, (), "vary: is empty"),
        ({"machine.mas": {"low": 1.0, "high": 2.0}}, (), "machine.mas = 1.0: unknown key; did you mean 'mass'?"),
        ({"machine.mass": {"low": -1.0, "high": 2.0}}, (), "vary: machine.mass = -1.0: must be greater than 0"),
        ({"actuators.iso.flow_gain": {"low": 1e-6, "high": 2e-6}}, (), "there are the actuators isolator"),
        ({"ground.level": {"values": ["VC-C", "VC-Q"]}}, (), "level = 'VC-Q' must be"),
        ({"ground.level": {"tolerance": 0.1}}, (), "the scenario has 'VC-C': state low and high"),
        ({"machine.cg.0": {"tolerance": 0.1}}, (), "which is 0: state off"),
        ({"seed": {"low": 0.5, "high": 2.0}}, (), "must be integers"),
        ({"machine.mass": {"tolerance": 0.1, "each": True}}, (), "must be actuators.(isolator).QUANTITY"),
        (
            MASS | {"machine": {"values": [{"mass": 1.0}, {"mass": 2.0}]}},
            (),
            "machine and machine.mass state one value",
        ),
        (MASS, (("machine.mass", "seed", 0.1),), "'seed' does not vary; must be one of machine.mass"),
        (MASS, (("machine.mass", "machine.mass", 0.1),), "goes with itself"),
        (THREE, ((FLOW, AREA, 0.1), (AREA, FLOW, 0.2)), "is said twice"),
        (
            MASS | {"ground.level": {"values": ["VC-C", "VC-D"]}},
            (("machine.mass", "ground.level", 0.5),),
            "values of ground.level have no order",
        ),
    ],
)
def test_what_cannot_be_is_refused_before_anything_runs(
    scenario: Scenario, vary: dict[str, Any], together: tuple[Any, ...], said: str
) -> None:
    with pytest.raises(InputError) as refused:
        space(scenario, vary, *together)
    assert said in str(refused.value)


def test_correlations_that_contradict_each_other_are_refused_with_what_would_do(scenario: Scenario) -> None:
    pairs = ((FLOW, AREA, 0.9), (AREA, "machine.mass", 0.9), (FLOW, "machine.mass", -0.9))
    with pytest.raises(InputError, match=r"eigenvalue -0\.8.*0\.\d+ times all of them would do") as refused:
        space(scenario, THREE, *pairs)
    times = float(str(refused.value).split("; ")[-1].split()[0])
    assert times == pytest.approx(1.0 / 1.8, abs=0.002)
    space(scenario, THREE, *((one, other, times * number) for one, other, number in pairs))
