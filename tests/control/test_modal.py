"""Modal control: what its geometry moves, its balance of pressures, its damping of sway, its structure."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from ehamj.control import Controller
from ehamj.control.architectures.modal import ModalSettings
from ehamj.control.channels import MountChannels
from ehamj.errors import InputError
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.modes import modes
from ehamj.plant.levers import MOTIONS
from ehamj.plant.mounts import MOUNTS
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import Scenario

WARP = (1.0, -1.0, -1.0, 1.0)

Array = NDArray[np.float64]

FEET, STROKES, GROUND, _, _, PRESSURES = MountChannels.of(parse_scenario({}).plant)
UNEVEN = ((1.05, 0.5), (0.7, -0.75), (-0.6, 0.7), (-1.0, -0.4))
SENSORS = {"ground": {"kind": "geophone"}, "inertial": {"kind": "geophone"}}
WITHOUT = {
    **{motion: {"crossing": 0.0} for motion in MOTIONS},
    "warp": {"crossing": 0.0},
    "sway_x": {"gain": 0.0, "centre": 70.0},
    "sway_y": {"gain": 0.0, "centre": 70.0},
}


def machine(**table: Any) -> Scenario:
    return parse_scenario({"plates": "tied", **table})


def uneven() -> Scenario:
    mounts = [{"name": name, "position": list(at)} for name, at in zip(MOUNTS, UNEVEN, strict=True)]
    return machine(mount=mounts)


def law_of(scenario: Scenario, **parts: Any) -> Controller:
    """Modal control of which only ``parts`` are on."""
    settings = ModalSettings.model_validate({"kind": "modal", "delay": 1.5e-4, **WITHOUT, **parts})
    return settings.controller(scenario.plant, scenario.sensors)


def gains(law: Controller, hertz: float, inputs: tuple[str, ...]) -> NDArray[np.complex128]:
    """Commands over some inputs, (4, inputs)."""
    return law.response(hertz)[0][:, [law.inputs.index(name) for name in inputs]]


def warp(scenario: Scenario) -> Array:
    """The one pattern of forces that moves nothing, (4,)."""
    return scenario.plant.layout.stresses[:, 0]


LOOP = {"crossing": 40.0, "integral": 0.0}

# --- geometry -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("place", [machine, uneven], ids=["even", "uneven"])
@pytest.mark.parametrize("motion", MOTIONS)
def test_a_loop_sees_its_own_motion_and_moves_only_that(motion: str, place: Any) -> None:
    scenario = place()
    x, y, _ = np.array(scenario.plant.positions).T
    shapes = {"heave": np.ones(4), "roll": y, "pitch": -x}  # heights of the mounts, z + y rx − x ry
    found = gains(law_of(scenario, **{motion: LOOP}), 20.0, FEET)
    size = np.abs(found @ shapes[motion]).max()
    assert size > 0
    for other, shape in shapes.items():
        if other != motion:
            assert np.abs(found @ shape).max() < 1e-9 * size
    commands = found @ shapes[motion]
    # The commands move the pistons in the shape of the motion, all with one phase.
    np.testing.assert_allclose(commands, commands[0] / shapes[motion][0] * shapes[motion], rtol=1e-9)


@pytest.mark.parametrize("motion", MOTIONS)
def test_a_loop_acts_against_the_motion(motion: str) -> None:
    scenario = uneven()
    x, y, _ = np.array(scenario.plant.positions).T
    shape = {"heave": np.ones(4), "roll": y, "pitch": -x}[motion]
    # Below the lags of delay and instruments a velocity v must be answered by a stroke velocity of −f_c/(j f) v.
    command = gains(law_of(scenario, **{motion: LOOP}), 8.0, FEET) @ shape
    across = (command / shape)[0] * 1j
    assert across.real < 0
    assert abs(np.degrees(np.angle(-across))) < 50.0  # creep taken back turns by atan(7/8) = 41°


def test_the_plane_is_the_strokes_of_heave_roll_and_pitch() -> None:
    for row, (x, y) in zip(uneven().plant.central.spread, UNEVEN, strict=True):
        assert row.tolist() == [1.0, y, -x]


def test_all_three_instruments_are_read_through_the_same_geometry() -> None:
    law = law_of(uneven(), heave=LOOP)
    for group in (FEET, STROKES, GROUND):
        found = gains(law, 0.3, group)
        np.testing.assert_allclose(found, found[:1].mean() * np.ones((4, 1)) * weights(found), rtol=1e-9)


def weights(found: NDArray[np.complex128]) -> Array:
    """Shares of the mounts in what a rank-one gain measures, of mean one."""
    return (found[0] / found[0].mean()).real


# --- warp ---------------------------------------------------------------------------------------------------------


def test_on_a_rectangle_warp_is_plus_minus_minus_plus() -> None:
    np.testing.assert_allclose(warp(machine()), WARP, rtol=1e-12)


def test_pressures_in_warp_exert_neither_force_nor_moment() -> None:
    pattern = warp(uneven())
    x, y = np.array(UNEVEN).T
    assert np.abs([pattern.sum(), pattern @ x, pattern @ y]).max() < 1e-14
    assert pattern @ pattern == pytest.approx(4.0)


@pytest.mark.parametrize("place", [machine, uneven], ids=["even", "uneven"])
def test_the_balance_sees_only_warp_and_moves_nothing(place: Any) -> None:
    scenario = place()
    law = law_of(scenario, warp={"crossing": 20.0})
    assert law.inputs == PRESSURES
    assert law.states == 0
    drive = law.D @ warp(scenario)
    assert np.all(drive * warp(scenario) < 0)
    x, y, _ = np.array(scenario.plant.positions).T
    for motion in (np.ones(4), x, y):
        assert np.abs(law.D @ motion).max() < 1e-12 * np.abs(drive).max()
        assert abs(motion @ drive) < 1e-12 * np.abs(drive).max()


def test_the_balance_takes_warp_back_with_its_crossing(model: LinearModel) -> None:
    scenario = machine()
    law = law_of(scenario, warp={"crossing": 20.0})
    # The valve pushes P_L by 4β/V_t·K_Q K_v of the command; about rest leakage adds 8 % at 20 Hz.
    hertz = 20.0
    answer = model.response(hertz, PRESSURES, [f"valve_command {mount}" for mount in MOUNTS])[0]
    gain = (np.array(WARP) @ (law.D @ answer) @ np.array(WARP)) / 4
    oil = 4 * 1.4e9 / 5.39e-4
    leak = oil * 6.6e-11
    valve = 1 / (1 + 2 * 0.65j * 20 / 250.03 - (20 / 250.03) ** 2)
    expected = -2 * np.pi * 20.0 / (2j * np.pi * hertz + leak) * valve
    assert complex(gain) == pytest.approx(complex(expected), rel=0.01)


# --- nothing, and structure ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def model() -> LinearModel:
    return linear_model(machine().plant)


def test_with_everything_off_the_valves_get_nothing() -> None:
    law = law_of(machine())
    assert law.inputs == ()
    assert law.states == 0
    assert not np.any(law.D)


def test_what_the_valves_did_not_get_is_never_answered_at_once() -> None:
    scenario = machine(sensors=SENSORS)
    law = ModalSettings(delay=1.5e-4).controller(scenario.plant, scenario.sensors)
    assert law.anti_windup is not None
    # Only what was lost before a sample may change its command: the loss path has no direct term, so that the first
    # answer comes through the states.
    assert np.any(law.anti_windup)
    assert np.any(law.C @ law.A @ law.anti_windup)


def test_a_law_that_is_not_limited_is_the_same_with_and_without_recovery() -> None:
    one, other = (law_of(machine(), heave=LOOP, recovery=r) for r in (0.05, 0.5))
    np.testing.assert_allclose(gains(one, 12.0, FEET), gains(other, 12.0, FEET), rtol=1e-9)


def test_a_loop_that_would_swing_up_while_it_is_limited_is_refused() -> None:
    with pytest.raises(InputError, match=r"control\.recovery = 0\.15 s: too slow for loops that cross so low"):
        law_of(machine(), heave={"crossing": 2.0, "integral": 12.0})
    law_of(machine(), heave={"crossing": 2.0, "integral": 12.0}, recovery=0.024)


# --- sway ---------------------------------------------------------------------------------------------------------


def test_sway_is_damped_threefold_by_tilting_alone() -> None:
    scenario = load_scenario("vc-c-floor", ["control={kind='combined', delay=1.5e-4}"])
    model, law = linear_model(scenario.plant), scenario.controller()
    held = {mode.name: mode.damping_ratio for mode in modes(model)}
    closed = modes(model, Loop.of(scenario, law))
    for plane_ in ("x", "y"):
        name = f"sway-rocking about {plane_}"
        # Beside each sway stands the filter's own mode; yaw, which no vertical actuator reaches, is left out.
        near = [m.damping_ratio for m in closed if 50.0 < m.frequency < 100.0 and m.name != "yaw"]
        assert next(m.damping_ratio for m in closed if m.name == name) > 3.0 * held[name]
        assert min(near) > 3.0 * min(held["sway-rocking about x"], held["sway-rocking about y"])
