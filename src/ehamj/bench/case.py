"""The benchmark case by the engine with its callbacks, against the same equations without any multibody engine."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ehamj.bench.ceiling import Array, ceiling
from ehamj.bench.runs import Run, interleaved
from ehamj.run.simulate import simulate
from ehamj.scenario.model import Scenario


def benchmark_case(scenario: Scenario, step: float, repetitions: int) -> dict[str, float]:
    """The benchmark case recorded at 1 kHz, against the same equations in bare compiled RK4 at the same step."""
    steps, every = round(scenario.duration / step), round(1.0 / (scenario.record_rate * step))
    works: dict[str, Callable[[], object]] = {
        "engine": Run(scenario, step, steps, every),
        "ceiling": lambda: ceiling(scenario, step),
    }
    engine_time, ceiling_time = (float(np.median(each)) for each in interleaved(works, repetitions).values())
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


def channels(result: Any) -> Array:
    """The compared channels of a result as of `ceiling`: x, y, z, rx, ry and the load pressures, (n, 5 + mount)."""
    motion = result.dataset["machine_displacement"].values[:, :5]
    pressure = result.dataset["chamber_pressure"].values
    return np.hstack([motion, pressure[:, :, 0] - pressure[:, :, 1]])


def deviation(found: Array, reference: Array) -> float:
    """Largest deviation over time, over that channel's peak, worst channel."""
    return float((np.abs(found - reference).max(axis=0) / np.abs(reference).max(axis=0)).max())
