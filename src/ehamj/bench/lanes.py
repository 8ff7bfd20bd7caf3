"""Many machines of one structure: side by side in lanes, and on two threads."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, Final

import numpy as np

from ehamj.bench.ceiling import Ceiling
from ehamj.bench.engines import MUJOCO, SMALL, benchmark
from ehamj.bench.lane_ceiling import LaneCeiling
from ehamj.bench.parts import Effort, Figures, part
from ehamj.bench.reading import BARE, BARE_IS, HIGHER, LOWER, Table
from ehamj.bench.runs import Run, SideBySide, interleaved, medians
from ehamj.plots.charts import Line
from ehamj.plots.timings import Lines, Panel
from ehamj.run.many import observe_many
from ehamj.run.side_by_side import LANES
from ehamj.run.simulate import Observed
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario

COUNTS: Final = (1, 4, 8, 16, 32)
SPREAD: Final = 0.02
"""Of the machines' masses, over the first's, so that none is another's copy."""


def _panels(figures: Mapping[str, Any]) -> list[Panel]:
    rates = figures["lanes"]["rate_over_bare_loop"]
    lines = [
        Line(f"{who} in lanes", COUNTS, list(rates[key].values()), color, marker=marker)
        for key, who, color, marker in (("bare", "bare loop", 4, "v"), ("small-motion", SMALL, 5, "P"))
    ]
    return [
        Lines("Benchmark case, many machines on one core", "machines", f"rate over {BARE} ({HIGHER})", lines, COUNTS)
    ]


def _tables(figures: Mapping[str, Any]) -> list[Table]:
    found, names = figures["lanes"], {"bare": "bare loop in lanes", "small-motion": f"{SMALL} in lanes"}
    many = "A row is who steps, a column how many different machines are stepped together on one core"

    def table(key: str, title: str, words: str, unit: str) -> Table:
        counts = {f"{count} [{unit}]": str(count) for count in COUNTS}
        columns = {head: {who: own[count] for who, own in found[key].items()} for head, count in counts.items()}
        return Table.of(title, f"{many}; {words}.", "machines", columns, names)

    threads = {
        MUJOCO: figures["two_threads_over_one"],
        f"{SMALL}, {LANES} lanes, steps and inputs": figures["small_motion_two_threads_over_one"],
        f"{SMALL}, {LANES} lanes, whole runs": figures["small_motion_runs_two_threads_over_one"],
    }
    return [
        table("us_per_machine_and_step", "Time per machine and step", LOWER, "µs"),
        table("rate_over_bare_loop", f"Rate per machine over the {BARE}", f"the loop is {BARE_IS}; {HIGHER}", "-"),
        table("rate_over_ceiling", "Rate per machine over the ceiling", HIGHER, "-"),
        Table.of(
            "Two threads",
            "A row is an engine; its rate on two threads over that on one (at most 2). Whole runs are those of "
            f"`simulate_many`, from scenarios to channels, which are not judged; {HIGHER}.",
            "engine",
            {"rate over one thread [-]": threads},
            {name: name for name in threads},
        ),
    ]


@part("lanes", "many machines of one structure, side by side in lanes and on two threads", _panels, read=_tables)
def lanes(effort: Effort) -> Figures:
    """Times per machine and step, rates over the bare scalar loop, and what a second thread brings."""
    scenario, step = benchmark(effort)
    alone = Run(scenario, step, steps := round(scenario.duration / step), every=steps)
    block = SideBySide(machines(LANES, scenario.duration, "small-motion"))
    many = machines(2 * LANES, scenario.duration, "small-motion")
    return {
        "lanes": side_by_side(scenario, step, effort),
        "two_threads_over_one": thread_scaling(alone, effort),
        "small_motion_two_threads_over_one": thread_scaling(block, effort),
        "small_motion_runs_two_threads_over_one": whole_runs(many, effort),
    }


def machines(number: int, duration: float, engine: str = "mujoco") -> list[Scenario]:
    """The benchmark's machine with so many masses."""
    masses = np.linspace(4056.0, 4056.0 * (1.0 + SPREAD), number)
    given = [f"duration={duration}", f"engine={engine}"]
    return [load_scenario("benchmark", [*given, f"machine.mass={mass!r}"]) for mass in masses.tolist()]


def side_by_side(scenario: Scenario, step: float, effort: Effort) -> Figures:
    """By number of machines on one core."""
    many = machines(COUNTS[-1], scenario.duration)
    works: dict[str, Callable[[], object]] = {
        "ceiling": lambda: Ceiling(scenario, step)(),
        "bare_loop": Ceiling(scenario, step),
    }
    small = machines(COUNTS[-1], scenario.duration, "small-motion")
    for count in COUNTS:
        works[f"bare {count}"] = LaneCeiling(many[:count], step)
        works[f"small-motion {count}"] = SideBySide(small[:count])
    times = medians(works, effort.repetitions)
    steps = round(scenario.duration / step)
    each = {who: {str(count): times[f"{who} {count}"] / count for count in COUNTS} for who in ("bare", "small-motion")}

    def rates(over: str) -> Figures:
        return {who: {count: times[over] / one for count, one in own.items()} for who, own in each.items()}

    return {
        "us_per_machine_and_step": {
            who: {count: 1e6 * one / steps for count, one in own.items()} for who, own in each.items()
        },
        "rate_over_ceiling": rates("ceiling"),
        "rate_over_bare_loop": rates("bare_loop"),
    }


def whole_runs(scenarios: Sequence[Scenario], effort: Effort) -> float:
    """Rate of two threads over one of all that many runs take until there are channels: preparation too."""
    works = {str(threads): partial(observe_many, scenarios, _forgotten, threads) for threads in (1, 2)}
    times = interleaved(works, effort.repetitions)
    return float(np.median(times["1"] / times["2"]))


def _forgotten(run: Observed) -> None:
    """What is kept of a run."""


def thread_scaling(run: Callable[[], object], effort: Effort, batch: int = 8) -> float:
    """Rate of two threads over one in a batch of runs."""
    with ThreadPoolExecutor(1) as single, ThreadPoolExecutor(2) as double:

        def spread(pool: ThreadPoolExecutor) -> None:
            list(pool.map(lambda _: run(), range(batch)))

        times = interleaved({"alone": partial(spread, single), "both": partial(spread, double)}, effort.repetitions)
    return float(np.median(times["alone"] / times["both"]))
