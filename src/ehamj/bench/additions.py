"""What a controller, its sensors and a force add to a step."""

from functools import partial

import mujoco
import numpy as np

from ehamj.bench.clock import interleaved
from ehamj.control import Controller
from ehamj.control.loop import make_loop, no_loop
from ehamj.control.sensors import Sensors
from ehamj.mujoco import hydraulics
from ehamj.mujoco.advance import NOT_LOADED, advance
from ehamj.mujoco.equilibrium import Inputs, equilibrium
from ehamj.mujoco.model import build_model
from ehamj.mujoco.rows import Recording
from ehamj.run.drive import sample_inputs, sample_load
from ehamj.scenario.load import parse_scenario
from ehamj.scenario.model import Scenario

STATES, INPUTS = 80, 24
"""Size of the controller that is timed, at 10 kHz."""


def additions(scenario: Scenario, repetitions: int, steps: int = 4000) -> dict[str, float]:
    """Time of a step with a large controller, with its sensors too, and with a force, over a step without any.

    Each at 10 kHz with one step per sample, so that the controller weighs most.
    """
    step = 1e-4
    plant = scenario.plant
    controller = large_controller(plant.mounts)
    table = {"ground": {"kind": "geophone"}, "inertial": {"kind": "geophone"}, "stroke": {}, "pressure": {}}
    loops = {
        "nothing": no_loop(len(plant.mounts)),
        "controller": make_loop(controller, plant, step),
        "controller_and_sensors": make_loop(controller, plant, step, Sensors.model_validate(table)),
        "force": no_loop(len(plant.mounts)),
    }
    pushed = parse_scenario({"force": [{"kind": "sine", "amplitude": 1.0, "frequency": 20.0}]}).load()
    forces = dict.fromkeys(loops, NOT_LOADED) | {"force": sample_load(pushed, 0, steps, step)}
    model = build_model(plant, step)
    inputs = sample_inputs(scenario.motion(), scenario.commands(), 0, steps, step)
    with hydraulics():
        start = mujoco.MjData(model)
        equilibrium(model, start, Inputs.rest(model))

        def one(name: str) -> None:
            data, loop = mujoco.MjData(model), loops[name]
            data.qpos[:], data.act[:] = start.qpos, start.act
            noise = np.zeros((loop.samples(0, steps)[1], loop.sensing.channels))
            recording = Recording.of(model, loop, 10, steps // 10 + 1)
            advance(model, data, 0, steps, inputs, recording, False, loop, noise, forces[name])

        times = interleaved({name: partial(one, name) for name in loops}, 2 * repetitions)
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
