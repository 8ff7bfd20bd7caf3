"""The benchmark case in the best peer, beside ehamj and the bare loop, at the same step."""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from ehamj.bench.ceiling import Ceiling
from ehamj.bench.engines import BARE, FINER, MUJOCO, SMALL, benchmark, channels, deviation
from ehamj.bench.exudyn_case import ExudynCase
from ehamj.bench.parts import Effort, Figures, part
from ehamj.bench.runs import Run, SideBySide, medians
from ehamj.errors import InputError
from ehamj.plots.timings import Bars, Panel
from ehamj.run.simulate import simulate


def _panels(figures: Mapping[str, Any]) -> list[Panel]:
    peer = figures["peer"]
    rates, errors = peer["simulated_s_per_wall_s"], peer["error"]
    notes = {name: f"(error {error:.1e})" for name, error in errors.items()}
    return [Bars("Benchmark case, with the best peer", "simulated seconds per second", rates, notes)]


def check_peer() -> Any:
    """The peer's package.

    Raises:
        InputError: if it is not installed.
    """
    try:
        return import_module("exudyn")
    except ImportError as error:
        raise InputError(f"peer: needs Exudyn, which is not installed ({error}): pip install 'ehamj[peer]'") from None


@part("peer", "the benchmark case in Exudyn, where it is installed", _panels, asked=True, check=check_peer)
def peer(effort: Effort) -> Figures:
    """Rates and errors of peer, engine and bare loop."""
    exudyn = check_peer()
    scenario, step = benchmark(effort)
    steps, every = round(scenario.duration / step), round(1.0 / (scenario.record_rate * step))
    case, ceiling = ExudynCase(exudyn, scenario, step), Ceiling(scenario, step)
    small = scenario.model_copy(update={"engine": "small-motion"})
    works: dict[str, Callable[[], object]] = {
        BARE: ceiling,
        SMALL: SideBySide([small]),
        MUJOCO: Run(scenario, step, steps, every),
        "Exudyn": case,
    }
    times = medians(works, effort.repetitions)
    found = {
        BARE: ceiling.channels(),
        SMALL: channels(simulate(small)),
        MUJOCO: channels(simulate(scenario)),
        "Exudyn": case.channels(),
    }
    reference = Ceiling(scenario, step / FINER).channels()
    return {
        "peer": {
            "step_s": step,
            "simulated_s_per_wall_s": {name: scenario.duration / seconds for name, seconds in times.items()},
            "rate_over_exudyn": {name: times["Exudyn"] / seconds for name, seconds in times.items()},
            "error": {name: deviation(each, reference) for name, each in found.items()},
        }
    }
