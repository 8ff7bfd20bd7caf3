"""A step of the bare engine, and with the hydraulics."""

import mujoco
import numpy as np

from ehamj.bench.clock import interleaved
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import Inputs, equilibrium
from ehamj.mujoco.hold import default_timer
from ehamj.mujoco.model import build_model
from ehamj.plant.plant import Plant


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
