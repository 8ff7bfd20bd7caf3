"""An inertia that is left out is the default machine's, scaled, and somebody says so."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import tplquad

from ehamj.plant.bodies import box_inertia
from ehamj.plant.machine import Machine
from ehamj.scenario.load import changed, load_scenario, parse_scenario


def test_the_box_is_the_integral_over_its_volume() -> None:
    mass, (a, b, c) = 5200.0, (2.0, 1.5, 1.0)
    density = mass / (a * b * c)
    for axis, found in enumerate(box_inertia(mass, (a, b, c))):
        others = [k for k in range(3) if k != axis]
        value, _ = tplquad(
            lambda z, y, x: density * sum((x, y, z)[k] ** 2 for k in others),  # noqa: B023
            -a / 2, a / 2, -b / 2, b / 2, -c / 2, c / 2,
        )  # fmt: skip
        assert found == pytest.approx(value, rel=1e-9)


def test_it_follows_mass_and_size_unless_it_is_given() -> None:
    found = parse_scenario({"machine": {"mass": 6000.0}})
    assert found.machine.inertia == (3000.0, 4500.0, 6000.0)
    assert found.machine.sources["inertia"] == "assumed"
    heavier = changed(found, {"machine.mass": 7000.0})
    assert np.allclose(heavier.machine.inertia, np.multiply(found.machine.inertia, 7.0 / 6.0))
    stated = parse_scenario({"machine": {"mass": 6000.0, "inertia": [2000.0, 3000.0, 4000.0]}})
    assert changed(stated, {"machine.mass": 7000.0}).machine.inertia == (2000.0, 3000.0, 4000.0)
    assert stated.machine.assumptions == Machine().assumptions == ()


def test_a_shape_stretched_is_the_points_stretched() -> None:
    """Six masses at the default's mean distances stand for it: their moments after stretching are summed by hand."""
    size = (1.1, 3.2, 0.95)
    half = np.sqrt(3.0 * np.array([0.625, 0.375, 0.125])) * np.array([0.5, 2.0, 0.5])
    points = np.concatenate([np.diag(half), -np.diag(half)])
    expected = [1000.0 * np.sum(np.delete(points, axis, 1) ** 2) for axis in range(3)]
    found = Machine(mass=6000.0, size=size, cg=(0.0, 0.0, 0.4))
    np.testing.assert_allclose(found.inertia, expected, rtol=1e-12)


@given(st.floats(1.0, 1e6), st.tuples(*[st.floats(0.05, 50.0)] * 3), st.floats(-1e-6, 1e-6))
def test_every_mass_and_outline_has_an_inertia_near_its_neighbours(
    mass: float, size: tuple[float, float, float], off: float
) -> None:
    found, beside = (Machine(mass=one, size=size, cg=(0.0, 0.0, 0.0)) for one in (mass, mass * (1 + off)))
    np.testing.assert_allclose(beside.inertia, np.array(found.inertia) * (1 + off), rtol=1e-12)


def test_the_default_machine_stays_as_it_was() -> None:
    for table in ({}, {"mass": 4000.0}, {"cg": [0.1, 0.0, 0.8]}, {"size": [2.2, 1.6, 1.9]}):
        assert parse_scenario({"machine": table}).machine.inertia == (2000.0, 3000.0, 4000.0)
    assert load_scenario("benchmark").machine.inertia == (2000.0, 3000.0, 4000.0)


def test_it_is_said() -> None:
    (said,) = parse_scenario({"machine": {"mass": 6000.0}}).machine.assumptions
    assert "machine.inertia was not given: [3000, 4500, 6000] kg m²" in said
    assert "the default machine's, scaled to 6000 kg and 2.2 × 1.6 × 1.9 m" in said


def test_a_mass_in_tonnes_is_noticed() -> None:
    """4 t written as 4 [kg]; its outline holds 2.2·1.6·1.9·1.2 = 8 kg of air."""
    said, _ = parse_scenario({"machine": {"mass": 4.0}}).machine.assumptions
    assert said.endswith("weighs (8 kg): masses are in kg, 4 t are 4000")
    assert not any("air" in one for one in parse_scenario({"machine": {"mass": 10.0}}).machine.assumptions)
