"""Many designs at once: against closed forms, an independent model, the differentiated simulator, and one by one."""

from typing import Any

import numpy as np
import pytest
import xarray as xr
from harness import SKEW_MOUNTS
from oracles import linear

from ehamj.designs.designs import Designs
from ehamj.designs.floor import floor_response
from ehamj.designs.many import RIGID_MODES, modes_of
from ehamj.designs.parameters import value_of, with_value
from ehamj.errors import InputError
from ehamj.isolator.actuator import Actuator
from ehamj.linear.machine import linear_model
from ehamj.linear.modes import modes
from ehamj.linear.response import ground_response
from ehamj.linear.values import ACTUATOR_VALUES
from ehamj.plant.axes import DOFS
from ehamj.plant.mounts import DEFAULT_MOUNTS, MOUNTS
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.settings import PROVENANCE

UNEVEN: dict[str, Any] = {
    "machine": {"cg": [0.15, -0.1, 0.9], "inertia": [2500.0, 3600.0, 4100.0]},
    "mount": [m.model_dump() | {"actuator": "weak" if m.name == "rear-left" else "isolator"} for m in DEFAULT_MOUNTS],
    "actuators": {"isolator": {}, "weak": {"membrane_stiffness": 3e8, "lateral_stiffness": 1e8, "plate_mass": 30.0}},
}

SLANTED: dict[str, Any] = {
    "machine": {"cg": [0.25, -0.2, 1.5]},
    "actuators": {"isolator": {"membrane_stiffness": 2e6}},
}

SKEW: dict[str, Any] = {
    "machine": {"mass": 2000.0, "cg": [0.1, -0.05, 0.7]},
    "mount": SKEW_MOUNTS,
}

SOFT_AND_SKEW = SKEW | {"actuators": {"isolator": {"membrane_stiffness": 4e6, "lateral_stiffness": 2e6}}}
"""Stands tilted by half a mrad."""


def one(table: dict[str, Any] | None = None, **isolator: Any) -> Designs:
    table = dict(table or {})
    if isolator:
        table["actuators"] = {"isolator": isolator}
    return Designs.of(parse_scenario(table), {})


def mode(table: xr.Dataset, name: str) -> tuple[float, float]:
    picked = table.sel(mode=name)
    return float(picked.frequency), float(picked.damping_ratio)


# --- the same as the simulator's own linear model ------------------------------------------------------------------

OILY = {"air_fraction": 0.01, "wall_modulus": 2e9, "area_ratio": 0.8, "volume_share": 0.4}
CURVED = {"flow_curve": [[0.0, 0.0], [0.5, 0.3], [1.0, 1.0]], "rated_flow": 5e-5, "edge_leakage_share": 0.5}
FLEXIBLE = {"foot_stiffness": 1e10, "foot_damping": 1e4}

SPRING = 1571.0 * complex(-0.65, np.sqrt(1 - 0.65**2))
"""Pole of a spool of the default valve [1/s]; each valve adds it and its conjugate to those of motion and oil."""

MACHINES = pytest.mark.parametrize(
    "table",
    [
        {},
        {"actuators": {"isolator": OILY}},
        {"actuators": {"isolator": CURVED}},
        {"actuators": {"isolator": FLEXIBLE}},
        UNEVEN,
        # Stands tilted by 2 mrad, 5 mm down at a corner.
        SLANTED,
        SKEW,
        SOFT_AND_SKEW,
        SKEW | {"actuators": {"isolator": FLEXIBLE}},
    ],
    ids=["default", "oil", "valve", "flexible feet", "uneven", "slanted", "skew", "soft and skew", "skew and flexible"],
)


def all_poles(designs: Designs) -> Any:
    """Magnitudes of the poles of motion, oil and valves, in order [1/s]."""
    return np.sort(np.abs([*modes_of(designs).pole.values, *[SPRING, SPRING.conjugate()] * len(designs.mounts)]))


@MACHINES
def test_poles_are_those_of_the_differentiated_model(table: dict[str, Any]) -> None:
    expected = np.sort(np.abs(np.linalg.eigvals(linear_model(parse_scenario(table).plant).A)))
    # Differences are good to 1e-9 of each row. Where a machine leans, tied plates keep the levers that they have when
    # it is level: 2 mrad of 14 of 1000 kg, and less of each pole.
    np.testing.assert_allclose(all_poles(one(table)), expected, rtol=1e-7 if table is SLANTED else 1e-8, atol=1e-9)


@MACHINES
def test_what_each_mount_does_along_each_axis_is_that_of_the_differentiated_model(table: dict[str, Any]) -> None:
    scenario, hertz = parse_scenario(table), np.array([3.0, 75.0, 400.0])
    mounts = len(scenario.mount)
    outputs = [*(f"cg_displacement {axis}" for axis in "xyz"), *(f"machine_displacement r{axis}" for axis in "xyz")]
    expected = ground_response(linear_model(scenario.plant), hertz, outputs)
    for k in range(expected.shape[2]):
        alone = np.zeros((3, 3 * mounts), complex)
        alone[:, k] = 1.0
        found = floor_response(Designs.of(scenario, {}), hertz, alone.reshape(3, mounts, 3))
        # Differences are good to 1e-9 of each row; outputs have one unit each. Of plates that lean see above.
        size = np.abs(expected).max(axis=(0, 2))
        assert np.all(np.abs(found - expected[:, :, k]) <= (1e-6 if table is SLANTED else 1e-9) * size)


# --- the default machine and closed forms -------------------------------------------------------------------------


def test_modes_of_the_default_machine() -> None:
    published = {
        "lower about x": (70.03, 0.042), "lower about y": (70.66, 0.031), "yaw": (76.99, 0.024),
        "heave": (528.0, 0.098), "upper about x": (455.2, 0.114), "upper about y": (552.1, 0.094),
    }  # fmt: skip
    table = modes_of(one())
    assert tuple(table.mode.values) == RIGID_MODES
    for name, (frequency, damping) in published.items():
        found = mode(table, name)
        assert found[0] == pytest.approx(frequency, rel=1e-3)
        assert round(found[1], 3) == damping


@pytest.mark.parametrize("damping", [0.0, 3900.0, 2e5])
def test_a_mass_on_springs(damping: float) -> None:
    table = modes_of(one(membrane_damping=damping), hydraulics=False)
    # Heave alone: 4 K_L, 4 C, and the plates' mass with the machine's.
    omega = np.sqrt(4 * 6.8e8 / 4056.0)
    found = mode(table, "heave")
    assert found[0] == pytest.approx(omega / (2 * np.pi), rel=1e-9)
    assert found[1] == pytest.approx(4 * damping / (2 * 4056.0 * omega), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(("height", "stiffness", "gravity"), [(0.75, 6.8e8, 0.0), (1.4, 5e7, 9.80665), (3.0, 2e5, 9.8)])
def test_sway_and_rocking_solve_a_quadratic(height: float, stiffness: float, gravity: float) -> None:
    scenario = parse_scenario({"gravity": gravity})
    free = {"membrane_damping": 0.0, "lateral_damping": 0.0, "membrane_stiffness": stiffness}
    vary = {f"actuators.isolator.{name}": value for name, value in free.items()} | {"machine.cg.2": height}
    table = modes_of(Designs.of(scenario, vary), hydraulics=False)
    for about, inertia, arm in (("x", 2000.0, 0.6), ("y", 3000.0, 0.9)):
        m = 4000.0
        rocking = inertia + m * height**2 + 4 * 14.0 * arm**2
        stands = 4 * stiffness * arm**2 - m * gravity * height
        # det([[4k − m ω², ∓m h ω²], [∓m h ω², K_θ − J ω²]]) = 0
        squares = np.roots([m * rocking - (m * height) ** 2, -(m * stands + 4 * 2e8 * rocking), 4 * 2e8 * stands])
        expected = np.sqrt(np.sort(squares)) / (2 * np.pi)
        found = [mode(table, f"{which} about {about}")[0] for which in ("lower", "upper")]
        np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_yaw_is_a_spring_and_a_damper_at_the_mounts_distance() -> None:
    r2 = 4 * (0.9**2 + 0.6**2)
    frequency, damping = mode(modes_of(one()), "yaw")
    assert frequency == pytest.approx(np.sqrt(2e8 * r2 / 4000) / (2 * np.pi), rel=1e-9)
    assert damping == pytest.approx(2e4 * r2 / 2 / np.sqrt(2e8 * r2 * 4000), rel=1e-9)


def test_every_pole_is_the_oracles() -> None:
    # Without gravity: the oracle's chambers stand at stroke 0.
    machine = linear.LinearMachine(
        cg=(0.15, -0.1, 0.9), gravity=0.0, k_lat=(2e8, 1e8, 2e8, 3e8), A_p=(0.03, 0.02, 0.03, 0.03)
    )
    names = [f"a{k}" for k in range(4)]
    table = {
        "gravity": 0.0,
        "machine": {"cg": [0.15, -0.1, 0.9]},
        "mount": [m.model_dump() | {"actuator": name} for m, name in zip(DEFAULT_MOUNTS, names, strict=True)],
        "actuators": {
            name: {"lateral_stiffness": k, "piston_area": area}
            for name, k, area in zip(names, (2e8, 1e8, 2e8, 3e8), (0.03, 0.02, 0.03, 0.03), strict=True)
        },
    }
    np.testing.assert_allclose(all_poles(one(table)), np.sort(np.abs(linear.passive_modes(machine))), rtol=1e-9)


# --- tipping ------------------------------------------------------------------------------------------------------


def test_the_tipping_margin_is_what_gravity_leaves_of_the_rocking_stiffness() -> None:
    heights = np.array([0.5, 2.0, 5.0])
    soft = parse_scenario({"actuators": {"isolator": {"membrane_stiffness": 1e5}}})
    table = modes_of(Designs.of(soft, {"machine.cg.2": heights}), hydraulics=False)
    # The narrower way: 4 K_L b².
    expected = 1 - 4000 * 9.80665 * heights / (4 * 1e5 * 0.6**2)
    np.testing.assert_allclose(table.tipping_margin, expected, rtol=1e-10)
    np.testing.assert_array_equal(table.stands, expected > 0)


@pytest.mark.parametrize("hydraulics", [True, False])
def test_what_tips_grows_and_has_one_mode_less(hydraulics: bool) -> None:
    soft = parse_scenario({"actuators": {"isolator": {"membrane_stiffness": 2e5, "moving_volume": False}}})
    boundary = 4 * 2e5 * 0.6**2 / (4000 * 9.80665)
    table = modes_of(Designs.of(soft, {"machine.cg.2": boundary * np.array([0.99, 1.01])}), hydraulics)
    assert list(table.growth_rate.values > 0) == [False, True]
    assert np.isnan(table.frequency.sel(mode="lower about x").values[1])
    assert np.isfinite(table.frequency.sel(mode="upper about x")).all()


def test_a_machine_that_empties_its_cylinders_has_no_modes() -> None:
    soft = parse_scenario({"actuators": {"isolator": {"membrane_stiffness": 1e6}}})
    table = modes_of(Designs.of(soft, {"machine.mass": np.array([1000.0, 5e4])}))
    assert list(table.stands.values) == [True, False]
    assert np.isnan(table.frequency.values[1]).all()


# --- maps ---------------------------------------------------------------------------------------------------------


def test_a_map_is_its_designs_one_by_one() -> None:
    base = parse_scenario(UNEVEN)
    height, stiff = np.array([0.4, 0.8, 1.6]), np.array([1e8, 6.8e8])
    many = modes_of(Designs.of(base, {"machine.cg.2": height, "actuators.isolator.membrane_stiffness": stiff}))
    for k in range(3):
        for j in range(2):
            table = {**UNEVEN, "machine": UNEVEN["machine"] | {"cg": [0.15, -0.1, height[k]]}}
            table["actuators"] = UNEVEN["actuators"] | {"isolator": {"membrane_stiffness": stiff[j]}}
            single, cell = (
                modes_of(one(table)),
                many.isel({"machine.cg.2": k, "actuators.isolator.membrane_stiffness": j}),
            )
            # Rounding of eigenvalues; and of mode shapes, magnified by neighbours 1 % apart.
            np.testing.assert_allclose(cell.frequency, single.frequency, rtol=1e-11)
            np.testing.assert_allclose(cell["shape"], single["shape"], rtol=0, atol=1e-9)
            np.testing.assert_allclose(cell.rest_stroke, single.rest_stroke, rtol=1e-11)


def test_keys_vary_together_along_a_named_dimension() -> None:
    spans = xr.DataArray([1.2, 1.8], dims="span")
    many = modes_of(Designs.of(parse_scenario({}), {"footprint.x": spans, "footprint.y": 0.5 * spans}))
    assert dict(many.frequency.sizes) == {"span": 2, "mode": 6}
    assert many["span"].attrs["units"] == many["footprint.y"].attrs["units"] == "m"
    moved = [m.model_dump() | {"position": [x / 1.5, y / 2]} for m in DEFAULT_MOUNTS for x, y in [m.position]]
    np.testing.assert_allclose(many.frequency[0], modes_of(one({"mount": moved})).frequency, rtol=1e-11)


def test_a_mount_may_vary_off_the_plane() -> None:
    base = parse_scenario(SOFT_AND_SKEW)
    many = modes_of(Designs.of(base, {"mount.3.position.2": np.array([0.0, 0.2, 0.6]), "footprint.x": 1.6}))
    for k, z in enumerate((0.0, 0.2, 0.6)):
        moved = with_value(with_value(base, "mount.3.position.2", z), "footprint.x", 1.6)
        assert moved.mount[3].place[2] == z
        assert value_of(moved, "footprint.x") == pytest.approx(1.6, rel=1e-12)
        np.testing.assert_allclose(many.frequency[k], modes_of(Designs.of(moved, {})).frequency, rtol=1e-11)


def test_what_stays_where_it_is_put_is_no_oscillation() -> None:
    """Without leakage or membranes poles are zero, as a number or as a pair that is not quite; heave is one of oil."""
    scenario = load_scenario("benchmark")
    found = modes_of(Designs.of(scenario, {"machine.mass": [3600.0, 4000.0, 4400.0]})).frequency.sel(mode="heave")
    for mass, frequency in zip(found["machine.mass"].values, found.values, strict=True):
        one = modes(linear_model(with_value(scenario, "machine.mass", mass).plant))
        assert frequency == pytest.approx(next(mode.frequency for mode in one if mode.name == "heave"), rel=1e-7)


def test_the_slower_mode_of_a_plane_is_the_lower() -> None:
    grid = {"machine.cg.2": np.linspace(0.1, 3.0, 6), "actuators.isolator.lateral_stiffness": np.geomspace(1e6, 3e9, 6)}
    table = modes_of(Designs.of(parse_scenario({}), grid))
    for about in "xy":
        assert (
            table.frequency.sel(mode=f"lower about {about}") < table.frequency.sel(mode=f"upper about {about}")
        ).all()


# --- floor responses ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dof", DOFS)
def test_the_response_to_a_slab_is_the_oracles(dof: str) -> None:
    hertz = [3.0, 70.0, 300.0]
    machine = linear.LinearMachine(gravity=0.0)
    found = floor_response(one({"gravity": 0.0}), hertz, dof, {"origin": (0.0, 0.0, 0.0)})
    for f in hertz:
        expected = linear.transmissibility(machine, dof, f)
        origin = found.sel(frequency=f, output=["origin x", "origin y", "origin z", "rx", "ry", "rz"])
        np.testing.assert_allclose(origin, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_the_response_to_a_wave_is_that_of_the_differentiated_model() -> None:
    scenario = parse_scenario({"actuators": {"isolator": OILY}})
    hertz = np.array([20.0, 75.0, 400.0])
    x = np.array([m.position[0] for m in DEFAULT_MOUNTS])
    wave = np.zeros((3, 4, 3), complex)
    wave[:, :, 2] = np.exp(-2j * np.pi * hertz[:, None] * x / 200.0)
    wave[:, 1, 0] = 0.3j
    found = floor_response(Designs.of(scenario, {}), hertz, wave)
    outputs = [*(f"cg_displacement {axis}" for axis in "xyz"), *(f"machine_displacement r{axis}" for axis in "xyz")]
    transfer = ground_response(linear_model(scenario.plant), hertz, outputs)
    expected = np.einsum("fog,fg->fo", transfer, wave.reshape(3, -1))
    # The differentiated model's rounding.
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7 * np.abs(expected).max())


def test_a_floor_that_only_rolls_moves_one_plane_only() -> None:
    rolls = np.abs(floor_response(one(), [10.0, 70.0, 455.0], "rx"))
    for output in ("cg x", "cg z", "ry", "rz"):
        assert float(rolls.sel(output=output).max()) <= 1e-13
    heave = np.abs(floor_response(one(), [10.0, 528.0], "z"))
    assert float(heave.drop_sel(output="cg z").max()) <= 1e-13


def test_responses_over_designs_are_those_one_by_one() -> None:
    heights = np.array([0.5, 1.5])
    many = floor_response(Designs.of(parse_scenario({}), {"machine.cg.2": heights}), [5.0, 60.0], "x")
    single = floor_response(one({"machine": {"cg": [0.0, 0.0, 1.5]}}), [5.0, 60.0], "x")
    np.testing.assert_allclose(many[1], single, rtol=1e-11, atol=1e-15)


# --- bad input ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ({"machine.height": 1.0}, "'machine.height' must be gravity"),
        ({"actuators.other.piston_area": 1.0}, "actuators.(isolator)"),
        ({"machine.mass": [4000.0, 0.0]}, "machine.mass = 0: must be above 0"),
        ({"actuators.isolator.edge_leakage_share": 1.5}, "must be at least 0 and at most 1"),
        ({"footprint.x": -1.0}, "footprint.x = -1: must be above 0"),
        ({"machine.cg.2": np.nan}, "machine.cg.2 = nan: must be finite"),
        ({"machine.cg.2": np.ones((2, 2))}, "xarray.DataArray"),
    ],
)
def test_impossible_values_are_refused(vary: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        Designs.of(parse_scenario({}), vary)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    "table", [{"supply": {"dynamic": True}}, {"actuators": {"isolator": {"overlap": [0.1, 0.1, 0.1, 0.1]}}}]
)
def test_what_has_no_closed_form_is_refused(table: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="here"):
        one(table)


def test_every_option_is_known_or_refused() -> None:
    """A new option of the isolator is refused until its closed form is there; these have none."""
    known = {
        *ACTUATOR_VALUES,
        "moving_volume",
        "flow_curve",
        "spool_drive_limit",
        "end_stops",
        "voltage_limit",
        "passive",
    }
    changed = {"overlap": (0.1,) * 4, "null_offset": 0.1, "hysteresis": 0.1, "threshold": 0.1}
    changed |= {"outside_leakage_1": 1e-12, "outside_leakage_2": 1e-12, "check_valve": True, "spool_stuck": True}
    changed |= {"spool_stuck_at": 0.1, "null_drift_from": 1.0, "null_drift_limit": 0.1}
    assert set(Actuator.model_fields) - known == {*changed, "null_drift", *PROVENANCE}
    with pytest.raises(InputError, match=r"actuators\.isolator\.null_drift = .*: must be .* here"):
        one(null_drift=0.1, null_drift_limit=0.1)
    for name, value in changed.items():
        with pytest.raises(InputError, match=rf"actuators\.isolator\.{name} = .*: must be .* here"):
            one(**{name: value})


def test_a_floor_must_be_a_direction_or_motions_of_the_mounts() -> None:
    with pytest.raises(InputError, match="must be one of x, y, z"):
        floor_response(one(), [1.0], "heave")
    with pytest.raises(InputError, match="must end in"):
        floor_response(one(), [1.0], np.ones((3, 4)))


def test_mounts_keep_their_names() -> None:
    assert list(modes_of(one()).mount.values) == list(MOUNTS)
