"""The native control loop against the same law stepped in plain Python, its clock, converter, failures and files."""

import re
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from ehamj.controllers import Controller
from ehamj.errors import InputError
from ehamj.layout import COLUMN, CUBICS, MOUNTS, N_INPUTS, STEP_RATE, STEP_START
from ehamj.model import build_model
from ehamj.native import hydraulics
from ehamj.operating_point import Inputs, equilibrium
from ehamj.result import Result, load_result
from ehamj.scenario import Scenario, parse_scenario
from ehamj.simulate import Incomplete, choose_timestep, simulate, simulate_many

FLOOR = {"kind": "multisine", "frequencies": [7.0, 31.0, 83.0], "velocities": [2e-5], "wave": {"speed": 150.0}}
DELAYS = (0.0, 1e-4, 1.5e-4, 2.5e-4)
"""None, one sample, one sample and 50 µs, two and a half samples [s]."""


def scenario(**table: Any) -> Scenario:
    return parse_scenario({"plates": "tied", "duration": 0.06, "ground": FLOOR, **table})


def random_law(inputs: tuple[str, ...], gains: Any, states: int = 5, seed: int = 0, **settings: Any) -> Controller:
    """A stable law of some states in which everything counts; ``gains`` [V per unit] bring the inputs to volts."""
    draw = np.random.default_rng(seed).uniform
    A = draw(-1.0, 1.0, (states, states))
    A *= 0.95 / np.abs(np.linalg.eigvals(A)).max()
    B, D = (draw(-1.0, 1.0, (rows, len(inputs))) * np.asarray(gains) for rows in (states, 4))
    return Controller(A, B, draw(-0.3, 0.3, (4, states)), D, inputs, **settings)


def from_the_ground(**settings: Any) -> Controller:
    names = ("ground_velocity front-left z", "ground_displacement rear-right z", "ground_acceleration front-right z")
    return random_law(names, [1e4, 1e5, 1e2], **settings)


def from_the_machine(**settings: Any) -> Controller:
    """A closed loop, of gains that leave it stable."""
    names = (
        *("stroke front-left", "stroke_velocity rear-left", "chamber_pressure front-right 2", "spool rear-right"),
        *("load_pressure rear-left", "cg_acceleration z", "foot_velocity rear-right x", "machine_displacement ry"),
    )
    gains = [2e4, 300.0, 3e-8, 1e-2, 1e-6, 0.2, 300.0, 1e4]
    return random_law(names, gains, **settings)


LAWS = {"ground": from_the_ground, "machine": from_the_machine}


def proportional(gain: float, **settings: Any) -> Controller:
    """Stroke feedback at each mount, command = gain · stroke."""
    strokes = tuple(f"stroke {mount}" for mount in MOUNTS)
    return Controller(np.zeros((0, 0)), np.zeros((0, 4)), np.zeros((4, 0)), gain * np.eye(4), strokes, **settings)


# --- the same law in plain Python ---------------------------------------------------------------------------------


def measured(name: str, model: mujoco.MjModel, data: mujoco.MjData, ground: Any, plant: Any) -> float:
    """A channel from the engine's state; rotations small, joints x, y, z, rz, rx, ry, mounts tied to the machine."""
    variable, *labels = name.split(" ")
    mount = MOUNTS.index(labels[0]) if labels[0] in MOUNTS else -1

    def moved(vector: np.ndarray, point: Any) -> np.ndarray:
        x, y, z, rz, rx, ry = vector
        return np.array([x, y, z]) + np.cross([rx, ry, rz], point)

    motion = {"displacement": data.qpos, "velocity": data.qvel, "acceleration": data.qacc}
    if variable.startswith("ground_"):
        order = ("displacement", "velocity", "acceleration").index(variable.removeprefix("ground_"))
        return float(ground[order][mount, "xyz".index(labels[1])])
    if variable in ("stroke", "stroke_velocity"):
        order = int(variable == "stroke_velocity")
        foot = moved((data.qpos, data.qvel)[order], (*plant.positions[mount], 0.0))
        return float(foot[2] - ground[order][mount, 2])
    if variable.startswith("foot_"):
        return float(moved(motion[variable[5:]], (*plant.positions[mount], 0.0))["xyz".index(labels[1])])
    if variable.startswith("cg_"):
        return float(moved(motion[variable[3:]], plant.machine.cg)["xyz".index(labels[0])])
    if variable == "machine_displacement":
        return float(data.qpos[("x", "y", "z", "rz", "rx", "ry").index(labels[0])])
    spool, _, one, two = data.act[:16].reshape(4, 4)[mount]
    return {"spool": spool, "load_pressure": one - two, "chamber_pressure": two if labels[-1] == "2" else one}[variable]


def in_python(case: Scenario, law: Controller) -> np.ndarray:
    """Commands at every step, (steps + 1, 4): the engine stepped from Python, the law with plain arrays."""
    plant, motion = case.plant, case.motion()
    with hydraulics():
        step = choose_timestep(case, law)
        model = build_model(plant, step)
        data = mujoco.MjData(model)
        at_start = motion.sample(np.zeros(1))
        equilibrium(model, data, Inputs(at_start.displacement[0], at_start.velocity[0], np.zeros(4)))
        steps = round(case.duration / step)
        samples = motion.sample(np.arange(steps + 2) * step)
        state, due, found = np.zeros(law.states), [], []
        for k in range(steps + 1):
            data.time = k * step
            data.userdata[STEP_START], data.userdata[STEP_RATE] = data.time, 1 / step
            cubics = data.userdata[CUBICS : CUBICS + 4 * N_INPUTS].reshape(N_INPUTS, 4)
            for end, moment in ((0, k), (2, k + 1)):
                cubics[:12, end] = samples.displacement[moment].ravel()
                cubics[:12, end + 1] = samples.velocity[moment].ravel() * step
            mujoco.mj_forward(model, data)
            if k % round(law.period / step) == 0:
                ground = [part[k] for part in samples]
                u = np.array([measured(name, model, data, ground, plant) for name in law.inputs])
                y = np.clip(law.C @ state + law.D @ u, -law.voltage_limit, law.voltage_limit)
                if law.bits is not None:
                    lsb = 2 * law.voltage_limit / 2**law.bits
                    y = lsb * np.floor(y / lsb + 0.5)
                state = law.A @ state + law.B @ u
                due.append((k + round(law.latency / step), y))
            for moment, y in due:
                if moment == k:
                    data.ctrl[:] = y
            mujoco.mj_forward(model, data)
            found.append(data.ctrl.copy())
            mujoco.mj_RungeKutta(model, data, 4)
    return np.array(found)


def assert_native_is_python(case: Scenario, law: Controller) -> None:
    with hydraulics():
        rate = 1 / choose_timestep(case, law)
    case = case.model_copy(update={"record_rate": float(round(rate))})
    native = simulate(case, controller=law).dataset["valve_command"].values
    python = in_python(case, law)
    assert np.abs(python).max() > 0.05  # V: there is something to compare
    np.testing.assert_allclose(native, python, rtol=0, atol=1e-12)


@pytest.mark.parametrize("delay", DELAYS)
@pytest.mark.parametrize("kind", LAWS)
def test_commands_of_every_step_are_those_of_plain_python(kind: str, delay: float) -> None:
    assert_native_is_python(scenario(), LAWS[kind](delay=delay, bits=None))


@pytest.mark.parametrize("kind", LAWS)
def test_they_are_so_with_a_converter_of_sixteen_bits_that_clips(kind: str) -> None:
    law = LAWS[kind](voltage_limit=0.1)
    assert_native_is_python(scenario(), law)


@pytest.mark.parametrize(("period", "delay"), [(2e-4, None), (2e-4, 3e-4), (2.5e-4, 5e-5), (1e-3, 1.7e-3)])
def test_they_are_so_at_other_rates(period: float, delay: float | None) -> None:
    assert_native_is_python(scenario(), from_the_machine(period=period, delay=delay, bits=None))


def test_they_are_so_without_states() -> None:
    assert_native_is_python(scenario(), proportional(2e4, bits=None))


def test_sliding_plates_give_the_same_commands() -> None:
    tied, sliding = (
        simulate(scenario(plates=plates), controller=from_the_machine(bits=None)).dataset["valve_command"].values
        for plates in ("tied", "sliding")
    )
    # The tie yields by 1e-7 of its force, and its noise reaches the accelerations.
    np.testing.assert_allclose(sliding, tied, rtol=0, atol=1e-6 * np.abs(tied).max())


# --- converter ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def coarse() -> np.ndarray:
    """Commands of a converter of ±0.3 V and 6 bit."""
    law = from_the_ground(voltage_limit=0.3, bits=6)
    return simulate(scenario(record_rate=1e4), controller=law).dataset["valve_command"].values


def test_commands_stay_within_the_range_and_reach_it(coarse: np.ndarray) -> None:
    assert (coarse.min(), coarse.max()) == (-0.3, 0.3)


def test_commands_are_multiples_of_the_resolution(coarse: np.ndarray) -> None:
    levels = coarse / (0.6 / 64)
    np.testing.assert_allclose(levels, np.round(levels), rtol=0, atol=1e-12)
    assert np.unique(coarse).size > 30


def test_rounding_is_to_the_nearest(coarse: np.ndarray) -> None:
    exact = from_the_ground(voltage_limit=0.3, bits=None)
    fine = simulate(scenario(record_rate=1e4), controller=exact).dataset["valve_command"].values
    # A law of the ground alone: both runs measure the same.
    assert np.abs(coarse - fine).max() <= 0.5 * 0.6 / 64 * (1 + 1e-12)
    assert np.abs(np.mean(coarse - fine)) < 0.05 * 0.6 / 64  # and not always downwards


def test_no_command_comes_before_the_delay_has_passed() -> None:
    law = from_the_ground(delay=2.5e-4)
    run = simulate(scenario(record_rate=2e4), controller=law).dataset["valve_command"].values
    # Rows every 50 µs: the first five hold nothing, then each command holds for two.
    np.testing.assert_array_equal(run[:5], np.zeros((5, 4)))
    assert np.abs(run[5]).max() > 1e-3
    np.testing.assert_array_equal(run[5:-1:2], run[6::2])


# --- the step -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({}, r"timestep = 0\.000166667 s must divide the controller's period = 0\.0001 s; nearest: "),
        ({"period": 1e-3, "delay": 2.5e-4}, r".* must divide the controller's delay = 0\.00025 s; nearest: 0\.000125"),
    ],
)
def test_a_stated_step_must_divide_period_and_delay(settings: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        simulate(scenario(timestep=1 / 6000), controller=proportional(1.0, **settings))


@pytest.mark.parametrize(
    ("rate", "period", "delay"),
    [(1000.0, 1e-4, None), (1000.0, 1e-4, 5e-5), (300.0, 1e-4, 1.5e-4), (1000.0, 1 / 4000, 0.0), (500.0, 1e-3, 3.7e-4)],
)
def test_the_automatic_step_divides_the_period_the_delay_and_the_recording(
    rate: float, period: float, delay: float | None
) -> None:
    law = proportional(1.0, period=period, delay=delay)
    with hydraulics():
        step = choose_timestep(scenario(record_rate=rate), law)
    for length in (1 / rate, period, law.latency):
        assert length / step == pytest.approx(round(length / step), abs=1e-6)
    assert 1e-5 <= step <= 1.2 / (2 * np.pi * 552.0)


# --- limits and failures ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gain", [1e6, 1e9, 1e12])
def test_an_absurd_gain_is_bounded_by_the_range_and_reported(gain: float) -> None:
    run = simulate(scenario(duration=0.3), controller=proportional(gain))
    assert np.abs(run.dataset["valve_command"].values).max() == 10.0
    assert min(run.summary["saturation"]["command"].values()) > 0.9
    assert any("the command was at its limit" in warning for warning in run.summary["warnings"])


def test_an_absurd_gain_without_a_range_fails_with_mount_and_time() -> None:
    unlimited = {"voltage_limit": 1e12, "spool_stroke": 1e12, "spool_drive_limit": float("inf")}
    law = proportional(1e12, voltage_limit=1e12, bits=None)
    with pytest.raises(Incomplete) as caught:
        simulate(scenario(duration=0.3, actuators={"isolator": unlimited}), controller=law)
    said = re.match(r"simulation failed at ([0-9.e-]+) s, at ([a-z-]+): ", str(caught.value))
    assert said is not None, caught.value
    assert said[2] in MOUNTS
    assert 0.0 < float(said[1]) < 0.3
    assert not caught.value.result.complete


# --- threads, files -----------------------------------------------------------------------------------------------


def run_scenarios() -> list[Scenario]:
    feedforward = [
        {"kind": "feedforward"},
        {"kind": "feedforward", "delay": 5e-5},
        {"kind": "feedforward", "rate": 5e3},
    ]
    return [scenario(duration=0.3, control=control, seed=k) for k, control in enumerate([*feedforward, *feedforward])]


def test_two_threads_give_what_one_after_the_other_gives() -> None:
    for parallel, case in zip(simulate_many(run_scenarios(), threads=2), run_scenarios(), strict=True):
        assert parallel.dataset.identical(simulate(case).dataset)


def stored(result: Result, folder: Path) -> Result:
    result.save(folder)
    return load_result(folder)


def test_a_stored_result_with_a_law_runs_again_to_the_last_bit(tmp_path: Path) -> None:
    first = simulate(scenario(), controller=from_the_machine(delay=1.5e-4))
    again = simulate(stored(first, tmp_path).scenario)
    assert (tmp_path / "controller.json").is_file()
    assert again.dataset.equals(first.dataset)


def test_a_stored_result_holds_the_law_that_ran(tmp_path: Path) -> None:
    law = from_the_machine(delay=1.5e-4)
    found = stored(simulate(scenario(), controller=law), tmp_path).controller
    assert found is not None
    assert found.to_dict() == law.to_dict()


def test_a_law_from_a_file_is_the_law(tmp_path: Path) -> None:
    law = from_the_machine()
    law.save(tmp_path / "mine.json")
    from_file = simulate(scenario(control={"kind": "law", "file": str(tmp_path / "mine.json")}))
    np.testing.assert_array_equal(
        from_file.dataset["valve_command"].values, simulate(scenario(), controller=law).dataset["valve_command"].values
    )


OPEN_LOOP = {
    "kind": "open-loop",
    "signals": [{"kind": "sine", "mounts": ["rear-left"], "amplitude": 1.0, "frequency": 20.0}],
}


def test_a_controller_runs_instead_of_the_scenarios_control() -> None:
    alone, instead = (
        simulate(scenario(**control), controller=from_the_machine()).dataset["valve_command"].values
        for control in ({}, {"control": OPEN_LOOP})
    )
    np.testing.assert_array_equal(instead, alone)


def test_a_stored_result_runs_again_even_where_the_law_replaced_an_open_loop(tmp_path: Path) -> None:
    first = simulate(scenario(control=OPEN_LOOP), controller=from_the_machine())
    assert simulate(stored(first, tmp_path).scenario).dataset.equals(first.dataset)


def test_a_missing_law_is_bad_input(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^control\.file = '.*none\.json': cannot be read as a controller"):
        simulate(scenario(control={"kind": "law", "file": str(tmp_path / "none.json")}))


def test_the_voltage_of_the_valve_limits_what_a_wider_converter_commands() -> None:
    law = proportional(-1e12, voltage_limit=40.0, delay=0.0)
    run = simulate(scenario(duration=0.02, ground={"kind": "rest"}, record_rate=1e4), controller=law).dataset
    model = build_model(scenario().plant, 1e-4)
    assert model.actuator_user[0, COLUMN["voltage_limit"]] == 10.0
    assert np.abs(run["valve_command"].values).max() == 40.0
    # The spool of ζ = 0.65 overshoots its target, ±20 mA at ±10 V, by exp(−πζ/√(1 − ζ²)) = 7 % at most.
    assert np.abs(run["spool"].values).max() <= 20.0 * 1.08
