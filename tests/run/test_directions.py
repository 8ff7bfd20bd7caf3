"""Runs of machines whose isolators act in any direction: symmetries, closed forms, and what readings say."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from ehamj import Controller, Result, parse_scenario, simulate
from ehamj.arrays import Array
from ehamj.linear.machine import linear_model
from ehamj.plant.mounts import DEFAULT_MOUNTS

SOFT = {
    "membrane_stiffness": 1e6, "membrane_damping": 3e3, "lateral_stiffness": 4e5, "lateral_damping": 2e3,
    "chamber_volume": 5e-3,
}  # fmt: skip
SOFT_FLOOR = {"kind": "sine", "dof": "x", "amplitude": 3e-4, "frequency": 3.0}


def eight(turned: float = 0.0, **table: Any) -> dict[str, Any]:
    """Four skew isolators and four level ones off the plane, all turned about z by an angle [rad]."""
    draw = np.random.default_rng(5)
    turn = np.array([[np.cos(turned), -np.sin(turned), 0], [np.sin(turned), np.cos(turned), 0], [0, 0, 1]]).round(15)
    mounts = []
    for k, (x, y) in enumerate(((0.7, 0.6), (0.7, -0.6), (-0.7, 0.6), (-0.7, -0.6))):
        skew = np.array([0.0, 0.0, 1.0]) + 0.2 * draw.normal(size=3)
        level = np.array([1.0, 0.0, 0.0] if k in (0, 3) else [0.0, 1.0, 0.0])
        for name, place, along in ((f"v{k}", [x, y, 0.0], skew), (f"h{k}", [x, 0.5 * y, 0.5 - 0.25 * k], level)):
            position, direction = ((turn @ one).round(15).tolist() for one in (place, along))
            mounts.append({"name": name, "position": position, "direction": direction})
    machine = {"size": [2.0, 2.0, 1.9], "inertia": [2000.0, 3000.0, 4000.0]}
    return {"mount": mounts, "machine": machine, "duration": 0.2, "output": {"report": False}, **table}


def run(table: dict[str, Any]) -> Result:
    return simulate(parse_scenario(table))


def moved(result: Result, name: str) -> Array:
    """A channel about its start."""
    values: Array = result.dataset[name].values
    return values - values[0]


def test_a_machine_that_is_turned_with_its_floor_moves_as_before() -> None:
    """By 90 degrees about z: feet are compared, since the hinges' order is not turned with them."""
    soft = {"isolator": SOFT}
    straight = run(eight(actuators=soft, ground=SOFT_FLOOR))
    machine = {"size": [2.0, 2.0, 1.9], "inertia": [3000.0, 2000.0, 4000.0]}
    across = {**SOFT_FLOOR, "dof": "y"}
    turned = run({**eight(np.pi / 2, actuators=soft, ground=across), "machine": machine})
    before, after = (one.dataset["foot_displacement"].values for one in (straight, turned))
    assert np.abs(before[0]).max() > 1e-3  # it leans on soft mounts, by mm and mrad
    expected = np.stack([-before[..., 1], before[..., 0], before[..., 2]], axis=-1)
    # What the plates' inertia on the linear coordinate leaves, 0.03 mrad; measured 3e-7.
    np.testing.assert_allclose(after, expected, atol=2e-6 * np.abs(moved(straight, "foot_displacement")).max())
    for name in ("stroke", "actuator_force", "chamber_pressure"):
        peak = np.abs(moved(straight, name)).max()
        np.testing.assert_allclose(turned.dataset[name].values, straight.dataset[name].values, atol=1e-5 * peak)


@pytest.mark.parametrize("plates", ["tied", "sliding"])
def test_upright_mounts_are_a_case_of_any_direction(plates: str) -> None:
    """A mount that is a picometre off the plane goes the general way; at µm and µrad both ways agree."""
    floor = {"kind": "broadband", "level": "VC-C"}
    mounts = [{"name": mount.name, "position": list(mount.position)} for mount in DEFAULT_MOUNTS]
    table = {"plates": plates, "duration": 0.3, "ground": floor, "mount": mounts, "machine": {"cg": [0.1, -0.05, 0.75]}}
    flat = run(table)
    mounts[0]["position"] = [*DEFAULT_MOUNTS[0].position, 1e-12]
    general = run(table)
    assert flat.scenario.plant.flat
    assert not general.scenario.plant.flat
    for name in ("machine_displacement", "stroke", "actuator_force", "foot_velocity"):
        peak = np.abs(moved(flat, name)).max()
        # Products of the angle at rest (10 µrad) and lateral forces, which the flat way leaves out.
        np.testing.assert_allclose(general.dataset[name].values, flat.dataset[name].values, atol=1e-4 * peak, rtol=1e-9)


@pytest.mark.parametrize("plates", ["tied", "sliding"])
def test_a_sensor_reads_the_stroke_that_is_recorded(plates: str) -> None:
    """On soft mounts at half a metre, where the finite turn of the foot is µm of it."""
    table = eight(plates=plates, actuators={"isolator": SOFT}, ground=SOFT_FLOOR)
    names = [mount["name"] for mount in table["mount"]]
    inputs = (*(f"stroke {name}" for name in names), *(f"stroke_velocity {name}" for name in names))
    nothing = np.zeros((len(names), len(inputs)))
    empty = (np.zeros((0, 0)), np.zeros((0, len(inputs))), np.zeros((len(names), 0)), nothing)
    watching = Controller(*empty, inputs, 1e-3, 1e-3, mounts=tuple(names))
    result = simulate(parse_scenario(table), controller=watching)
    read = result.dataset["measured"].values
    for part, name in ((read[:, :8], "stroke"), (read[:, 8:], "stroke_velocity")):
        there = result.dataset[name].values
        np.testing.assert_allclose(part, there, atol=1e-12 * np.abs(there).max())


@pytest.mark.parametrize("lifted", [0.0, 1e-12])
@pytest.mark.parametrize("plates", ["tied", "sliding"])
def test_shims_under_all_mounts_lift_the_machine_and_load_nothing(plates: str, lifted: float) -> None:
    def resting(height: float) -> Result:
        mounts = [
            {"name": mount.name, "position": [*mount.position, lifted], "height": height} for mount in DEFAULT_MOUNTS
        ]
        return run({"plates": plates, "mount": mounts, "duration": 0.01})

    plain, shimmed = resting(0.0).dataset, resting(2e-3).dataset
    np.testing.assert_allclose(
        shimmed.machine_displacement.sel(dof="z") - plain.machine_displacement.sel(dof="z"), 2e-3
    )
    np.testing.assert_allclose(shimmed.stroke, plain.stroke, atol=1e-14)
    np.testing.assert_allclose(shimmed.chamber_pressure, plain.chamber_pressure, rtol=1e-8)


def test_a_level_isolator_pushes_the_machine_as_its_closed_form_says() -> None:
    """Along its direction alone: four upright ones and one along x through the centre of gravity, without oil.

    Upright membranes have k_h each across x, the level one K_L along it; the machine with its plate m_p is one mass.
    """
    mounts = [{"name": mount.name, "position": [*mount.position, 0.75]} for mount in DEFAULT_MOUNTS]
    mounts.append({"name": "level", "position": [-0.9, 0.0, 0.75], "direction": [1, 0, 0]})
    dry = {"preset": "elastic-mount"}
    plant = parse_scenario({"plates": "tied", "mount": mounts, "actuators": {"isolator": dry}}).plant
    own = plant.actuators[0]
    found = np.linalg.eigvals(linear_model(replace(plant, gravity=0.0)).A)
    stiffness = 4 * own.lateral_stiffness + own.membrane_stiffness
    damping = 4 * own.lateral_damping + own.membrane_damping
    mass = plant.machine.mass + own.plate_mass
    expected = np.roots([mass, damping, stiffness])[0]
    assert np.abs(found - expected).min() < 1e-6 * abs(expected)  # of the differences


def test_a_flexible_foot_of_a_level_isolator_is_in_series_with_it() -> None:
    """A steady force along x through the centre of gravity: membrane K_L and foot k_f are in series."""
    mounts = [{"name": mount.name, "position": [*mount.position, 0.75]} for mount in DEFAULT_MOUNTS]
    mounts.append({"name": "level", "position": [-0.9, 0.0, 0.75], "direction": [1, 0, 0]})
    foot = {"foot_stiffness": 3e8}
    table = {"plates": "sliding", "mount": mounts, "gravity": 0.0, "actuators": {"isolator": foot}}
    plant = parse_scenario(table).plant
    own, pushed = plant.actuators[0], linear_model(plant, load=(1000.0, 0, 0, 0, 0, 0)).equilibrium
    series = 1.0 / (1.0 / own.membrane_stiffness + 1.0 / 3e8)
    assert pushed[0] == pytest.approx(1000.0 / (4 * own.lateral_stiffness + series), rel=1e-8)
