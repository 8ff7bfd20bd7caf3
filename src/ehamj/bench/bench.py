"""Timings as ratios within one process: what the hydraulics, the recording, the engine and a controller cost.

The benchmark case is integrated by the engine with its callbacks and by the same equations in bare compiled RK4
without any multibody engine, which is the ceiling of what is possible. Each figure is the median of interleaved
repetitions, so that a busy machine disturbs both sides alike.
"""

import time as clock
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from typing import Any

import mujoco
import numba
import numpy as np
from numpy.typing import NDArray

from ehamj.control import Controller
from ehamj.control.compiled.loop import NO_LOOP, make_loop
from ehamj.control.sensors import Sensors
from ehamj.isolator.cylinder import chamber_flows
from ehamj.isolator.fluid import pressure_rate
from ehamj.isolator.valve import spool_acceleration, spool_target
from ehamj.memory import COLUMN, N_STATES
from ehamj.mujoco import hydraulics
from ehamj.mujoco.advance import N_TALLY, NOT_LOADED, advance, row_size
from ehamj.mujoco.equilibrium import Inputs, equilibrium
from ehamj.mujoco.hold import default_timer
from ehamj.mujoco.model import build_model
from ehamj.plant.mounts import MOUNTS, N_MOUNTS
from ehamj.plant.plant import Plant
from ehamj.run.inputs import sample_inputs, sample_load
from ehamj.run.simulate import simulate
from ehamj.run.timestep import choose_timestep
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import Scenario

Array = NDArray[np.float64]


def bench(repetitions: int = 5) -> dict[str, Any]:
    """All timings: seconds per step, ratios, errors; see the keys' names for units."""
    scenario = load_scenario("benchmark")
    with hydraulics():
        step = choose_timestep(scenario)
    tied = step_times(scenario.plant, step, repetitions)
    sliding = step_times(load_scenario("recorded").plant, step, repetitions)
    case = benchmark_case(scenario, step, repetitions)
    return {
        "step_us": {"tied": {k: 1e6 * v for k, v in tied.items()}, "sliding": {k: 1e6 * v for k, v in sliding.items()}},
        "hydraulics_over_bare_engine": {
            "tied": tied["hydraulics"] / tied["bare"],
            "sliding": sliding["hydraulics"] / sliding["bare"],
        },
        "hydraulics_over_bare_engine_without_timer": {
            "tied": tied["hydraulics"] / tied["bare_without_timer"],
            "sliding": sliding["hydraulics"] / sliding["bare_without_timer"],
        },
        "benchmark_case": case,
        "recorded_over_bare_engine": case["engine_us_per_step"] / (1e6 * tied["bare"]),
        "two_threads_over_one": thread_scaling(scenario, repetitions),
        "step_over_step_without": {"sliding": additions(load_scenario("recorded"), repetitions)},
    }


def step_times(plant: Plant, timestep: float, repetitions: int, steps: int = 3000) -> dict[str, float]:
    """Seconds per step: the bare engine as shipped and without its profiling timer, and with the hydraulics."""
    model = build_model(plant, timestep)
    bare, moved = mujoco.MjData(model), mujoco.MjData(model)
    bare.qvel[:] = moved.qvel[:] = 1e-6
    with hydraulics():
        equilibrium(model, moved, Inputs.rest())
    times: dict[str, list[float]] = {"bare": [], "bare_without_timer": [], "hydraulics": []}
    for _ in range(3 * repetitions + 1):
        times["bare"].append(_seconds(lambda: mujoco.mj_step(model, bare, nstep=steps)))
        with default_timer(off=True):
            times["bare_without_timer"].append(_seconds(lambda: mujoco.mj_step(model, bare, nstep=steps)))
        with hydraulics():
            times["hydraulics"].append(_seconds(lambda: mujoco.mj_step(model, moved, nstep=steps)))
    return {name: float(np.median(values[1:])) / steps for name, values in times.items()}


def benchmark_case(scenario: Scenario, step: float, repetitions: int) -> dict[str, float]:
    """The benchmark case recorded at 1 kHz, against the same equations in bare compiled RK4 at the same step."""
    steps, every = round(scenario.duration / step), round(1.0 / (scenario.record_rate * step))
    model = build_model(scenario.plant, step)
    inputs = sample_inputs(scenario.motion(), scenario.commands(), 0, steps + 1, step)
    rows = np.empty((steps // every + 1, row_size(model)))
    with hydraulics():
        start = mujoco.MjData(model)
        equilibrium(model, start, Inputs.rest())

        def engine() -> None:
            data = mujoco.MjData(model)
            data.qpos[:], data.act[:] = start.qpos, start.act
            advance(model, data, 0, steps, inputs, every, rows, np.zeros(N_TALLY), last=True)

        pairs = [(_seconds(engine), _seconds(lambda: ceiling(scenario, step))) for _ in range(repetitions + 1)]
    engine_time, ceiling_time = np.median(pairs[1:], axis=0)
    reference = ceiling(scenario, step / 24)
    return {
        "step_s": step,
        "simulated_s_per_wall_s": scenario.duration / engine_time,
        "engine_us_per_step": 1e6 * engine_time / steps,
        "ceiling_us_per_step": 1e6 * ceiling_time / steps,
        "rate_over_ceiling": ceiling_time / engine_time,
        "error": deviation(channels(simulate(scenario)), reference),
        "ceiling_error": deviation(ceiling(scenario, step), reference),
    }


def thread_scaling(scenario: Scenario, repetitions: int, batch: int = 8) -> float:
    """Rate of two threads over one in a batch of simulations."""
    step = 1.0 / 3000.0
    steps = round(scenario.duration / step)
    model = build_model(scenario.plant, step)
    inputs = sample_inputs(scenario.motion(), scenario.commands(), 0, steps, step)

    def one(_: int) -> None:
        data = mujoco.MjData(model)
        data.act.reshape(N_MOUNTS, N_STATES)[:, 2:] = scenario.supply.pressure / 2
        advance(model, data, 0, steps, inputs, steps, np.empty((1, row_size(model))), np.zeros(N_TALLY))

    ratios = []
    with hydraulics(), ThreadPoolExecutor(1) as single, ThreadPoolExecutor(2) as double:
        for _ in range(repetitions + 1):
            alone = _seconds(lambda: list(single.map(one, range(batch))))
            together = _seconds(lambda: list(double.map(one, range(batch))))
            ratios.append(alone / together)
    return float(np.median(ratios[1:]))


CONTROLLER_STATES, CONTROLLER_INPUTS = 80, 24
"""Size of the controller that is timed, at 10 kHz."""


def additions(scenario: Scenario, repetitions: int, steps: int = 4000) -> dict[str, float]:
    """Time of a step with a large controller, with its sensors too, and with a force, over a step without any.

    Each at 10 kHz with one step per sample, so that the controller weighs most.
    """
    step = 1e-4
    plant, controller = scenario.plant, _large_controller()
    table = {"ground": {"kind": "geophone"}, "inertial": {"kind": "geophone"}, "stroke": {}, "pressure": {}}
    loops = {
        "nothing": NO_LOOP,
        "controller": make_loop(controller, plant, step),
        "controller_and_sensors": make_loop(controller, plant, step, Sensors.model_validate(table)),
        "force": NO_LOOP,
    }
    pushed = parse_scenario({"force": [{"kind": "sine", "amplitude": 1.0, "frequency": 20.0}]}).load()
    forces = dict.fromkeys(loops, NOT_LOADED) | {"force": sample_load(pushed, 0, steps, step)}
    model = build_model(plant, step)
    inputs = sample_inputs(scenario.motion(), scenario.commands(), 0, steps, step)
    times: dict[str, list[float]] = {name: [] for name in loops}
    with hydraulics():
        start = mujoco.MjData(model)
        equilibrium(model, start, Inputs.rest())

        def one(name: str) -> None:
            data, loop = mujoco.MjData(model), loops[name]
            data.qpos[:], data.act[:] = start.qpos, start.act
            noise = np.zeros((loop.samples(0, steps)[1], loop.readings))
            rows = np.empty((steps // 10 + 1, row_size(model, loop)))
            advance(model, data, 0, steps, inputs, 10, rows, np.zeros(N_TALLY), False, loop, noise, forces[name])

        for _ in range(2 * repetitions + 1):
            for name in loops:
                times[name].append(_seconds(partial(one, name)))
    plain = np.array(times.pop("nothing")[1:])
    return {name: float(np.median(np.array(values[1:]) / plain)) for name, values in times.items()}


def _large_controller() -> Controller:
    """A law of many states that hardly commands anything, with anti-windup."""
    draw = np.random.default_rng(0).normal
    names = [f"{what} {mount} z" for what in ("ground_velocity", "foot_velocity") for mount in MOUNTS]
    names += [f"{what} {mount}" for what in ("stroke", "load_pressure") for mount in MOUNTS]
    names += [f"foot_velocity {mount} {axis}" for mount in MOUNTS for axis in "xy"]
    n, p = CONTROLLER_STATES, CONTROLLER_INPUTS
    A = draw(size=(n, n))
    A *= 0.9 / np.abs(np.linalg.eigvals(A)).max()
    law = Controller(
        A, 1e-9 * draw(size=(n, p)), 1e-6 * draw(size=(N_MOUNTS, n)), np.zeros((N_MOUNTS, p)), tuple(names)
    )
    return law.with_anti_windup()


def channels(result: Any) -> Array:
    """The compared channels of a result, (n, 9): x, y, z, rx, ry and the four load pressures."""
    motion = result.dataset["machine_displacement"].values[:, :5]
    pressure = result.dataset["chamber_pressure"].values
    return np.hstack([motion, pressure[:, :, 0] - pressure[:, :, 1]])


def deviation(found: Array, reference: Array) -> float:
    """Largest deviation over time, over that channel's peak, worst channel."""
    return float((np.abs(found - reference).max(axis=0) / np.abs(reference).max(axis=0)).max())


def ceiling(scenario: Scenario, step: float) -> Array:
    """The benchmark's equations in bare compiled RK4, sampled at the recording rate: its `channels`."""
    plant, machine = scenario.plant, scenario.plant.machine
    m, h = machine.mass, machine.cg[2]
    jx, jy, jz = machine.inertia
    mass = np.diag([m, m, m, jx + m * h * h, jy + m * h * h, jz])
    mass[0, 4] = mass[4, 0] = m * h
    mass[1, 3] = mass[3, 1] = -m * h
    table = np.array(build_model(plant, step).actuator_user)
    frequency = np.array([setting.frequency for setting in scenario.control.signals])  # type: ignore[attr-defined]
    amplitude = np.array([setting.amplitude for setting in scenario.control.signals])  # type: ignore[attr-defined]
    steps, every = round(scenario.duration / step), round(1.0 / (scenario.record_rate * step))
    states = _ceiling_loop()(np.linalg.inv(mass), table, amplitude, 2 * np.pi * frequency, steps, every, step)
    pressure = states[:, 12:].reshape(-1, N_MOUNTS, N_STATES)[:, :, 2:]
    return np.hstack([states[:, :5], pressure[:, :, 0] - pressure[:, :, 1]])


@cache
def _ceiling_loop() -> Any:
    area, v1, v2, beta, wall = (
        COLUMN[k] for k in ("piston_area", "volume_1", "volume_2", "bulk_modulus", "wall_compliance")
    )
    gain, edge, cross, eps = (COLUMN[k] for k in ("flow_gain", "edge_leakage", "cross_leakage", "laminar_ratio"))
    supply, tank, rated = (COLUMN[k] for k in ("supply_pressure", "tank_pressure", "rated_pressure"))
    valve, omega, zeta = (COLUMN[k] for k in ("valve_gain", "valve_frequency", "valve_damping"))
    drive, stroke, volts = (COLUMN[k] for k in ("spool_drive_limit", "spool_stroke", "voltage_limit"))
    stiff, damp = COLUMN["membrane_stiffness"], COLUMN["membrane_damping"]
    k_lat, c_lat = COLUMN["lateral_stiffness"], COLUMN["lateral_damping"]
    x, y = COLUMN["mount_x"], COLUMN["mount_y"]

    def rates(s, t, inverse, p, amplitude, angular, force, out):  # type: ignore[no-untyped-def]
        force[:] = 0.0
        for i in range(N_MOUNTS):
            px, py = p[i, x], p[i, y]
            height = s[2] + py * s[3] - px * s[4]
            rise = s[8] + py * s[9] - px * s[10]
            a = 12 + N_STATES * i
            q1, q2, _ = chamber_flows(
                min(max(s[a], -p[i, stroke]), p[i, stroke]),
                s[a + 2],
                s[a + 3],
                p[i, supply],
                p[i, tank],
                p[i, rated],
                p[i, gain],
                p[i, edge],
                p[i, cross],
                p[i, eps],
            )
            target = spool_target(amplitude[i] * np.sin(angular[i] * t), p[i, valve], p[i, volts])
            out[a] = s[a + 1]
            out[a + 1] = spool_acceleration(s[a], s[a + 1], target, p[i, omega], p[i, zeta], p[i, drive], 0.0)
            out[a + 2] = pressure_rate(q1, p[i, area] * rise, s[a + 2], p[i, v1], p[i, beta], p[i, wall])
            out[a + 3] = pressure_rate(q2, -p[i, area] * rise, s[a + 3], p[i, v2], p[i, beta], p[i, wall])
            lift = p[i, area] * (s[a + 2] - s[a + 3]) - p[i, stiff] * height - p[i, damp] * rise
            pull_x = -p[i, k_lat] * (s[0] - py * s[5]) - p[i, c_lat] * (s[6] - py * s[11])
            pull_y = -p[i, k_lat] * (s[1] + px * s[5]) - p[i, c_lat] * (s[7] + px * s[11])
            force[0] += pull_x
            force[1] += pull_y
            force[2] += lift
            force[3] += py * lift
            force[4] -= px * lift
            force[5] += px * pull_y - py * pull_x
        for i in range(6):
            out[i] = s[6 + i]
            out[6 + i] = 0.0
            for j in range(6):
                out[6 + i] += inverse[i, j] * force[j]

    compiled_rates = numba.njit(nogil=True, error_model="numpy")(rates)

    def loop(inverse, p, amplitude, angular, steps, every, h):  # type: ignore[no-untyped-def]
        n = 12 + N_STATES * N_MOUNTS
        s, trial, rate, total, force = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(6)
        nodes, weights = (0.0, 0.5, 0.5, 1.0), (1.0, 2.0, 2.0, 1.0)
        for i in range(N_MOUNTS):
            s[14 + N_STATES * i] = s[15 + N_STATES * i] = 0.5 * (p[i, supply] + p[i, tank])
        rows = np.empty((steps // every + 1, n))
        for k in range(steps + 1):
            if k % every == 0:
                rows[k // every] = s
            total[:] = 0.0
            rate[:] = 0.0
            for stage in range(4):
                for i in range(n):
                    trial[i] = s[i] + nodes[stage] * h * rate[i]
                compiled_rates(trial, (k + nodes[stage]) * h, inverse, p, amplitude, angular, force, rate)
                for i in range(n):
                    total[i] += weights[stage] * rate[i]
            for i in range(n):
                s[i] += h / 6.0 * total[i]
        return rows

    return numba.njit(nogil=True, error_model="numpy")(loop)


def _seconds(work: Callable[[], object]) -> float:
    began = clock.perf_counter()
    work()
    return clock.perf_counter() - began
