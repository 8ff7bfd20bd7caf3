"""The native control loop against the same law stepped in plain Python, its clock, converter, failures and files."""

import re
from pathlib import Path
from typing import Any

import control
import mujoco
import numpy as np
import pytest

from ehamj.control import Controller, ControllerBank, PythonController, load_controller
from ehamj.errors import InputError
from ehamj.memory import exchange, isolators
from ehamj.memory import step as step_of
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import Inputs, equilibrium
from ehamj.mujoco.model import build_model
from ehamj.plant.mounts import MOUNTS
from ehamj.result import Result, load_result
from ehamj.run.failures import Incomplete
from ehamj.run.many import simulate_many
from ehamj.run.simulate import simulate
from ehamj.run.timestep import choose_timestep
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

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
        foot = moved((data.qpos, data.qvel)[order], plant.positions[mount])
        return float(foot[2] - ground[order][mount, 2])
    if variable.startswith("foot_"):
        return float(moved(motion[variable[5:]], plant.positions[mount])["xyz".index(labels[1])])
    if variable.startswith("cg_"):
        return float(moved(motion[variable[3:]], plant.machine.cg)["xyz".index(labels[0])])
    if variable == "machine_displacement":
        return float(data.qpos[("x", "y", "z", "rz", "rx", "ry").index(labels[0])])
    spool, _, one, two = data.act[:16].reshape(4, 4)[mount]
    return {"spool": spool, "load_pressure": one - two, "chamber_pressure": two if labels[-1] == "2" else one}[variable]


def stages(times: list[float], levels: list[np.ndarray]) -> np.ndarray:
    """Values at start, middle and end of a step, (3, 4), for levels that begin at times of it (of one that is 1 long).

    The integrator weighs them so that a command u enters the states it drives by ∫u, what these drive by ∫(1 − s) u,
    and the next by ∫(1 − s)²/2 u.
    """
    weights = np.array([[1.0, 4.0, 1.0], [1.0, 2.0, 0.0], [0.5, 0.5, 0.0]]) / 6.0
    left = 1.0 - np.array([*times, 1.0])
    moments = [
        sum((left[n] ** p - left[n + 1] ** p) / (p * max(p - 1, 1)) * level for n, level in enumerate(levels))
        for p in (1, 2, 3)
    ]
    return np.linalg.solve(weights, np.array(moments))


def in_python(case: Scenario, controller: Controller | ControllerBank) -> np.ndarray:
    """Commands at every step, (steps + 1, 4): the engine stepped from Python, the laws with plain arrays."""
    plant, motion, laws = case.plant, case.motion(), controller.parts
    with hydraulics():
        step = choose_timestep(case, controller)
        model = build_model(plant, step)
        data = mujoco.MjData(model)
        at_start = motion.sample(np.zeros(1))
        equilibrium(model, data, Inputs(at_start.displacement[0], at_start.velocity[0], np.zeros(4)))
        steps = round(case.duration / step)
        samples = motion.sample(np.arange(steps + 2) * step)
        states, latest, held = (
            [np.zeros(law.states) for law in laws],
            np.zeros((len(laws), 4)),
            np.zeros((len(laws), 4)),
        )
        due, found, converter = [], [], controller.converter
        limit = converter.voltage_limit
        for k in range(steps + 1):
            data.time = k * step
            step_of(data)["start"], step_of(data)["rate"] = data.time, 1 / step
            for axis, letter in enumerate("xyz"):
                cubic = exchange(data, 4)[f"ground_{letter}"]
                for end, moment in (("", k), ("end_", k + 1)):
                    cubic[f"{end}value"] = samples.displacement[moment, :, axis]
                    cubic[f"{end}slope"] = samples.velocity[moment, :, axis] * step
            mujoco.mj_forward(model, data)
            ground, inputs = [part[k] for part in samples], {}
            sampled = [j for j, law in enumerate(laws) if k % round(law.period / step) == 0]
            for j in sampled:
                law = laws[j]
                inputs[j] = np.array([measured(name, model, data, ground, plant) for name in law.inputs])
                latest[j] = law.C @ states[j] + law.D @ inputs[j]
            share = 1.0
            if data.time < converter.switch_on - 1e-9:
                share = 0.0
            elif converter.fade > 0.0 and data.time < converter.switch_on + converter.fade - 1e-9:
                s = (data.time - converter.switch_on) / converter.fade
                share = 3 * s**2 - 2 * s**3
            total = latest.sum(axis=0)
            missing = np.clip(share * total, -limit, limit) - total
            for j in sampled:
                law = laws[j]
                states[j] = law.A @ states[j] + law.B @ inputs[j]
                if law.anti_windup is not None:
                    states[j] += law.anti_windup @ missing
                due.append((k + law.latency / step, j, share * latest[j]))

            def command() -> np.ndarray:
                volts = np.clip(held.sum(axis=0), -limit, limit)
                if converter.bits is None:
                    return volts
                lsb = 2 * limit / 2**converter.bits
                return lsb * np.floor(volts / lsb + 0.5)

            times, levels = [0.0], []
            for moment, j, y in sorted(due, key=lambda each: each[0]):
                if k - 1 + 1e-6 < moment < k + 1 - 1e-6:
                    if moment > k + 1e-6:
                        levels.append(command())
                        times.append(moment - k)
                    held[j] = y
            levels.append(command())
            data.ctrl[:] = levels[0]
            for stage, extra in zip(("start", "middle", "end"), stages(times, levels), strict=True):
                exchange(data, 4)[f"switch_{stage}"] = extra - levels[0]
            due = [each for each in due if each[0] > k + 1 - 1e-6]
            mujoco.mj_forward(model, data)
            found.append(data.ctrl.copy())
            mujoco.mj_RungeKutta(model, data, 4)
    return np.array(found)


def assert_native_is_python(case: Scenario, law: Controller | ControllerBank) -> None:
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


WINDS_UP = {"voltage_limit": 0.1, "bits": None}
"""A range that the commands leave, so that anti-windup has something to do [V]."""


@pytest.mark.parametrize("kind", LAWS)
def test_they_are_so_with_anti_windup_switched_on_late(kind: str) -> None:
    law = LAWS[kind](**WINDS_UP, delay=1.5e-4, switch_on=0.01, fade=0.02).with_anti_windup(0.005)
    assert_native_is_python(scenario(), law)


def test_they_are_so_of_laws_of_several_rates_and_delays() -> None:
    common = {**WINDS_UP, "switch_on": 0.005, "fade": 0.01}
    parts = (
        from_the_ground(**common).with_anti_windup(0.005),
        from_the_machine(period=5e-4, delay=2e-4, seed=3, **common).with_anti_windup(0.01),
        proportional(2e4, period=2.5e-4, delay=0.0, **common),
    )
    assert_native_is_python(scenario(), ControllerBank(parts))


def test_they_are_so_of_laws_that_switch_within_steps() -> None:
    """At a step of 100 µs: two at the same fraction of it, one at another, one within the step of its sample."""
    parts = (
        from_the_ground(delay=2.3e-4, period=2e-4, **WINDS_UP).with_anti_windup(0.005),
        from_the_machine(delay=3e-5, **WINDS_UP).with_anti_windup(0.01),
        from_the_machine(period=5e-4, delay=1.6e-4, seed=3, **WINDS_UP),
        proportional(2e4, delay=0.0, **WINDS_UP),
    )
    assert_native_is_python(scenario(), ControllerBank(parts))


def test_they_are_so_where_the_first_of_those_that_switch_together_is_seldom_due() -> None:
    """At a step of 100 µs, every fifth of a slow law and every one of a fast one, at the same fraction."""
    parts = (
        from_the_machine(period=5e-4, delay=1.6e-4, seed=3, **WINDS_UP),
        from_the_ground(period=1e-4, delay=1.6e-4, **WINDS_UP),
    )
    assert_native_is_python(scenario(), ControllerBank(parts))


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
        ({"period": 1.25e-3, "delay": 0.0}, r".* the controller's period = 0\.00125 s; nearest: 0\.000125"),
    ],
)
def test_a_stated_step_must_divide_the_period(settings: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=f"^{message}"):
        simulate(scenario(timestep=1 / 6000), controller=proportional(1.0, **settings))


@pytest.mark.parametrize(
    ("rate", "period", "delay"),
    [(1000.0, 1e-4, None), (1000.0, 1e-4, 5e-5), (300.0, 1e-4, 1.5e-4), (1000.0, 1 / 4000, 0.0), (500.0, 1e-3, 3.7e-4)],
)
def test_the_automatic_step_divides_the_period_and_the_recording_and_no_delay(
    rate: float, period: float, delay: float | None
) -> None:
    law = proportional(1.0, period=period, delay=delay)
    with hydraulics():
        step = choose_timestep(scenario(record_rate=rate), law)
        longest = choose_timestep(scenario(record_rate=rate), proportional(1.0, period=period, delay=0.0))
    assert step == longest
    for length in (1 / rate, period):
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
    result.write(folder)
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
    assert isolators(model)["voltage_limit"][0] == 10.0
    assert np.abs(run["valve_command"].values).max() == 40.0
    # The spool of ζ = 0.65 overshoots its target, ±20 mA at ±10 V, by exp(−πζ/√(1 − ζ²)) = 7 % at most.
    assert np.abs(run["spool"].values).max() <= 20.0 * 1.08


# --- anti-windup and switch-on ------------------------------------------------------------------------------------


def stroke_integrator(**settings: Any) -> Controller:
    """Integral of each stroke, which the −14.6 µm under the machine's weight wind up, to 73 V in 0.5 s."""
    strokes = tuple(f"stroke {mount}" for mount in MOUNTS)
    one = np.eye(4)
    return Controller(one, 1e-4 * one, 1e7 * one, 0.0 * one, strokes, **settings)


def test_without_anti_windup_an_integrator_that_is_not_connected_runs_away_and_with_it_does_not() -> None:
    case = scenario(duration=0.5, ground={"kind": "rest"})
    plain, held = (
        simulate(case, controller=law).dataset["controller_state"].values[-1] * 1e7
        for law in (
            stroke_integrator(switch_on=1.0),
            stroke_integrator(switch_on=1.0).with_anti_windup(0.02),
        )
    )
    # ∫ stroke dt of −14.62 µm: −73 V; with it the stationary value is input · time = −14.62 µm · 1e7 · 0.02 s.
    np.testing.assert_allclose(plain, -14.62e-6 * 1e7 * 0.5, rtol=1e-3)
    np.testing.assert_allclose(held, -14.62e-6 * 1e7 * 0.02, rtol=0.01)


def test_before_switch_on_the_valves_get_zero_and_the_fade_has_no_jump() -> None:
    law = from_the_ground(switch_on=0.02, fade=0.02, delay=0.0, bits=None)
    plain = from_the_ground(delay=0.0, bits=None)
    case = scenario(record_rate=1e4)
    late, full = (simulate(case, controller=one).dataset["valve_command"] for one in (law, plain))
    np.testing.assert_array_equal(late.values[:200], np.zeros((200, 4)))
    # A law of the ground alone, without anti-windup: only the share differs.
    time = late.time.values
    s = np.clip((time - 0.02) / 0.02, 0.0, 1.0)
    np.testing.assert_allclose(late.values, full.values * (3 * s**2 - 2 * s**3)[:, None], rtol=0, atol=1e-12)


def test_an_anti_windup_shortens_what_follows_a_blow() -> None:
    shock = {"kind": "shock", "dof": "z", "velocity": 2e-3, "pulse_time": 0.02, "begin": 0.02}
    gains = {"bits": None, "voltage_limit": 2.0}
    after = []
    for law in (stroke_integrator(**gains), stroke_integrator(**gains).with_anti_windup(0.01)):
        case = scenario(duration=0.1, plates="tied", ground=shock)
        state = simulate(case, controller=law).dataset["controller_state"].values
        after.append(np.abs(state).max() * 1e7)
    assert after[1] < 0.5 * after[0]


# --- laws of several rates ----------------------------------------------------------------------------------------


def test_a_bank_of_one_rate_is_the_one_law() -> None:
    one, other = from_the_ground(bits=None), from_the_machine(bits=None)
    together = ControllerBank.combine((one, other))
    assert isinstance(together, Controller)
    bank = ControllerBank((one, other))
    runs = [simulate(scenario(), controller=law).dataset["valve_command"].values for law in (together, bank)]
    np.testing.assert_allclose(runs[1], runs[0], rtol=0, atol=1e-12)  # V: sums of another order


def test_laws_side_by_side_share_one_converter() -> None:
    with pytest.raises(InputError, match=r"^controller\.parts: bits = None beside 16; all must share one converter"):
        ControllerBank((from_the_ground(), from_the_ground(period=2e-4, bits=None)))


def test_an_empty_bank_is_refused() -> None:
    with pytest.raises(InputError, match=r"^controller\.parts: is empty"):
        ControllerBank(())


def test_a_bank_whose_anti_windups_together_are_unstable_is_refused() -> None:
    # Each integrator alone stands 1 − 1.5 = −0.5; three that each take all of the sum's error: 1 − 4.5.
    part = Controller(
        [[1.0]], [[1.0]], [[1.0], [0], [0], [0]], np.zeros((4, 1)), ("stroke front-left",), anti_windup=[[1.5, 0, 0, 0]]
    )
    with pytest.raises(InputError, match=r"magnitude 3\.5; it must be at most 1"):
        ControllerBank((part, part, part))


def test_a_stored_result_with_a_bank_runs_again_to_the_last_bit(tmp_path: Path) -> None:
    bank = ControllerBank((from_the_ground(), from_the_machine(period=5e-4, switch_on=0.0).with_anti_windup()))
    first = simulate(scenario(), controller=bank)
    kept = stored(first, tmp_path)
    assert simulate(kept.scenario).dataset.equals(first.dataset)
    assert load_controller(tmp_path / "controller.json").to_dict() == bank.to_dict()


# --- what is recorded ---------------------------------------------------------------------------------------------


def test_states_and_readings_are_recorded_with_their_names() -> None:
    law = from_the_machine(bits=None, delay=0.0, voltage_limit=100.0)
    found = simulate(scenario(record_rate=1e4), controller=law).dataset
    assert list(found["sensor"].values) == list(law.inputs)
    assert found["controller_state"].dims == ("time", "law_state")
    x, u = found["controller_state"].values, found["measured"].values
    # Recorded after the sample: the state is already the next one's. Single precision of values up to one.
    np.testing.assert_allclose(x[1:], x[:-1] @ law.A.T + u[1:] @ law.B.T, rtol=0, atol=1e-6 * np.abs(x).max())
    command = np.vstack([np.zeros(law.states), x[:-1]]) @ law.C.T + u @ law.D.T
    np.testing.assert_allclose(found["valve_command"].values, command, rtol=0, atol=1e-5)


def test_readings_without_sensors_are_the_channels_themselves() -> None:
    found = simulate(scenario(), controller=from_the_machine()).dataset
    read = found["measured"].sel(sensor="stroke front-left").values
    np.testing.assert_allclose(read, found["stroke"].sel(mount="front-left").values, rtol=0, atol=1e-15)


def test_a_run_without_a_controller_records_neither() -> None:
    found = simulate(scenario(duration=0.01)).dataset
    assert not {"measured", "controller_state"} & set(found.variables)


# --- a function in Python -----------------------------------------------------------------------------------------


class Stepped:
    """A law stepped in Python, with its anti-windup."""

    def __init__(self, law: Controller) -> None:
        self.law = law

    def reset(self) -> None:
        self.state, self.last = np.zeros(self.law.states), None

    def __call__(self, time: float, measured: np.ndarray, limited: np.ndarray) -> np.ndarray:
        if self.law.anti_windup is not None:
            self.state = self.state + self.law.anti_windup @ limited
        volts = self.law.C @ self.state + self.law.D @ measured
        self.state = self.law.A @ self.state + self.law.B @ measured
        return volts


def as_function(law: Controller) -> PythonController:
    names = ("inputs", "period", "delay", "voltage_limit", "bits", "switch_on", "fade")
    return PythonController(Stepped(law), **{name: getattr(law, name) for name in names})


@pytest.mark.parametrize("settings", [{"delay": 0.0}, {"delay": 1.5e-4, **WINDS_UP, "switch_on": 0.01, "fade": 0.01}])
@pytest.mark.parametrize("kind", LAWS)
def test_a_function_does_what_the_law_does(kind: str, settings: dict[str, Any]) -> None:
    law = LAWS[kind](**{"bits": None, **settings}).with_anti_windup(0.005)
    function = as_function(law)
    native, python, again = (
        simulate(scenario(record_rate=1e4), controller=one).dataset["valve_command"].values
        for one in (law, function, function)
    )
    assert np.abs(native).max() > 0.05
    np.testing.assert_allclose(python, native, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(again, python)  # it begins anew


def test_a_function_that_raises_ends_the_run_with_its_words() -> None:
    def fails(time: float, measured: np.ndarray, limited: np.ndarray) -> np.ndarray:
        if time > 0.02:
            raise ZeroDivisionError("by nothing")
        return np.zeros(4)

    with pytest.raises(
        Incomplete, match=r"at 0\.0201 s, in the Python controller: ZeroDivisionError: by nothing"
    ) as caught:
        simulate(scenario(), controller=PythonController(fails, ("stroke front-left",)))
    assert isinstance(caught.value.__cause__, ZeroDivisionError)
    assert float(caught.value.result.dataset.time[-1]) == pytest.approx(0.02)


@pytest.mark.parametrize("wrong", [np.zeros(3), [np.nan, 0, 0, 0], None])
def test_a_function_that_returns_no_commands_ends_the_run(wrong: Any) -> None:
    with pytest.raises(Incomplete, match=r"at 0 s, in the Python controller"):
        simulate(scenario(), controller=PythonController(lambda *_: wrong, ()))


def test_a_function_alone_is_refused() -> None:
    with pytest.raises(InputError, match=r"wrap it in ehamj\.PythonController"):
        simulate(scenario(), controller=lambda *_: np.zeros(4))


def test_a_run_of_a_function_says_that_it_cannot_be_repeated_from_its_scenario() -> None:
    found = simulate(scenario(), controller=PythonController(lambda *_: np.zeros(4), ()))
    assert found.controller is None
    assert any("Python function" in warning for warning in found.summary["warnings"])


def test_a_control_system_with_dt_runs_directly() -> None:
    law = from_the_machine()
    system = control.ss(law.A, law.B, law.C, law.D, law.period, inputs=list(law.inputs))
    np.testing.assert_array_equal(
        simulate(scenario(), controller=system).dataset["valve_command"].values,
        simulate(scenario(), controller=law).dataset["valve_command"].values,
    )


def test_each_simulation_of_a_batch_has_its_own_controller() -> None:
    laws = [from_the_machine(seed=k) for k in range(3)]
    batch = simulate_many([scenario()] * 4, controllers=[*laws, None])
    for law, found in zip([*laws, None], batch, strict=True):
        assert found.dataset.equals(simulate(scenario(), controller=law).dataset)
    with pytest.raises(InputError, match="are 1, they must be one for each of the 2 scenarios"):
        simulate_many([scenario()] * 2, controllers=laws[:1])
