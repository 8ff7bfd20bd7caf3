"""One machine alone: the benchmark case on the engines and in bare loops, and what a step of the engine is made of."""

from collections.abc import Callable, Mapping
from typing import Any, Final

import mujoco
import numpy as np

from ehamj.arrays import Array
from ehamj.bench.ceiling import Ceiling
from ehamj.bench.parts import Effort, Figures, part
from ehamj.bench.reading import BARE, BARE_IS, HIGHER, LOWER, RATE, Table, crossed
from ehamj.bench.runs import Run, SideBySide, medians
from ehamj.mujoco import hydraulics
from ehamj.mujoco.equilibrium import Inputs, equilibrium
from ehamj.mujoco.hold import default_timer
from ehamj.mujoco.model import build_model
from ehamj.plant.plant import Plant
from ehamj.plots.timings import Bars, Panel
from ehamj.run.simulate import simulate
from ehamj.run.timestep import choose_timestep
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario

MUJOCO, SMALL = "MuJoCo engine", "small-motion engine"
"""How the figure calls them."""
FINER: Final = 24
"""Steps of the reference within one step that is timed: its error is then 3e-6 of the other's."""


def benchmark(effort: Effort) -> tuple[Scenario, float]:
    """The benchmark case, and its automatic step [s]."""
    scenario = load_scenario("benchmark", [f"duration={effort.duration(2.0)}"])
    with hydraulics():
        return scenario, choose_timestep(scenario)


def _panels(figures: Mapping[str, Any]) -> list[Panel]:
    case = figures["benchmark_case"]
    step = case["step_s"]
    small = case["small_motion"]
    rates = {
        BARE: step / (1e-6 * case["bare_loop_us_per_step"]),
        SMALL: small["simulated_s_per_wall_s"],
        MUJOCO: case["simulated_s_per_wall_s"],
    }
    errors = {BARE: case["ceiling_error"], SMALL: small["error"], MUJOCO: case["error"]}
    notes = {name: f"(error {error:.1e})" for name, error in errors.items()}
    return [Bars("Benchmark case, one machine", f"{RATE} ({HIGHER})", rates, notes)]


def _tables(figures: Mapping[str, Any]) -> list[Table]:
    steps, case = figures["step_us"], figures["benchmark_case"]
    names = {
        "bare": "the bare engine: MuJoCo without hydraulics",
        "bare_without_timer": "the bare engine, its profiling off",
        "hydraulics": "with the hydraulics",
    }
    of_step = Table.of(
        "What a step of the MuJoCo engine takes",
        f"A row is what takes a step, of a machine whose plates are tied to it or slide on it; {LOWER}.",
        "a step of",
        {f"{plates} [µs]": own for plates, own in steps.items()},
        names,
    )
    ratios = {
        "over": figures["hydraulics_over_bare_engine"],
        "without": figures["hydraulics_over_bare_engine_without_timer"],
        "recorded": {"tied": figures["recorded_over_bare_engine"]},
    }
    over = Table.of(
        "What the hydraulics add to a step",
        f"A row is a time of a step over that of the bare engine, MuJoCo without hydraulics (1: nothing); {LOWER}.",
        "time of a step over the bare engine's",
        {f"{plates} [-]": crossed(ratios, plates) for plates in steps},
        {
            "over": "with the hydraulics",
            "without": "with the hydraulics, the bare engine's profiling off",
            "recorded": "the benchmark case, rows recorded",
        },
    )
    who = {
        MUJOCO: case,
        SMALL: case["small_motion"],
        BARE: {"engine_us_per_step": case["bare_loop_us_per_step"], "error": case["ceiling_error"]},
        "ceiling": {"engine_us_per_step": case["ceiling_us_per_step"], "error": case["ceiling_error"]},
    }
    one = Table.of(
        f"The benchmark case, one machine, at steps of {1e3 * case['step_s']:.4g} ms",
        f"A row is who steps it; the bare scalar loop is {BARE_IS}. Rates: {HIGHER}; times per step and errors "
        f"(largest, over a channel's peak): {LOWER}.",
        "who steps",
        {
            "simulated\ns per s [-]": crossed(who, "simulated_s_per_wall_s"),
            "per step\n[µs]": crossed(who, "engine_us_per_step"),
            "rate over\nbare loop [-]": crossed(who, "rate_over_bare_loop"),
            "over\nceiling [-]": crossed(who, "rate_over_ceiling"),
            "over\nMuJoCo [-]": crossed(who, "rate_over_mujoco"),
            "error\n[-]": crossed(who, "error"),
        },
        {name: name for name in who},
    )
    return [of_step, over, one]


@part("engines", "one machine alone: the benchmark case, and what a step is made of", _panels, read=_tables)
def engines(effort: Effort) -> Figures:
    """What the hydraulics and the recording cost over the bare engine, and the engine over bare equations."""
    scenario, step = benchmark(effort)
    times = {
        "tied": step_times(scenario.plant, step, effort),
        "sliding": step_times(load_scenario("recorded").plant, step, effort),
    }
    case = benchmark_case(scenario, step, effort.repetitions)

    def over(name: str) -> dict[str, float]:
        return {plates: each["hydraulics"] / each[name] for plates, each in times.items()}

    return {
        "step_us": {plates: {name: 1e6 * value for name, value in each.items()} for plates, each in times.items()},
        "hydraulics_over_bare_engine": over("bare"),
        "hydraulics_over_bare_engine_without_timer": over("bare_without_timer"),
        "benchmark_case": case,
        "recorded_over_bare_engine": case["engine_us_per_step"] / (1e6 * times["tied"]["bare"]),
    }


def benchmark_case(scenario: Scenario, step: float, repetitions: int) -> Figures:
    """The benchmark case recorded at 1 kHz, against the same equations in bare compiled RK4 at the same step.

    The ceiling is what it always was, with the set-up of its model, which takes as long as half of its steps; the bare
    loop is its steps alone.
    """
    steps, every = round(scenario.duration / step), round(1.0 / (scenario.record_rate * step))
    ceiling, small = Ceiling(scenario, step), scenario.model_copy(update={"engine": "small-motion"})
    works: dict[str, Callable[[], object]] = {
        "engine": Run(scenario, step, steps, every),
        "small_motion": SideBySide([small]),
        "ceiling": lambda: Ceiling(scenario, step)(),
        "bare_loop": ceiling,
    }
    times = medians(works, repetitions)
    seconds = times["small_motion"]
    reference = Ceiling(scenario, step / FINER).channels()
    return {
        "step_s": step,
        "simulated_s_per_wall_s": scenario.duration / times["engine"],
        "engine_us_per_step": 1e6 * times["engine"] / steps,
        "ceiling_us_per_step": 1e6 * times["ceiling"] / steps,
        "rate_over_ceiling": times["ceiling"] / times["engine"],
        "bare_loop_us_per_step": 1e6 * times["bare_loop"] / steps,
        "rate_over_bare_loop": times["bare_loop"] / times["engine"],
        "error": deviation(channels(simulate(scenario)), reference),
        "small_motion": {
            "simulated_s_per_wall_s": scenario.duration / seconds,
            "engine_us_per_step": 1e6 * seconds / steps,
            "rate_over_ceiling": times["ceiling"] / seconds,
            "rate_over_bare_loop": times["bare_loop"] / seconds,
            "rate_over_mujoco": times["engine"] / seconds,
            "error": deviation(channels(simulate(small)), reference),
        },
        "ceiling_error": deviation(ceiling.channels(), reference),
    }


def channels(result: Any) -> Array:
    """The compared channels of a result: x, y, z, rx, ry and the load pressures, (n, 5 + mount)."""
    motion = result.dataset["machine_displacement"].values[:, :5]
    pressure = result.dataset["chamber_pressure"].values
    return np.hstack([motion, pressure[:, :, 0] - pressure[:, :, 1]])


def deviation(found: Array, reference: Array) -> float:
    """Largest deviation over time, over that channel's peak, worst channel."""
    return float((np.abs(found - reference).max(axis=0) / np.abs(reference).max(axis=0)).max())


def step_times(plant: Plant, timestep: float, effort: Effort) -> dict[str, float]:
    """Seconds per step: the bare engine as shipped and without its profiling timer, and with the hydraulics."""
    model, steps = build_model(plant, timestep), effort.steps(3000)
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
    return {name: each / steps for name, each in medians(works, 3 * effort.repetitions).items()}
