"""What holds a machine: stiffness against the oracle that moves it in space, refusals, and shims."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from oracles import general

from ehamj.errors import InputError
from ehamj.plant import statics
from ehamj.plant.plant import Plant
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

SKEW = ((0.3, 0.1, 1.0), (-0.2, 0.4, 1.0), (0.0, -0.3, 1.0), (0.1, 0.0, 1.0), (1.0, 0.2, 0.1), (0.2, -1.0, 0.3))
PLACES = ((0.9, 0.6, 0.5), (0.8, -0.6, 0.0), (-0.9, 0.5, -0.5), (-0.7, -0.6, 0.3), (-0.9, 0.0, 0.2), (0.1, 0.6, -0.4))
CG = [0.05, -0.1, 0.9]
CORNERS = ((0.9, 0.6), (0.9, -0.6), (-0.9, 0.6), (-0.9, -0.6))
SOFT = {"actuators": {"isolator": {"preset": "elastic-mount"}}}


def table(places: Any, directions: Any = None, **rest: Any) -> dict[str, Any]:
    """A machine on mounts at these places."""
    ways = directions or ((0.0, 0.0, 1.0),) * len(places)
    mounts = [
        {"name": f"m{k}", "position": place, "direction": way}
        for k, (place, way) in enumerate(zip(places, ways, strict=True))
    ]
    return {"mount": mounts, **rest}


def plant(places: Any, directions: Any = None, **rest: Any) -> Plant:
    return parse_scenario(table(places, directions, **rest)).plant


def wrench(of: general.GeneralMachine, q: np.ndarray) -> np.ndarray:
    """Force and moment on the machine held at q, oil at mid pressure."""
    n = len(of.mounts)
    state, still = np.zeros(12 + 4 * n), np.zeros((n, 3))
    state[:6] = q
    return np.asarray(of.equations.balance(0.0, state, still, still)[1])


def restoring(of: general.GeneralMachine, at: np.ndarray) -> np.ndarray:
    """Stiffness by differences of what pushes back."""
    slopes = [(wrench(of, at + shift) - wrench(of, at - shift)) / 2e-5 for shift in 1e-5 * np.eye(6)]
    return -np.array(slopes).T


def equally_loaded(of: Plant) -> Plant:
    """On shims that hold it where it was built."""
    return replace(of, heights=tuple(statics.level_shims(of, np.zeros(len(of.mounts)), equal=True)))


def test_stiffness_of_membranes_and_gravity_is_what_the_oracle_feels() -> None:
    # At its place, so that levers are those of the drawing; differences of 1e-5 rad are good to 1e-9 of 1e6 N/m.
    own = equally_loaded(plant(PLACES, SKEW, machine={"cg": CG}, **SOFT))
    found = statics.elastic_stiffness(own) + statics.gravity_stiffness(own)
    felt = restoring(general.of_plant(own), np.zeros(6))
    assert np.abs(statics.gravity_stiffness(own)).max() > 1e4
    np.testing.assert_allclose(found, felt, atol=1e-2)


def test_gravity_of_upright_mounts_is_the_textbook_s() -> None:
    upright = plant(CORNERS)
    rocking = -4000.0 * 9.80665 * 0.75
    expected = np.diag([0, 0, 0, rocking, rocking, 0])
    np.testing.assert_allclose(statics.gravity_stiffness(upright), expected, atol=1e-6)


def test_equal_shims_hold_the_machine_at_its_place_by_the_pseudo_inverse() -> None:
    own = equally_loaded(plant(PLACES, SKEW, machine={"cg": CG}, **SOFT))
    springs = np.array([a.membrane_stiffness for a in own.actuators])
    closed = np.linalg.pinv(own.layout.rows.T) @ -statics.weight(own)
    np.testing.assert_allclose(springs * own.heights, closed, rtol=1e-9)
    assert np.abs(wrench(general.of_plant(own), np.zeros(6))).max() < 1e-6  # N of 4e4


def test_level_shims_take_the_tilt_away_and_are_the_thinnest() -> None:
    own = plant((*CORNERS, (0.3, 0.1)), machine={"cg": CG})
    shims = statics.level_shims(own, np.zeros(5), equal=False)
    found = general.equilibrium(general.of_plant(replace(own, heights=tuple(shims))))
    before = general.equilibrium(general.of_plant(own))
    assert np.abs(before[3:5]).max() > 1e-6
    assert np.abs(found[3:5]).max() < 1e-5 * np.abs(before[3:5]).max()  # of second order in 4e-6 rad
    # Any other shims without tilt differ by ones that tilt nothing, and these are orthogonal to those.
    neutral = np.linalg.svd(np.array([[1.0] * 5, [y for _, y, _ in own.positions], [x for x, _, _ in own.positions]]))
    lifts = np.ones(5)  # all alike only lift
    tilting = neutral[2][:3].T
    assert abs(shims @ lifts) < 1e-9
    np.testing.assert_allclose(tilting @ (tilting.T @ shims), shims, atol=1e-12)


@pytest.mark.parametrize(
    ("bad", "parts"),
    [
        (table(((0.9, 0.0), (0.0, 0.0), (-0.9, 0.0))), ["cannot stand", "turning about x (0 N m/rad)"]),
        (
            table(((0.5, 0.1), (0.0, 0.1), (-0.5, 0.1, 0.0))),
            ["turning about x through (0, 0.1, 0) m (0 N m/rad)"],
        ),
        (
            table(CORNERS, actuators={"isolator": {"lateral_stiffness": 0.0}}),
            ["sliding along x (0 N/m), sliding along y (0 N/m) and turning about z (0 N m/rad)", "lateral_stiffness"],
        ),
        (
            table(CORNERS, ((1.0, 1.0, 0.0),) * 4, actuators={"isolator": {"lateral_stiffness": 0.0}}),
            ["sliding along z", "sliding along (0.707, -0.707, 0) (0 N/m)"],
        ),
        (
            table(CORNERS, actuators={"isolator": {"membrane_stiffness": 0.0}}),
            ["sliding along z", "about x", "about y"],
        ),
        (table(CORNERS[:2]), ["there are 2", "3 to 32"]),
        (table(np.linspace((-0.9, -0.6), (0.9, 0.6), 33).tolist()), ["there are 33", "3 to 32"]),
        (table(CORNERS, ((0.0, 0.0, 0.0), *((0.0, 0.0, 1.0),) * 3)), ["direction = [0.0, 0.0, 0.0]", "no length"]),
        ({"mount": [table(CORNERS)["mount"][0]] * 4}, ["mount.1.name = 'm0' must be unique"]),
        (table(((0.9, 0.6, 2.0), *CORNERS[1:])), ["m0", "[0.9, 0.6, 2.0]", "±1.9 m in height", "machine.size"]),
        (table(((1.2, 0.6), *CORNERS[1:])), ["m0", "[1.2, 0.6]", "±1.1 by ±0.8 m"]),
    ],
)
def test_a_layout_that_cannot_stand_is_refused_with_the_reason(bad: dict[str, Any], parts: list[str]) -> None:
    with pytest.raises(InputError) as refusal:
        parse_scenario(bad)
    for part in parts:
        assert part in str(refusal.value)


def tall(factor: float, **rest: Any) -> dict[str, Any]:
    """The default machine with its CG at this share of the height at which gravity turns it over about x."""
    # Σ k y² = m g h of the rocking, in series with the sway that goes with it: 4 k 0.6² at the feet, no more.
    height = factor * 4 * 1e6 * 0.6**2 / (4000.0 * 9.80665)
    size, own = [2.2, 1.6, 100.0], {"inertia": [2000.0, 3000.0, 4000.0], "cg": [0.0, 0.0, height]}
    return {"machine": {"size": size, **own}, "duration": 0.01, **SOFT, **rest}


def test_a_machine_that_gravity_turns_over_is_refused_where_it_is_run_unless_it_may_fall() -> None:
    stands = parse_scenario(tall(0.999)).plant
    statics.check_standing(stands, gravity=True)
    falling = parse_scenario(tall(1.001))
    with pytest.raises(InputError, match=r"gravity is stronger .* turning about x .*\(-.*N m/rad\).*may_fall = true"):
        simulate(falling)


def test_a_machine_may_fall_where_that_is_wanted() -> None:
    assert simulate(parse_scenario(tall(1.001, may_fall=True))).summary.timing.steps > 0
