"""Sensitivities: against differences of the eigenvalues themselves, and closed forms."""

from typing import Any

import numpy as np
import pytest

from ehamj.control import Controller
from ehamj.designs.parameters import parameters_of, value_of, with_value
from ehamj.designs.sensitivity import sensitivities
from ehamj.errors import InputError
from ehamj.linear.loop import Loop
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.plant.mounts import DEFAULT_MOUNTS, MOUNTS
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

DEFAULT = parse_scenario({})
UNEVEN = parse_scenario({"machine": {"cg": [0.15, -0.1, 0.9], "inertia": [2500.0, 3600.0, 4100.0]}})


def feedback() -> Controller:
    strokes = tuple(f"stroke {mount}" for mount in MOUNTS)
    return Controller(np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((4, 0)), -2e6 * np.eye(4), strokes)


def differences(scenario: Scenario, key: str, law: Controller | None = None, step: float = 5e-4) -> np.ndarray:
    """d ln f/d ln p and dζ/d ln p of every mode by solving the changed machines, (2, modes)."""
    ends, loop = [], Loop.of(scenario, law)
    for sign in (1, -1):
        changed = with_value(scenario, key, value_of(scenario, key) * np.exp(sign * step))
        ends.append(
            np.array([(np.log(m.frequency), m.damping_ratio) for m in modes(linear_model(changed.plant), loop)]).T
        )
    return np.asarray((ends[0] - ends[1]) / (2 * step))


@pytest.mark.parametrize(
    "key",
    [
        "machine.mass", "machine.inertia.1", "machine.cg.2", "machine.cg.0", "footprint.x", "gravity",
        "actuators.isolator.lateral_stiffness", "actuators.isolator.piston_area", "actuators.isolator.flow_pressure",
        "actuators.isolator.membrane_damping", "actuators.isolator.valve_frequency",
    ],
)  # fmt: skip
def test_slopes_are_differences_of_the_eigenvalues(key: str) -> None:
    found = sensitivities(UNEVEN, parameters=[key])
    expected = differences(UNEVEN, key)
    # 1e-5: steps of 0.1 and 0.05 %, squared, and the matrices' rounding of 1e-9 over them.
    np.testing.assert_allclose(found.frequency.sel(parameter=key), expected[0], atol=1e-5)
    np.testing.assert_allclose(found.damping.sel(parameter=key), expected[1], atol=1e-5)


@pytest.mark.parametrize("key", ["machine.mass", "actuators.isolator.flow_gain", "actuators.isolator.valve_damping"])
def test_slopes_of_a_closed_loop_are_differences_of_its_eigenvalues(key: str) -> None:
    law = feedback()
    found, expected = sensitivities(UNEVEN, law, parameters=[key]), differences(UNEVEN, key, law)
    np.testing.assert_allclose(found.frequency.sel(parameter=key), expected[0], atol=2e-5)
    np.testing.assert_allclose(found.damping.sel(parameter=key), expected[1], atol=2e-5)
    assert float(abs(found.frequency).max()) > 1e-3


def test_yaw_follows_its_spring_and_inertia() -> None:
    keys = ["actuators.isolator.lateral_stiffness", "machine.inertia.2", "footprint.x", "machine.mass"]
    slopes = sensitivities(DEFAULT, parameters=keys).sel(mode="yaw")
    # f ~ √(k (a² + b²)/J), ζ ~ c (a² + b²)/√(k (a² + b²) J).
    share = 0.9**2 / (0.9**2 + 0.6**2)
    np.testing.assert_allclose(slopes.frequency, [0.5, -0.5, share, 0.0], atol=1e-6)
    damping = 2e4 * 4 * 1.17 / 2 / np.sqrt(2e8 * 4 * 1.17 * 4000)
    np.testing.assert_allclose(slopes.damping, np.array([-0.5, -0.5, share, 0.0]) * damping, atol=1e-6)


def test_of_four_equal_valves_the_changed_one_moves() -> None:
    table: dict[str, Any] = {
        "mount": [m.model_dump() | {"actuator": m.name} for m in DEFAULT_MOUNTS],
        "actuators": {mount: {} for mount in MOUNTS},
    }
    slopes = sensitivities(parse_scenario(table), parameters=["actuators.rear-left.valve_frequency"])
    valves = slopes.frequency[0].sel(mode=[f"valve {mount}" for mount in MOUNTS])
    np.testing.assert_allclose(valves, [0, 0, 1, 0], atol=1e-6)


def test_bypassed_heave_follows_the_membranes() -> None:
    keys = ["actuators.isolator.membrane_stiffness", "actuators.isolator.bulk_modulus"]
    slopes = sensitivities(DEFAULT, bypassed=True, parameters=keys).sel(mode="heave")
    np.testing.assert_allclose(slopes.frequency, [0.5, 0.0], atol=1e-6)


def test_every_parameter_with_a_logarithm_is_taken() -> None:
    keys = parameters_of(DEFAULT)
    assert {"machine.cg.2", "footprint.y", "actuators.isolator.membrane_stiffness", "gravity"} <= set(keys)
    assert not {"machine.cg.0", "actuators.isolator.air_fraction", "actuators.isolator.foot_stiffness"} & set(keys)


def test_a_value_is_changed_and_read() -> None:
    for key in parameters_of(UNEVEN):
        factor = 1.001
        changed = with_value(UNEVEN, key, factor * value_of(UNEVEN, key))
        assert value_of(changed, key) == pytest.approx(factor * value_of(UNEVEN, key), rel=1e-12), key
        others = set(parameters_of(UNEVEN)) - {key}
        assert all(value_of(changed, other) == pytest.approx(value_of(UNEVEN, other), rel=1e-12) for other in others)


@pytest.mark.parametrize(
    ("key", "message"),
    [("machine.cg.0", "machine.cg.0 = 0: must be neither"), ("machine.colour", "'machine.colour' must be")],
)
def test_what_has_no_logarithm_is_refused(key: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        sensitivities(DEFAULT, parameters=[key])
    assert message in str(caught.value)
