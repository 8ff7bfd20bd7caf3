"""Maps of rocking, lateral stiffness and unequal loads against closed forms and the simulator."""

from typing import Any

import numpy as np
import pytest

from ehamj.errors import InputError
from ehamj.scenario.load import parse_scenario
from ehamj.studies import lateral, rocking, soft_mounts, unequal
from ehamj.studies.study import Study
from ehamj.studies.variants import preset, resized

MACHINE = parse_scenario({"name": "a machine", "plates": "tied"})


def test_the_map_has_2500_designs_and_the_tipping_boundary_in_it() -> None:
    """Every design on the tipping side of the closed form, and no other, has a negative margin and grows."""
    settings = rocking.RockingSettings()
    table = rocking.soft_map(MACHINE, settings)
    assert table["tipping_margin"].size >= 2500
    closed = [
        min(soft_mounts.tipping_height(soft_mounts.tall(MACHINE, preset(settings.soft), 1.0, w).plant))
        for w in table["width"].values
    ]
    over = table["height"].values[:, None] / np.array(closed)
    clear = np.abs(over - 1.0) > 1e-6
    falls = (table["growth_rate"].transpose("height", "width").values > 1e-3)[clear]
    assert np.array_equal(falls, over[clear] > 1.0)
    assert np.array_equal(table["tipping_margin"].transpose("height", "width").values[clear] < 0.0, over[clear] > 1.0)
    assert 100 < falls.sum() < 1000


def test_random_designs_agree_with_nonlinear_ring_downs() -> None:
    """Two per mille is asked for; the study itself runs twenty, and finds 3e-6."""
    runs = rocking.confirmed_designs(MACHINE, rocking.RockingSettings(confirmed=2))
    assert float(np.abs(runs["deviation"]).max()) < 1e-4


def test_yaw_is_the_lateral_springs_on_the_inertia() -> None:
    """ω² = Σ k r²/J, plates being constrained laterally: exact, but for the damping's rounding."""
    table = lateral.lateral_stiffness(MACHINE, lateral.LateralSettings(points=5)).tables["modes"]
    plant = MACHINE.plant
    lever = sum(x**2 + y**2 for x, y, _ in plant.positions)
    expected = np.sqrt(table["stiffness"].values * lever / plant.machine.inertia[2]) / (2 * np.pi)
    assert table["frequency"].sel(mode="yaw").values == pytest.approx(expected, rel=1e-9)


def test_loads_are_those_of_levers() -> None:
    """Four equal springs under a rigid machine: F = W/4 + moments over lever arms; 1e-6 is gravity's own tipping."""
    table = unequal.loads_map(MACHINE, unequal.UnequalSettings(points=5, reach=0.8))
    plant = MACHINE.plant
    weight, plates = plant.machine.mass * plant.gravity, 14.0 * plant.gravity
    x, y = (table[axis].values for axis in "xy")
    for mount, (a, b, _) in enumerate(plant.positions):
        expected = 0.25 * weight * (1.0 + x[None, :] / a) * 1.0 + 0.25 * weight * y[:, None] / b + plates
        got = table["load"].isel(mount=mount).transpose("y", "x").values
        assert got == pytest.approx(expected, rel=2e-4), mount


def test_random_loads_agree_with_the_simulator() -> None:
    runs = unequal.confirmed_loads(MACHINE, unequal.UnequalSettings(confirmed=3))
    assert runs["simulated"].values == pytest.approx(runs["load"].values, abs=1e-3)


def test_a_centred_machine_is_not_turned_by_a_heaving_floor() -> None:
    table = unequal.loads_map(MACHINE, unequal.UnequalSettings(points=3))
    assert float(table["turn"].sel(x=0.0, y=0.0)) < 1e-12
    assert float(table["turn"].min("x").isel(y=0)) > 1e-3


def test_the_outline_grows_with_the_mounts() -> None:
    """A wide footprint and a high CG stay inside the outline, which only the drawing uses."""
    places = 2.0 * np.array(MACHINE.plant.positions)
    grown = parse_scenario(MACHINE.model_dump() | resized(MACHINE, (0.0, 0.0, 3.0), places))
    assert grown.machine.size[0] > 3.6
    assert grown.machine.size[2] > 3.0
    assert grown.machine.mass == MACHINE.machine.mass
    assert np.array(grown.plant.positions) == pytest.approx(places)


@pytest.mark.parametrize(
    ("study", "values", "words"),
    [
        (rocking.rocking, {"heights": (1.0, 0.5)}, r"heights = \[1.0, 0.5\]: must be two rising numbers"),
        (lateral.lateral_stiffness, {"factors": (0.0, 1.0)}, r"factors.0 = 0.0: must be greater than 0"),
        (lateral.lateral_stiffness, {"factors": (2.0, 3.0)}, r"factors = \[2.0, 3.0\]: must enclose 1"),
        (unequal.unequal_loads, {"reach": -1.0}, r"reach = -1.0: must be greater than 0"),
    ],
)
def test_ranges_are_checked(study: Study[Any], values: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        study.with_settings(values)
