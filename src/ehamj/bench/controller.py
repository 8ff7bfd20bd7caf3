"""Under control: a shipped scenario, and what linearised valves, a large law, sensors and a force add to a step."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final

import numpy as np

from ehamj.bench.parts import Effort, Figures, part
from ehamj.bench.reading import HIGHER, LOWER, RATE, Table
from ehamj.bench.runs import Run, SideBySide, Stepping, interleaved, medians
from ehamj.control import Controller
from ehamj.control.loop import make_loop
from ehamj.control.sensors import Sensors
from ehamj.plots.timings import Bars, Panel
from ehamj.run.drive import sample_load
from ehamj.run.side_by_side import LANES
from ehamj.scenario.load import load_scenario, parse_scenario
from ehamj.scenario.model import Scenario

SCENARIO: Final = "vc-c-floor"
SLIDING: Final = "MuJoCo engine, sliding plates"
SMALL: Final = "small-motion engine"
STATES, INPUTS = 80, 24
"""Size of the large law, at 10 kHz."""


def _panels(figures: Mapping[str, Any]) -> list[Panel]:
    rates = figures["controlled"]["simulated_s_per_wall_s"]
    return [Bars(f"{SCENARIO}, stepping under control, per machine", f"{RATE} ({HIGHER})", rates, {})]


def _tables(figures: Mapping[str, Any]) -> list[Table]:
    found, added = figures["controlled"], figures["step_over_step_without"]
    rates = found["simulated_s_per_wall_s"]
    return [
        Table.of(
            f"{SCENARIO}, stepping under control",
            f"A row is an engine as it steps; in lanes the rate is that per machine; {HIGHER}.",
            "engine",
            {"simulated\ns per s [-]": rates, "rate over MuJoCo,\nsliding plates [-]": found["rate_over_sliding"]},
            {name: name for name in rates},
        ),
        Table.of(
            f"What the linearisation of its valves adds to {SCENARIO}",
            "A row is an engine; the time of a step with the stage and the sensors that it reads, over that of a step "
            f"under the same law without (1: none), in turn; {LOWER}.",
            "engine",
            {"with over without [-]": figures["linearised_over_without"]},
            {name: name for name in figures["linearised_over_without"]},
        ),
        Table.of(
            "What is added to a step of the MuJoCo engine",
            "A row is what a step has in addition, a sample in each; its time over that of a step without (1: none); "
            f"{LOWER}.",
            "with",
            {f"{plates} plates [-]": own for plates, own in added.items()},
            {
                "controller": f"a law of {STATES} states and {INPUTS} inputs",
                "controller_and_sensors": "the law and its sensors",
                "force": "a force",
            },
        ),
    ]


@part(
    "controller",
    f"{SCENARIO} under control; what linearisation, a large law, sensors and a force add to a step",
    _panels,
    read=_tables,
)
def controller(effort: Effort) -> Figures:
    """Stepping under control, with sliding and with tied plates, and what is added to a step."""
    return {
        "controlled": controlled(effort),
        "linearised_over_without": linearised(effort),
        "step_over_step_without": {"sliding": additions(load_scenario("recorded"), effort)},
    }


def controlled(effort: Effort) -> Figures:
    """Stepping of the scenario: on the MuJoCo engine by its plates, on the small-motion one alone and in lanes."""
    duration = effort.duration(0.5)
    sliding, tied, small = (
        load_scenario(SCENARIO, [f"duration={duration}", "compare=[]", key])
        for key in ("plates=sliding", "plates=tied", "engine=small-motion")
    )
    works: dict[str, Callable[[], object]] = {
        SLIDING: Stepping(sliding),
        "MuJoCo engine, tied plates": Stepping(tied),
        SMALL: SideBySide([small]),
    }
    law, beside = small.controller(), f"{SMALL}, {LANES} lanes"
    works[beside] = SideBySide([small.model_copy(update={"seed": seed}) for seed in range(LANES)], law)
    times = medians(works, effort.repetitions)
    rates = {name: duration / seconds for name, seconds in times.items()}
    rates[beside] *= LANES
    return {
        "simulated_s_per_wall_s": rates,
        "rate_over_sliding": {name: rate / rates[SLIDING] for name, rate in rates.items()},
    }


def linearised(effort: Effort) -> dict[str, float]:
    """Time of a step of the scenario with the stage that linearises its valves over that without, by engine."""
    base = [f"duration={effort.duration(0.4)}", "compare=[]"]
    found = {}
    for name, keys in {SLIDING: ["plates=sliding"], SMALL: ["engine=small-motion"]}.items():
        plain, staged = (
            load_scenario(SCENARIO, [*base, *keys, f"control.linearisation={on}"]) for on in ("false", "true")
        )
        works: dict[str, Callable[[], object]] = (
            {"plain": SideBySide([plain]), "staged": SideBySide([staged])}
            if name == SMALL
            else {"plain": Stepping(plain), "staged": Stepping(staged)}
        )
        times = interleaved(works, 2 * effort.repetitions)
        found[name] = float(np.median(times["staged"] / times["plain"]))
    return found


def additions(scenario: Scenario, effort: Effort) -> dict[str, float]:
    """Time of a step with a large controller, with its sensors too, and with a force, over a step without any.

    Each at 10 kHz with one step per sample, so that the controller weighs most.
    """
    plant, step, steps = scenario.plant, 1e-4, effort.steps(4000)
    law = large_law(plant.mounts)
    table = {"ground": {"kind": "geophone"}, "inertial": {"kind": "geophone"}, "stroke": {}, "pressure": {}}
    pushed = parse_scenario({"force": [{"kind": "sine", "amplitude": 1.0, "frequency": 20.0}]}).load()
    run = Run(scenario, step, steps)
    works: dict[str, Callable[[], object]] = {
        "nothing": run,
        "controller": partial(run, make_loop(law, plant, step)),
        "controller_and_sensors": partial(run, make_loop(law, plant, step, Sensors.model_validate(table))),
        "force": partial(run, load=sample_load(pushed, 0, steps + 1, step)),
    }
    times = interleaved(works, 2 * effort.repetitions)
    plain = times.pop("nothing")
    return {name: float(np.median(each / plain)) for name, each in times.items()}


def large_law(mounts: tuple[str, ...], states: int = STATES) -> Controller:
    """A law of many states that hardly commands anything, with anti-windup."""
    draw = np.random.default_rng(0).normal
    names = [f"{what} {mount} z" for what in ("ground_velocity", "foot_velocity") for mount in mounts]
    names += [f"{what} {mount}" for what in ("stroke", "load_pressure") for mount in mounts]
    names += [f"foot_velocity {mount} {axis}" for mount in mounts for axis in "xy"]
    n, p, valves = states, INPUTS, len(mounts)
    A = draw(size=(n, n))
    A *= 0.9 / np.abs(np.linalg.eigvals(A)).max()
    B, C, D = 1e-9 * draw(size=(n, p)), 1e-6 * draw(size=(valves, n)), np.zeros((valves, p))
    return Controller(A, B, C, D, tuple(names[:INPUTS])).with_anti_windup()
