"""An inertia that is left out is that of a homogeneous box, and somebody says so."""

import numpy as np
import pytest
from scipy.integrate import tplquad

from ehamj.plant.machine import Machine, box_inertia
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
    assert found.machine.inertia == box_inertia(6000.0, (2.2, 1.6, 1.9))
    assert found.machine.sources["inertia"] == "assumed"
    heavier = changed(found, {"machine.mass": 7000.0})
    assert np.allclose(heavier.machine.inertia, np.multiply(found.machine.inertia, 7.0 / 6.0))
    given = parse_scenario({"machine": {"mass": 6000.0, "inertia": [2000.0, 3000.0, 4000.0]}})
    assert changed(given, {"machine.mass": 7000.0}).machine.inertia == (2000.0, 3000.0, 4000.0)
    assert given.machine.assumptions == Machine().assumptions == ()


def test_the_default_machine_stays_as_it_was() -> None:
    for table in ({}, {"mass": 4000.0}, {"cg": [0.1, 0.0, 0.8]}, {"size": [2.2, 1.6, 1.9]}):
        assert parse_scenario({"machine": table}).machine.inertia == (2000.0, 3000.0, 4000.0)
    assert load_scenario("benchmark").machine.inertia == (2000.0, 3000.0, 4000.0)


def test_it_is_said() -> None:
    (said,) = parse_scenario({"machine": {"mass": 6000.0}}).machine.assumptions
    assert "machine.inertia was not given: [3085, 4225, 3700] kg m²" in said
    assert "6000 kg, 2.2 × 1.6 × 1.9 m" in said
