"""What a step costs: of the bare engine, with the hydraulics, on two threads, with a controller, sensors, a force."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import mujoco
import numpy as np

from ehamj.bench.runs import Run, interleaved
from ehamj.control import Controller
from ehamj.control.loop import make_loop
from ehamj.control.sensors import Sensors
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import Inputs, equilibrium
from ehamj.mujoco.hold import default_timer
from ehamj.mujoco.model import build_model
from ehamj.plant.plant import Plant
from ehamj.run.drive import sample_load
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

STATES, INPUTS = 80, 24
"""Size of the controller that is timed, at 10 kHz."""


def step_times(plant: Plant, timestep: float, repetitions: int, steps: int = 3000) -> dict[str, float]:
    """Seconds per step: the bare engine as shipped and without its profiling timer, and with the hydraulics."""
    model = build_model(plant, timestep)
    still, moved = mujoco.MjData(model), mujoco.MjData(model)
    still.qvel[:] = moved.qvel[:] = 1e-6
    with hydraulics():
        equilibrium(model, moved, Inputs.rest(model))

    def bare() -> None:
        mujoco.mj_step(model, still, nstep=steps)

    def bare_without_timer() -> None:
        with default_timer(off=True):
            bare()

    def with_hydraulics() -> None:
        with hydraulics():
            mujoco.mj_step(model, moved, nstep=steps)

    works = {"bare": bare, "bare_without_timer": bare_without_timer, "hydraulics": with_hydraulics}
    return {name: float(np.median(each)) / steps for name, each in interleaved(works, 3 * repetitions).items()}


def thread_scaling(scenario: Scenario, repetitions: int, batch: int = 8) -> float:
    """Rate of two threads over one in a batch of simulations."""
    step = 1.0 / 3000.0
    steps = round(scenario.duration / step)
    run = Run(scenario, step, steps, every=steps)
    with ThreadPoolExecutor(1) as single, ThreadPoolExecutor(2) as double:

        def spread(pool: ThreadPoolExecutor) -> None:
            list(pool.map(lambda _: run(), range(batch)))

        times = interleaved({"alone": partial(spread, single), "both": partial(spread, double)}, repetitions)
    return float(np.median(times["alone"] / times["both"]))


def additions(scenario: Scenario, repetitions: int, steps: int = 4000) -> dict[str, float]:
    """Time of a step with a large controller, with its sensors too, and with a force, over a step without any.

    Each at 10 kHz with one step per sample, so that the controller weighs most.
    """
    plant, step = scenario.plant, 1e-4
    controller = large_controller(plant.mounts)
    table = {"ground": {"kind": "geophone"}, "inertial": {"kind": "geophone"}, "stroke": {}, "pressure": {}}
    pushed = parse_scenario({"force": [{"kind": "sine", "amplitude": 1.0, "frequency": 20.0}]}).load()
    run = Run(scenario, step, steps)
    works: dict[str, Callable[[], object]] = {
        "nothing": run,
        "controller": partial(run, make_loop(controller, plant, step)),
        "controller_and_sensors": partial(run, make_loop(controller, plant, step, Sensors.model_validate(table))),
        "force": partial(run, load=sample_load(pushed, 0, steps + 1, step)),
    }
    times = interleaved(works, 2 * repetitions)
    plain = times.pop("nothing")
    return {name: float(np.median(each / plain)) for name, each in times.items()}


def large_controller(mounts: tuple[str, ...]) -> Controller:
    """A law of many states that hardly commands anything, with anti-windup."""
    draw = np.random.default_rng(0).normal
    names = [f"{what} {mount} z" for what in ("ground_velocity", "foot_velocity") for mount in mounts]
    names += [f"{what} {mount}" for what in ("stroke", "load_pressure") for mount in mounts]
    names += [f"foot_velocity {mount} {axis}" for mount in mounts for axis in "xy"]
    n, p, valves = STATES, INPUTS, len(mounts)
    A = draw(size=(n, n))
    A *= 0.9 / np.abs(np.linalg.eigvals(A)).max()
    B, C, D = 1e-9 * draw(size=(n, p)), 1e-6 * draw(size=(valves, n)), np.zeros((valves, p))
    return Controller(A, B, C, D, tuple(names[:INPUTS])).with_anti_windup()
