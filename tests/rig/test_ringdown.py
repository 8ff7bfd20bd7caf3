"""Modes from a ring-down: of signals whose eigenvalues are known, and of a machine in closed form."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from ehamj.estimate.identification import realise
from ehamj.rig.modal_test import modal_test
from ehamj.scenario.load import parse_scenario


@settings(max_examples=30)
@given(st.lists(st.tuples(st.floats(5.0, 80.0), st.floats(0.005, 0.2)), min_size=1, max_size=3), st.integers(0, 99))
def test_eigenvalues_of_a_sum_of_decays_are_found(modes: list[tuple[float, float]], seed: int) -> None:
    poles = np.array([2 * np.pi * f * complex(-z, np.sqrt(1 - z * z)) for f, z in modes])
    assume(len(modes) == 1 or np.abs(np.subtract.outer(poles, poles))[~np.eye(len(modes), dtype=bool)].min() > 40.0)
    random = np.random.default_rng(seed)
    shapes = random.uniform(0.3, 1.0, (len(modes), 3)) * np.exp(2j * np.pi * random.uniform(size=(len(modes), 3)))
    times = np.arange(80) / 400.0
    decay = (np.exp(np.outer(times, poles)) @ shapes).real
    ((found, _),) = realise(decay, 400.0, [2 * len(modes)])
    upper = found[found.imag > 0]
    for pole in poles:
        # Exact data: rounding of 1e-16, magnified by modes that lie near each other.
        assert np.abs(upper - pole).min() <= 1e-6 * abs(pole)


def test_eigenvalues_come_by_magnitude_and_as_many_as_asked_for() -> None:
    times = np.arange(300) / 1000.0
    decay = np.column_stack([np.exp(-20 * times) * np.sin(2 * np.pi * f * times) for f in (90.0, 30.0)])
    ((found, _),) = realise(decay, 1000.0, [4])
    assert found.size == 4
    assert np.all(np.diff(np.abs(found)) >= -1e-6)


def test_the_ring_down_holds_the_modes_of_a_stiffer_machine() -> None:
    # Not the default's numbers by heart: yaw alone is Σ k r²/J, here of twice the stiffness and 0.7 of the inertia.
    table = {"machine": {"inertia": [2000.0, 3000.0, 2800.0]}, "actuators": {"isolator": {"lateral_stiffness": 4e8}}}
    found = modal_test(parse_scenario(table), "ring-down").modes
    expected = np.sqrt(4e8 * 4 * (0.9**2 + 0.6**2) / 2800.0) / (2 * np.pi)
    (yaw,) = (mode for mode in found if mode.name == "yaw")
    assert yaw.frequency == pytest.approx(expected, rel=5e-4)  # the step's own error is 1e-4
