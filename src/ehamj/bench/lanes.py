"""Many machines of one structure: side by side in lanes, and on two threads."""

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, Final

import numpy as np

from ehamj.bench.ceiling import Ceiling
from ehamj.bench.engines import benchmark
from ehamj.bench.lane_ceiling import LaneCeiling
from ehamj.bench.parts import Effort, Figures, part
from ehamj.bench.runs import Run, interleaved, medians
from ehamj.plots.charts import Line
from ehamj.plots.timings import Lines, Panel
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario

COUNTS: Final = (1, 4, 8, 16, 32)
SPREAD: Final = 0.02
"""Of the machines' masses, over the first's, so that none is another's copy."""


def _panels(figures: Mapping[str, Any]) -> list[Panel]:
    rates = figures["lanes"]["rate_over_bare_loop"]
    lines = [
        Line(name, [float(count) for count in each], list(each.values()), color, marker="os"[color])
        for color, (name, each) in enumerate(rates.items())
    ]
    return [Lines("Benchmark case, many machines on one core", "machines", "rate over bare scalar loop", lines)]


@part("lanes", "many machines of one structure, side by side in lanes and on two threads", _panels)
def lanes(effort: Effort) -> Figures:
    """Times per machine and step, rates over the bare scalar loop, and what a second thread brings."""
    scenario, step = benchmark(effort)
    return {"lanes": side_by_side(scenario, step, effort), "two_threads_over_one": thread_scaling(scenario, effort)}


def machines(number: int, duration: float) -> list[Scenario]:
    """The benchmark's machine with so many masses."""
    masses = np.linspace(4056.0, 4056.0 * (1.0 + SPREAD), number)
    return [load_scenario("benchmark", [f"duration={duration}", f"machine.mass={mass!r}"]) for mass in masses.tolist()]


def side_by_side(scenario: Scenario, step: float, effort: Effort) -> Figures:
    """By number of machines on one core."""
    many = machines(COUNTS[-1], scenario.duration)
    works: dict[str, Callable[[], object]] = {
        "ceiling": lambda: Ceiling(scenario, step)(),
        "bare_loop": Ceiling(scenario, step),
    }
    works |= {f"{count}": LaneCeiling(many[:count], step) for count in COUNTS}
    times = medians(works, effort.repetitions)
    steps = round(scenario.duration / step)
    each = {count: times[f"{count}"] / count for count in COUNTS}
    return {
        "us_per_machine_and_step": {"bare": {str(count): 1e6 * one / steps for count, one in each.items()}},
        **{
            f"rate_over_{name}": {"bare": {str(count): times[name] / one for count, one in each.items()}}
            for name in ("ceiling", "bare_loop")
        },
    }


def thread_scaling(scenario: Scenario, effort: Effort, batch: int = 8) -> float:
    """Rate of two threads over one in a batch of simulations."""
    step = 1.0 / 3000.0
    steps = round(scenario.duration / step)
    run = Run(scenario, step, steps, every=steps)
    with ThreadPoolExecutor(1) as single, ThreadPoolExecutor(2) as double:

        def spread(pool: ThreadPoolExecutor) -> None:
            list(pool.map(lambda _: run(), range(batch)))

        times = interleaved({"alone": partial(spread, single), "both": partial(spread, double)}, effort.repetitions)
    return float(np.median(times["alone"] / times["both"]))
