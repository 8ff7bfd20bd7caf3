"""How much faster a batch of simulations runs on two threads."""

from concurrent.futures import ThreadPoolExecutor

import mujoco
import numpy as np

from ehamj.bench.clock import interleaved
from ehamj.control.loop import no_loop
from ehamj.memory import activations
from ehamj.mujoco import hydraulics
from ehamj.mujoco.advance import advance
from ehamj.mujoco.model import build_model
from ehamj.mujoco.rows import Recording
from ehamj.run.drive import sample_inputs
from ehamj.scenario.model import Scenario


def thread_scaling(scenario: Scenario, repetitions: int, batch: int = 8) -> float:
    """Rate of two threads over one in a batch of simulations."""
    step = 1.0 / 3000.0
    steps = round(scenario.duration / step)
    model = build_model(scenario.plant, step)
    inputs = sample_inputs(scenario.motion(), scenario.commands(), 0, steps, step)

    def one(_: int) -> None:
        data, loop = mujoco.MjData(model), no_loop(len(scenario.plant.mounts))
        states = activations(model, data.act).isolators
        states["pressure_1"] = states["pressure_2"] = scenario.supply.pressure / 2
        advance(model, data, 0, steps, inputs, Recording.of(model, loop, steps, 1), loop=loop)

    with hydraulics(), ThreadPoolExecutor(1) as single, ThreadPoolExecutor(2) as double:
        pools = {
            "alone": lambda: list(single.map(one, range(batch))),
            "both": lambda: list(double.map(one, range(batch))),
        }
        times = interleaved(pools, repetitions)
    return float(np.median(times["alone"] / times["both"]))
