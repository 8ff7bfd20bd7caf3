"""All timings together."""

from typing import Any

from ehamj.bench.case import benchmark_case
from ehamj.bench.mounts import cost_over_mounts
from ehamj.bench.steps import additions, step_times, thread_scaling
from ehamj.mujoco import hydraulics
from ehamj.run.timestep import choose_timestep
from ehamj.scenario.load import load_scenario


def bench(repetitions: int = 5) -> dict[str, Any]:
    """What the hydraulics, the recording, the engine and a controller cost: seconds per step, ratios, errors.

    See the keys' names for units.
    """
    scenario, sliding_scenario = load_scenario("benchmark"), load_scenario("recorded")
    with hydraulics():
        step = choose_timestep(scenario)
    times = {
        "tied": step_times(scenario.plant, step, repetitions),
        "sliding": step_times(sliding_scenario.plant, step, repetitions),
    }
    case = benchmark_case(scenario, step, repetitions)

    def over(name: str) -> dict[str, float]:
        return {plates: each["hydraulics"] / each[name] for plates, each in times.items()}

    return {
        "step_us": {plates: {name: 1e6 * value for name, value in each.items()} for plates, each in times.items()},
        "hydraulics_over_bare_engine": over("bare"),
        "hydraulics_over_bare_engine_without_timer": over("bare_without_timer"),
        "benchmark_case": case,
        "recorded_over_bare_engine": case["engine_us_per_step"] / (1e6 * times["tied"]["bare"]),
        "two_threads_over_one": thread_scaling(scenario, repetitions),
        "step_over_step_without": {"sliding": additions(sliding_scenario, repetitions)},
        "step_over_four_upright_mounts": {
            plates: cost_over_mounts(repetitions, plates) for plates in ("tied", "sliding")
        },
    }
