"""Designs' runs as studies take them, over the same runs of `simulate_many` with their whole summaries."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, Final

from ehamj.bench.parts import Effort, Figures, part
from ehamj.bench.reading import HIGHER, Table
from ehamj.bench.runs import medians
from ehamj.merits.applied import scenario_of
from ehamj.merits.merit import Design, Failed, Machine
from ehamj.merits.run import Runs
from ehamj.plots.timings import Bars, Panel
from ehamj.result import Result
from ehamj.run.many import simulate_many
from ehamj.run.side_by_side import LANES
from ehamj.scenario.load import load_scenario

SCENARIO: Final = "vc-c-floor"
THREADS: Final = 2
MERITS: Final = (
    "run.attenuation_db.z.20",
    "run.attenuation_db.z.50",
    "run.saturation.command.front-left",
    "run.oil.mean_power_w",
    "run.rms.valve_command.front-left",
)
"""Figures that are wanted of each design."""
MUJOCO, SMALL = "simulate_many, MuJoCo engine", "simulate_many, small-motion engine"
STUDY: Final = f"merits of runs, {LANES} lanes"


def _panels(figures: Mapping[str, Any]) -> list[Panel]:
    found = figures["studies"]
    axis = f"runs of {found['simulated_s']:g} s per second ({HIGHER})"
    return [Bars(f"{SCENARIO}, tied plates, designs of a study", axis, found["runs_per_s"], {})]


def _tables(figures: Mapping[str, Any]) -> list[Table]:
    found = figures["studies"]
    columns = {
        "time of a run\n[s]": {name: 1.0 / rate for name, rate in found["runs_per_s"].items()},
        "rate over\nMuJoCo [-]": found["rate_over_mujoco"],
    }
    words = (
        f"A row is who runs designs of {found['simulated_s']:g} simulated seconds on {THREADS} threads, from their "
        f"values to {len(MERITS)} figures of merit; simulate_many judges each run whole. Rates: {HIGHER}."
    )
    return [Table.of("Designs of a study", words, "who", columns, {name: name for name in found["runs_per_s"]})]


@part("studies", f"designs of a study, machines of {SCENARIO}, beside the same by simulate_many", _panels, read=_tables)
def studies(effort: Effort) -> Figures:
    """Runs per second from designs to figures of merit."""
    duration = effort.duration(2.0)
    keys = [f"duration={duration}", "compare=[]", "plates=tied", "engine=small-motion"]
    machine, source = Machine(load_scenario(SCENARIO, keys)), Runs()
    designs = [Design(k, {"machine.mass": 4000.0 + 2.0 * k}) for k in range(THREADS * LANES)]
    blocks = [designs[first : first + source.block] for first in range(0, len(designs), source.block)]

    def judged(engine: Any, own: Sequence[Design]) -> None:
        scenarios = (scenario_of(machine, design.values) for design in own)
        simulate_many(scenarios, THREADS, reduce=_figures, engine=engine)

    def merits() -> None:
        with ThreadPoolExecutor(THREADS) as pool:
            for found in pool.map(lambda block: source.evaluate(machine, block, MERITS), blocks):
                assert not any(isinstance(one, Failed) for one in found)

    few = designs[: 2 * THREADS]  # they take that much longer
    works: dict[str, Callable[[], object]] = {
        MUJOCO: partial(judged, "mujoco", few),
        SMALL: partial(judged, "small-motion", designs),
        STUDY: merits,
    }
    times = medians(works, min(effort.repetitions, 3))
    rates = {name: (len(few) if name == MUJOCO else len(designs)) / seconds for name, seconds in times.items()}
    return {
        "studies": {
            "simulated_s": duration,
            "runs_per_s": rates,
            "rate_over_mujoco": {name: rate / rates[MUJOCO] for name, rate in rates.items()},
        }
    }


def _figures(result: Result) -> list[float | None]:
    """The same figures of a whole summary."""
    found = result.summary
    return [
        *(found["attenuation_db"]["z"][band] for band in ("20", "50")),
        found["saturation"]["command"]["front-left"],
        found["oil"]["mean_power_w"],
        found["rms"]["valve_command"]["front-left"],
    ]
