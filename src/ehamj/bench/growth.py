"""How cost grows: with duration, rows, mounts, states of the law."""

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final

from ehamj.bench.controller import large_law
from ehamj.bench.parts import Effort, Figures, part
from ehamj.bench.runs import Run, Stepping, medians
from ehamj.control.loop import make_loop
from ehamj.plots.charts import Line
from ehamj.plots.timings import Lines, Panel
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import Scenario

MOUNTS: Final = (3, 4, 8, 16, 32)
TILT: Final = 0.6
"""How far a skew mount is tilted: horizontal over vertical part of its direction [-]."""
DURATIONS: Final = (1, 2, 4, 8)
"""Over the shortest."""
ROW_RATES: Final = (100, 200, 1000, 5000)
"""[Hz]"""
STATES: Final = (10, 20, 40, 80, 160)
STEP: Final = 1e-4
"""Step of what is not timed at its own [s]."""


def _panels(figures: Mapping[str, Any]) -> list[Panel]:
    found = figures["growth"] | {"mounts": figures["step_over_four_upright_mounts"]["tied"]["upright"]}
    said = {"duration": "duration", "rows": "rows per second", "law_states": "states of the law", "mounts": "mounts"}
    lines = []
    for color, (key, name) in enumerate(said.items()):
        sizes, times = [float(size) for size in found[key]], list(found[key].values())
        x, y = [size / sizes[0] for size in sizes], [each / times[0] for each in times]
        lines.append(Line(name, x, y, color, marker="o^sD"[color]))
    return [Lines("How cost grows, MuJoCo engine", "size, over the smallest", "time, over the smallest's", lines)]


@part("growth", "how cost grows with duration, rows, mounts and states of the law", _panels)
def growth(effort: Effort) -> Figures:
    """Times over the least, by what grows."""
    return {
        "growth": {
            "duration": over_duration(effort),
            "rows": over_rows(effort),
            "law_states": over_states(effort),
        },
        "step_over_four_upright_mounts": {plates: over_mounts(effort, plates) for plates in ("tied", "sliding")},
    }


def _over_first(works: Mapping[int, Callable[[], object]], effort: Effort) -> dict[str, float]:
    times = medians({str(size): work for size, work in works.items()}, effort.repetitions)
    first = next(iter(times.values()))
    return {size: seconds / first for size, seconds in times.items()}


def over_duration(effort: Effort) -> dict[str, float]:
    """Time of stepping the benchmark case over that of the shortest duration, by duration over the shortest."""
    least = effort.duration(0.25)
    runs = {times: Stepping(load_scenario("benchmark", [f"duration={times * least}"])) for times in DURATIONS}
    return _over_first(runs, effort)


def over_rows(effort: Effort) -> dict[str, float]:
    """Time of a step of the benchmark case over that with the fewest rows, by rows per second [Hz]."""
    scenario, steps = load_scenario("benchmark"), effort.steps(3000)
    return _over_first({rate: Run(scenario, STEP, steps, round(1.0 / (rate * STEP))) for rate in ROW_RATES}, effort)


def over_states(effort: Effort) -> dict[str, float]:
    """Time of a step under a dense law at 10 kHz over that with the fewest states, by number of states."""
    scenario = load_scenario("recorded")
    run = Run(scenario, STEP, effort.steps(2000))
    laws = {states: make_loop(large_law(scenario.plant.mounts, states), scenario.plant, STEP) for states in STATES}
    return _over_first({states: partial(run, loop) for states, loop in laws.items()}, effort)


def over_mounts(effort: Effort, plates: str = "tied") -> dict[str, dict[str, float]]:
    """Time of a step over that of four upright mounts, by layout and number of mounts; ground moves, rows are kept."""
    runs: dict[str, Run] = {}
    for layout in ("upright", "skew"):
        for mounts in MOUNTS:
            runs[f"{layout} {mounts}"] = Run(standing(mounts, layout == "skew", plates), STEP, effort.steps(2000))
    times = medians(runs, effort.repetitions)
    four = times["upright 4"]
    return {
        layout: {str(mounts): times[f"{layout} {mounts}"] / four for mounts in MOUNTS} for layout in ("upright", "skew")
    }


def standing(mounts: int, skew: bool, plates: str) -> Scenario:
    """The default machine on so many isolators in a circle; skew ones lean inwards, half of them 0.3 m higher."""
    table: list[dict[str, Any]] = []
    for k in range(mounts):
        x, y = math.cos(2 * math.pi * k / mounts), math.sin(2 * math.pi * k / mounts)
        place = {"position": [0.75 * x, 0.75 * y]}
        if skew:
            place = {"position": [0.75 * x, 0.75 * y, 0.3 * (k % 2)], "direction": [-TILT * x, -TILT * y, 1.0]}
        table.append({"name": f"m{k + 1}", **place})
    return parse_scenario({"mount": table, "plates": plates})
