"""Machine, sensors and law from sample to sample: against continuous responses and against other forms of the same."""

from typing import Any

import control
import numpy as np
import pytest

from ehamj.control import Controller, ControllerBank
from ehamj.control.sensors import IDEAL, Sensors
from ehamj.linear.loop import Loop
from ehamj.linear.machine import LinearModel, linear_model
from ehamj.linear.modes import modes
from ehamj.linear.response import rigid_floor
from ehamj.linear.sampled import sampled_loop, sampled_machine
from ehamj.plant.mounts import MOUNTS
from ehamj.run.simulate import simulate
from ehamj.scenario.load import parse_scenario

SENSORS: dict[str, Any] = {"inertial": {"kind": "geophone"}, "stroke": {"high": 1000.0}}
STROKES = tuple(f"stroke {mount}" for mount in MOUNTS)
DELAYS = (0.0, 3e-5, 1e-4, 1.5e-4, 2.5e-4)


@pytest.fixture(scope="module")
def model() -> LinearModel:
    return linear_model(parse_scenario({}).plant)


@pytest.fixture(scope="module")
def sensors() -> Sensors:
    return parse_scenario({"sensors": SENSORS}).sensors


def random_law(period: float = 1e-4, delay: float | None = None, seed: int = 0, gain: float = 1.0) -> Controller:
    draw = np.random.default_rng(seed).uniform
    A = draw(-1.0, 1.0, (3, 3))
    A *= 0.9 / np.abs(np.linalg.eigvals(A)).max()
    inputs = ("foot_velocity front-left z", *STROKES)
    scale = gain * np.array([300.0, 2e4, 2e4, 2e4, 2e4])
    B, C, D = draw(-1, 1, (3, 5)) * scale, draw(-0.3, 0.3, (4, 3)), draw(-0.3, 0.3, (4, 5)) * scale
    return Controller(A, B, C, D, inputs, period, delay)


@pytest.mark.parametrize("delay", DELAYS)
def test_the_sampled_machine_is_the_continuous_one_held_delayed_and_read(
    model: LinearModel, sensors: Sensors, delay: float
) -> None:
    law = random_law(delay=delay)
    found = sampled_machine(model, Loop(law, sensors, 0))
    assert (found.dt, found.output_labels) == (1e-4, list(law.inputs))
    for hertz in (2.0, 20.0, 100.0, 400.0):
        s = 2j * np.pi * hertz
        plant = model.response(hertz, law.inputs, model.inputs[:4])[0]
        read = sensors.response(law.inputs, hertz)[0][:, None] * plant
        held = read * np.exp(-s * (delay + 0.5e-4)) * np.sinc(hertz * 1e-4)
        # What is left are images about 10 kHz: strokes fall with the cube of frequency or faster beyond the valve.
        np.testing.assert_allclose(found(np.exp(s * 1e-4)), held, rtol=0, atol=3e-4 * np.abs(held).max())


@pytest.mark.parametrize("delay", DELAYS)
def test_the_closed_loop_is_the_feedback_of_law_and_sampled_machine(
    model: LinearModel, sensors: Sensors, delay: float
) -> None:
    law = random_law(delay=delay)
    plant = sampled_machine(model, Loop(law, sensors, 0))
    loop = control.feedback(plant, control.ss(law.A, law.B, law.C, law.D, law.period), sign=1)
    expected, found = np.linalg.eigvals(loop.A), np.linalg.eigvals(sampled_loop(model, Loop(law, sensors, 0)).A)
    assert found.size == expected.size
    slow = np.abs(expected) > 0.2  # a chain of delays at zero spreads by roots of rounding
    for value in expected[slow]:
        # Pairs of equal sensors have double eigenvalues, which rounding splits by its root.
        assert np.abs(found - value).min() < 1e-6


def test_modes_of_a_bank_of_one_rate_are_those_of_the_one_law(model: LinearModel, sensors: Sensors) -> None:
    one, other = random_law(), random_law(seed=1)
    single = modes(model, Loop(ControllerBank.combine((one, other)), sensors, 0))  # type: ignore[arg-type]
    bank = modes(model, Loop(ControllerBank((one, other)), sensors, 0))
    assert [mode.name for mode in bank] == [mode.name for mode in single]
    np.testing.assert_allclose([mode.frequency for mode in bank], [mode.frequency for mode in single], rtol=1e-6)


@pytest.mark.parametrize("faster", [2, 5])
def test_a_faster_law_that_does_nothing_leaves_the_modes_of_a_slow_one(model: LinearModel, faster: int) -> None:
    # Within a pattern of several samples, frequencies above half its rate must be found by following them.
    slow = random_law(period=2e-4, delay=2e-4)
    idle = random_law(period=2e-4 / faster, delay=0.0, gain=0.0)
    longer = Controller(idle.A, idle.B, idle.C, idle.D, idle.inputs, period=4e-4 * 5, delay=1e-4)
    alone = [mode for mode in modes(model, Loop(slow, IDEAL, 0)) if mode.name != "controller"]
    found = [
        mode for mode in modes(model, Loop(ControllerBank((slow, idle, longer)), IDEAL, 0)) if mode.name != "controller"
    ]
    assert [mode.name for mode in found] == [mode.name for mode in alone]
    for one, other in zip(found, alone, strict=True):
        assert one.frequency == pytest.approx(other.frequency, rel=1e-6)
        assert one.damping_ratio == pytest.approx(other.damping_ratio, rel=1e-5, abs=1e-8)


def test_strokes_under_two_rates_and_sensors_creep_as_the_sampled_loop_says(sensors: Sensors) -> None:
    table = {"plates": "tied", "gravity": 0.0, "sensors": {"stroke": {"high": 1000.0, "noise": 0.0}}}
    no_states = {"A": np.zeros((0, 0)), "B": np.zeros((0, 4)), "C": np.zeros((4, 0)), "inputs": STROKES, "bits": None}
    fast = Controller(D=-2e5 * np.eye(4), period=1e-4, **no_states)
    slow = Controller(D=-4e5 * np.eye(4), period=5e-4, delay=1e-4, **no_states)
    bank = ControllerBank((fast, slow))
    floor = {"kind": "shock", "dof": "z", "velocity": 1e-5, "pulse_time": 0.01, "begin": 0.0, "return_time": 0.01}
    case = parse_scenario({**table, "duration": 0.08, "ground": floor, "record_rate": 2000.0})
    loop = sampled_loop(linear_model(case.plant), Loop.of(case, bank))
    values = np.linalg.eigvals(loop.A).astype(complex)
    exponents = np.log(values[np.abs(values) > 1e-3]) / loop.period
    creep = exponents.real[(np.abs(exponents.imag) < 1e-6) & (np.abs(exponents.real + 125.0) < 50.0)]
    assert creep.size == 3  # of heave, roll and pitch, within 1.5 %; 42 1/s without the servos
    run = simulate(case, controller=bank).dataset
    late = run.time.values > 0.04
    slope = np.polyfit(run.time.values[late], np.log(np.abs(run["stroke"].mean("mount").values[late])), 1)[0]
    assert creep.min() * 1.002 < slope < creep.max() * 0.998


@pytest.mark.parametrize("rates", [(1e-4,), (1e-4, 5e-4)], ids=["one rate", "two rates"])
def test_a_floor_under_tilted_sensors_is_answered_as_predicted(rates: tuple[float, ...]) -> None:
    # Feedforward of a tilted geophone and stroke feedback against the nonlinear run, at three lines.
    lines = [10.0, 30.0, 60.0]
    table = {"ground": {"kind": "geophone", "noise": 0.0, "low": 0.5, "misalignment": 10.0}, "stroke": {"noise": 0.0}}
    floor = {"kind": "multisine", "dof": "x", "frequencies": lines, "velocities": [2e-6], "fade_in": 0.2}
    case = parse_scenario(
        {"plates": "tied", "gravity": 0.0, "duration": 3.0, "seed": 2, "sensors": table, "record_rate": 1000.0}
        | {"ground": floor}
    )
    names = tuple(f"ground_velocity {mount} z" for mount in MOUNTS)
    nothing = {"A": np.zeros((0, 0)), "B": np.zeros((0, 4)), "C": np.zeros((4, 0)), "bits": None}
    laws = [
        Controller(D=-5e3 * np.eye(4), inputs=names, period=rates[0], **nothing),
        Controller(D=-1e5 * np.eye(4), inputs=STROKES, period=rates[-1], delay=1e-4, **nothing),
    ]
    law = ControllerBank.combine(laws)
    run = simulate(case, controller=law).dataset
    late = slice(-2000, None)  # two seconds: whole periods of every line
    outputs = ("cg_displacement z", "machine_displacement rx")
    motions = [
        run["cg_displacement"].sel(axis="z").values[late],
        run["machine_displacement"].sel(dof="rx").values[late],
    ]
    ground = run["ground_displacement"].values[late, 0, 0]  # only tilted sensors see it
    times = run.time.values[late]
    found = rigid_floor(linear_model(case.plant), lines, Loop.of(case, law), outputs, ("x",)).response[:, :, 0]
    scale = np.abs(found).max(axis=0)
    for k, hertz in enumerate(lines):
        turn = np.exp(-2j * np.pi * hertz * times)
        measured = np.array([motion @ turn for motion in motions]) / (ground @ turn)
        # The valve's flow is nonlinear by 1e-4 at these commands; images of the slow law lie above 2 kHz.
        np.testing.assert_allclose(measured / scale, found[k] / scale, rtol=0, atol=2e-3)
