"""What mounts carry at rest and the shims that level: closed forms, and the command that prints them."""

import json
from typing import Any

import numpy as np
import pytest
from harness import Cli

import ehamj
from ehamj.errors import InputError
from ehamj.scenario.load import parse_scenario

G = 9.80665
WEIGHT = 4056.0 * G
CORNERS = np.array([(0.9, 0.6), (0.9, -0.6), (-0.9, 0.6), (-0.9, -0.6)])
LEVEL = ((-0.9, 0.0), (0.0, 0.6))


def mounted(places: Any, directions: Any = None, heights: Any = None, **table: Any) -> dict[str, Any]:
    """A table of mounts m0, m1, … and what else is given."""
    n = len(places)
    ways, shims = directions or ((0.0, 0.0, 1.0),) * n, (0.0,) * n if heights is None else heights
    mounts = [
        {"name": f"m{k}", "position": list(place), "direction": list(way), "height": float(shim)}
        for k, (place, way, shim) in enumerate(zip(places, ways, shims, strict=True))
    ]
    return {"mount": mounts, **table}


def test_three_mounts_carry_what_statics_alone_says() -> None:
    places, cg = np.array([(0.9, 0.1), (-0.8, 0.6), (-0.7, -0.5)]), np.array([0.1, 0.05])
    loads = ehamj.static_loads(parse_scenario(mounted(places, machine={"cg": [*cg, 0.75]})))
    plates = 14.0 * G
    machine = np.linalg.solve([np.ones(3), *places.T], 4000.0 * G * np.array([1.0, *cg]))
    # To the tilt's moment of the CG: m g h φ / K r², 1e-4 of each.
    np.testing.assert_allclose(loads.along, machine + plates, rtol=3e-4)
    assert loads.along.sum() == pytest.approx(loads.weight, rel=1e-9)


def test_equal_upright_mounts_carry_by_the_pseudo_inverse() -> None:
    """Over-determined: eight equal mounts share as (Jᵀ)⁺ says."""
    rng = np.random.default_rng(2)
    places = rng.uniform((-1.0, -0.7), (1.0, 0.7), (8, 2))
    loads = ehamj.static_loads(parse_scenario(mounted(places, machine={"cg": [0.1, -0.05, 0.75]})))
    rows = np.array([[1.0, y, -x] for x, y in places])
    wrench = np.array([4000.0 * G + 8 * 14.0 * G, *(rows[:, 1:] * 14.0 * G).sum(axis=0)])
    wrench[1:] += 4000.0 * G * np.array([-0.05, -0.1])
    # To the moment of a CG that tilts: m g h φ / Σ K r² = 1e-5 of the moments.
    np.testing.assert_allclose(loads.along, np.linalg.pinv(rows.T) @ wrench, rtol=0, atol=5e-5 * loads.along.max())


def test_a_shim_loads_a_diagonal_by_warp() -> None:
    """A shim h below one corner of four: ± K h/4 on top of a quarter of the weight."""
    loads = ehamj.static_loads(parse_scenario(mounted(CORNERS, heights=[4e-6, 0.0, 0.0, 0.0])))
    warp = 6.8e8 * 4e-6 / 4 * np.array([1.0, -1.0, -1.0, 1.0])
    np.testing.assert_allclose(loads.along, WEIGHT / 4 + warp, rtol=1e-4)  # the plane that fits tilts by microradians


def test_a_level_mount_s_plate_is_carried_by_its_guide() -> None:
    table = mounted((*CORNERS, *LEVEL), (*((0.0, 0.0, 1.0),) * 4, (1.0, 0.0, 0.0), (0.0, -1.0, 0.0)))
    loads = ehamj.static_loads(parse_scenario(table))
    np.testing.assert_allclose(loads.guided[4:, 2], 14.0 * G, rtol=1e-12)
    assert not loads.guided[:4].any()
    up = loads.across[:, 2].sum() + loads.guided[:, 2].sum() + loads.along[:4].sum()
    assert up == pytest.approx(loads.weight, rel=1e-9)


@pytest.mark.parametrize("goal", ["level", "equal"])
@pytest.mark.parametrize("foot", [float("inf"), 2e9])
def test_shims_take_the_tilt_away_in_the_simulated_machine(goal: str, foot: float) -> None:
    actuators = {"isolator": {"foot_stiffness": foot, "area_ratio": 0.99}}  # the oil carries some
    table = {"machine": {"cg": [0.1, -0.05, 0.75]}, "actuators": actuators}
    places = (*CORNERS, (0.2, 0.1))
    before = ehamj.static_loads(parse_scenario(mounted(places, **table)))
    after = ehamj.static_loads(parse_scenario(mounted(places, heights=before.shims(goal), **table)))
    assert before.tilt > 1e-6
    assert after.tilt < 1e-4 * before.tilt
    assert abs(before.oil).min() > 1e3
    if goal == "equal":
        assert abs(after.displacement[2]) < 1e-4 * abs(before.displacement[2])
        assert np.std(after.along) < np.std(before.along) + 1.0


def test_shims_of_another_kind_are_refused() -> None:
    with pytest.raises(InputError, match="'flat': must be one of level, equal"):
        ehamj.static_loads("benchmark").shims("flat")


def test_a_slide_loads_the_mounts_that_it_stands_by() -> None:
    slide = {
        "name": "table",
        "mass": 1000.0,
        "position": [0.0, 0.0, 0.9],
        "rail": [1.0, 0.0, 0.0],
        "travel": [-0.5, 0.5],
    }
    machine = parse_scenario(mounted(CORNERS, slide=[slide]))
    middle, front = (ehamj.static_loads(machine, {"table": at}) for at in (0.0, 0.4))
    moved = 1000.0 * G * 0.4 / (4 * 0.9) * np.array([1.0, 1.0, -1.0, -1.0])
    np.testing.assert_allclose(front.along - middle.along, moved, rtol=1e-3)  # softened by gravity: 1e-5
    with pytest.raises(InputError, match="travel"):
        ehamj.static_loads(machine, {"table": 0.8})


def test_the_command_prints_a_row_per_mount_and_what_is_actuated(cli: Cli) -> None:
    said = cli("statics", "benchmark", "--shims", "level")
    assert said.code == 0
    for words in ("front-left", "rear-right", "along [N]", "level", "actuated: heave, roll, pitch", "warp"):
        assert words in said.out


def test_the_command_gives_numbers_as_json(cli: Cli) -> None:
    found = cli("statics", "benchmark", "--set", "gravity=9.80665", "--shims", "equal", "--json").json
    loads = [mount["along_n"] for mount in found["mounts"].values()]
    assert sum(loads) == pytest.approx(found["weight_n"], rel=1e-9)
    assert found["actuated"] == ["heave", "roll", "pitch"]
    assert set(found["shims"]) == set(found["mounts"])
    json.dumps(found)


def test_the_command_refuses_what_cannot_stand(cli: Cli) -> None:
    message = cli("statics", "benchmark", "--set", "actuators.isolator.lateral_stiffness=0").message
    assert "nothing holds sliding along x (0 N/m)" in message
