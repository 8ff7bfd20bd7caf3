"""The sampled plant against the closed loop, and laws made with python-control on plants, run as they come."""

from typing import Any

import control
import numpy as np
import pytest

import ehamj
from ehamj import Controller, ControllerBank, InputError, Scenario, parse_scenario
from ehamj.linear.loop import Loop
from ehamj.linear.machine import linear_model
from ehamj.linear.response import rigid_floor
from ehamj.linear.sampled import sampled_loop
from ehamj.plant.mounts import MOUNTS

HERTZ = 30.0
FEET = [f"foot_velocity {mount} z" for mount in MOUNTS]
STROKES = [f"stroke {mount}" for mount in MOUNTS]
COMMANDS = [f"valve_command {mount}" for mount in MOUNTS]
GROUND = [f"ground_velocity {mount} z" for mount in MOUNTS]
GEOPHONES = {"inertial": {"kind": "geophone", "noise": 0.0}, "stroke": {"high": 1000.0, "noise": 0.0}}
FLOOR = {"kind": "sine", "amplitude": 5e-7, "frequency": HERTZ}
EXACT: dict[str, Any] = {"duration": 0.5, "record_rate": 2000.0, "ground": FLOOR}
MEASURED: dict[str, Any] = {**EXACT, "sensors": GEOPHONES}
SPEED = 1e-4
"""In whose units [m/s] weights are chosen."""


def poles(matrix: np.ndarray) -> np.ndarray:
    """Eigenvalues, without the delays' chains at zero, which spread by roots of rounding."""
    found = np.linalg.eigvals(matrix)
    return found[np.abs(found) > 0.3]


def assert_same(found: np.ndarray, expected: np.ndarray, tolerance: float) -> None:
    """Equal sets, each within a tolerance of its nearest (equal instruments double them)."""
    assert found.size == expected.size
    apart = np.abs(found[:, None] - expected)
    assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < tolerance


def statespace(law: Controller) -> control.StateSpace:
    return control.ss(law.A, law.B, law.C, law.D, law.period, inputs=list(law.inputs), outputs=COMMANDS)


@pytest.mark.parametrize("delay", [0.0, 5e-5, 1.5e-4])
def test_a_law_around_the_sampled_plant_has_the_poles_of_the_loop(delay: float) -> None:
    scenario = parse_scenario({"sensors": GEOPHONES, "control": {"kind": "combined", "delay": delay}})
    law = scenario.controller()
    assert isinstance(law, Controller)
    plant = ehamj.sampled_plant(scenario)
    assert (plant.dt, plant.input_labels, plant.output_labels) == (1e-4, COMMANDS, list(law.inputs))
    closed = control.feedback(plant, statespace(law), sign=1)
    expected = sampled_loop(linear_model(scenario.plant), Loop.of(scenario, law))
    # Equal instruments at four mounts make eigenvalues that repeat, which rounding splits by its root.
    assert_same(poles(closed.A), poles(expected.A), 1e-6)


def test_a_slower_law_around_a_closed_faster_one_has_the_poles_of_both() -> None:
    table = {"kind": "stroke-servo", "delay": 5e-5}
    scenario = parse_scenario({"sensors": GEOPHONES, "control": table})
    fast = scenario.controller()
    assert isinstance(fast, Controller)
    names = tuple(FEET)
    empty = {"A": 0.9 * np.eye(4), "B": 200.0 * np.eye(4), "C": -np.eye(4), "D": np.zeros((4, 4))}
    settings = {name: getattr(fast, name) for name in ("voltage_limit", "bits", "from_rest")}
    slow = Controller(**empty, inputs=names, period=5e-4, delay=3e-4, **settings)
    plant = ehamj.sampled_plant(scenario, FEET, rate=2000.0, delay=3e-4, closed=True)
    closed = control.feedback(plant, statespace(slow), sign=1)
    both = ControllerBank((fast, slow))
    expected = sampled_loop(linear_model(scenario.plant), Loop.of(scenario, both))
    assert_same(poles(closed.A), poles(expected.A), 1e-6)


def test_disturbances_reach_the_readings_as_they_do_between_samples() -> None:
    scenario = parse_scenario({"sensors": GEOPHONES})
    plant = ehamj.sampled_plant(scenario, STROKES, disturbances=["cg_force z", "ground_displacement rear-left z"])
    free = ehamj.linearise(scenario, STROKES)
    z, s = np.exp(2j * np.pi * 5.0 * plant.dt), 2j * np.pi * 5.0
    for name in plant.input_labels[4:]:
        found = plant[STROKES[2], name](z)
        hold = np.exp(-0.5 * s * plant.dt) if name.startswith("cg") else 1.0  # what is read at once is not held
        reading = scenario.sensors.response((STROKES[2],), 5.0)[0, 0]
        assert found == pytest.approx(reading * hold * free[STROKES[2], name](s), rel=3e-3)


def test_without_a_law_the_standard_clock_and_channels_hold() -> None:
    plant = ehamj.sampled_plant(parse_scenario({}))
    assert (plant.dt, len(plant.output_labels)) == (1e-4, 12)
    assert ehamj.sampled_plant(parse_scenario({}), FEET, rate=2000.0).dt == 5e-4


def two_rates(scenario: Scenario, tmp_path: Any) -> Scenario:
    zeros = {"A": np.zeros((0, 0)), "B": np.zeros((0, 4)), "C": np.zeros((4, 0)), "D": -1e3 * np.eye(4)}
    laws = [Controller(**zeros, inputs=tuple(STROKES), period=period) for period in (1e-4, 5e-4)]
    ControllerBank(tuple(laws)).save(tmp_path / "law.json")
    return scenario.model_copy(
        update={"control": parse_scenario({"control": {"kind": "law", "file": str(tmp_path / "law.json")}}).control}
    )


def test_of_several_rates_one_is_asked_for(tmp_path: Any) -> None:
    scenario = two_rates(parse_scenario({}), tmp_path)
    with pytest.raises(InputError, match=r"rate: .* has several, 10000, 2000 Hz; state the one"):
        ehamj.sampled_plant(scenario)
    assert ehamj.sampled_plant(scenario, rate=2000.0).dt == 5e-4


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"rate": 0.0}, "rate = 0 Hz: must be positive"),
        ({"delay": -1e-4}, "delay = -0.0001 s: must not be negative"),
        ({"disturbances": ["wind"]}, "disturbances: 'wind' is none"),
        ({"closed": True}, "no digital law"),
        ({"outputs": ["stroke left"]}, "'stroke left' is unknown"),
    ],
)
def test_what_cannot_be_is_refused(asked: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        ehamj.sampled_plant(parse_scenario({}), **asked)


# --- laws by python-control, run as they come ----------------------------------------------------------------------


def gains(scenario: Scenario, law: control.StateSpace) -> tuple[complex, complex]:
    """Floor to centre of gravity, vertically at `HERTZ`: as the linear loop has it, and as the run shows it."""
    linear = Loop.of(scenario, Controller.from_statespace(law))
    promised = rigid_floor(linear_model(scenario.plant), [HERTZ], linear, ["cg_displacement z"], ["z"]).response
    data = ehamj.simulate(scenario, controller=law).dataset.sel(axis="z").isel(mount=0)
    data = data.sel(time=slice(0.3, None))
    turn = 2 * np.pi * HERTZ * data.time.values
    basis = np.column_stack([np.cos(turn), np.sin(turn), np.ones(turn.size)])
    shown = [np.linalg.lstsq(basis, data[f"{name}_displacement"].values)[0][:2] @ [1, -1j] for name in ("cg", "ground")]
    return complex(promised[0, 0, 0]), complex(shown[0] / shown[1])


def symmetric(matrix: np.ndarray) -> np.ndarray:
    return 0.5 * (matrix + matrix.T)


def assert_kept(scenario: Scenario, law: control.StateSpace, within: float) -> None:
    """What is promised comes, ten times nearer than it is to what the passive machine does."""
    promised, shown = gains(scenario, law)
    held = rigid_floor(linear_model(scenario.plant), [HERTZ], None, ["cg_displacement z"], ["z"]).response[0, 0, 0]
    assert abs(promised - held) > 10.0 * within * abs(held)
    assert shown == pytest.approx(promised, rel=within)


def test_a_pi_law_on_strokes_does_what_it_promises() -> None:
    single = control.c2d(control.tf([-3e6, -3e8], [1, 0]), 1e-4, "tustin")
    law = control.ss(control.append(*[control.ss(single)] * 4), inputs=STROKES, outputs=COMMANDS)
    assert_kept(parse_scenario({**EXACT, "gravity": 0.0}), law, 1e-3)


def test_an_lqr_with_a_kalman_filter_does_what_it_promises() -> None:
    scenario = parse_scenario(EXACT)
    plant = ehamj.linearise(scenario, FEET)
    valves = plant[FEET, COMMANDS]
    feedback, _, _ = control.lqr(valves, 10.0 * symmetric(plant.C.T @ plant.C) / SPEED**2, np.eye(4))
    moved = plant[FEET, GROUND].B
    noise = 1e-10 * symmetric(moved @ moved.T)
    observer, _, _ = control.lqe(plant.A, np.eye(plant.nstates), plant.C, noise, 1e-14 * np.eye(4))
    inner = plant.A - valves.B @ feedback - observer @ plant.C
    law = control.c2d(control.ss(inner, observer, -feedback, np.zeros((4, 4))), 1e-4, "tustin")
    assert_kept(scenario, control.ss(law, inputs=FEET, outputs=COMMANDS), 2e-3)


def test_an_lqg_for_the_sampled_plant_with_geophones_is_stable_and_does_what_it_promises() -> None:
    scenario = parse_scenario(MEASURED)
    plant = ehamj.sampled_plant(scenario, FEET, disturbances=GROUND)
    n, valves, moved = plant.nstates, plant.B[:, :4], plant.B[:, 4:]
    speeds = np.pad(ehamj.linearise(scenario, FEET).C, ((0, 0), (0, n - 28))) / SPEED
    feedback, _, _ = control.dlqr(plant.A, valves, 10.0 * symmetric(speeds.T @ speeds), np.eye(4))
    noise = symmetric(1e-8 * moved @ moved.T + 1e-6 * valves @ valves.T)
    observer, _, _ = control.dlqe(plant.A, np.eye(n), plant.C / SPEED, noise, 1e-2 * np.eye(4))
    inner = plant.A - valves @ feedback - observer @ plant.C / SPEED
    law = control.ss(inner, observer / SPEED, -feedback, np.zeros((4, 4)), plant.dt, inputs=FEET, outputs=COMMANDS)
    closed = control.feedback(plant[FEET, COMMANDS], law, sign=1)
    assert np.abs(closed.poles()).max() < 1.0
    assert_kept(scenario, law, 2e-3)
