"""How cost grows: with duration, rows, mounts, states of the law."""

import math
from collections.abc import Callable, Mapping
from typing import Any, Final

from ehamj.bench.controller import large_law
from ehamj.bench.parts import Effort, Figures, part
from ehamj.bench.reading import LOWER, Table
from ehamj.bench.runs import Run, SideBySide, Stepping, medians
from ehamj.control import AnyController
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
LONGER: Final = {"mujoco": 1.0, "small-motion": 5.0}
"""How much longer runs of an engine are, so that each takes milliseconds."""
STEP: Final = 1e-4
"""Step of what is not timed at its own [s]."""


TIME: Final = f"time, over the smallest's ({LOWER})"


def _panels(figures: Mapping[str, Any]) -> list[Panel]:
    mounts = figures["step_over_four_upright_mounts"]["tied"]["upright"]
    return [
        Lines(
            f"How cost grows, {engine} engine",
            "size, over the smallest",
            TIME,
            _lines(found),
        )
        for engine, found in (
            ("MuJoCo", figures["growth"]["mujoco"] | {"mounts": mounts}),
            ("small-motion", figures["growth"]["small-motion"]),
        )
    ]


def _tables(figures: Mapping[str, Any]) -> list[Table]:
    said = {
        "duration": "{} × the shortest",
        "rows": "{} rows per second",
        "law_states": "{} states of the law",
    }
    engines = {"mujoco": "MuJoCo engine [-]", "small-motion": "small-motion engine [-]"}
    grown = {
        head: {f"{what} {size}": value for what in said for size, value in figures["growth"][engine][what].items()}
        for engine, head in engines.items()
    }
    sizes = figures["growth"]["mujoco"]
    mounts = {
        f"MuJoCo, {plates}\n{layout} [-]": own
        for plates, layouts in figures["step_over_four_upright_mounts"].items()
        for layout, own in layouts.items()
    }
    mounts["small-motion\nupright [-]"] = figures["growth"]["small-motion"]["mounts"]
    return [
        Table.of(
            "How the time of a run grows",
            f"A row is a size; its time over that of the smallest one, which is 1; {LOWER}.",
            "size",
            grown,
            {f"{what} {size}": words.format(size) for what, words in said.items() for size in sizes[what]},
        ),
        Table.of(
            "How the time of a step grows with mounts",
            f"A row is a number of mounts; time over that of four upright ones on the MuJoCo engine, plates tied or "
            f"sliding, or over that of three on the small-motion one; {LOWER}.",
            "mounts",
            mounts,
            {str(number): f"{number} mounts" for number in MOUNTS},
        ),
    ]


def _lines(found: Mapping[str, Mapping[str, float]]) -> list[Line]:
    said = {"duration": "duration", "rows": "rows per second", "law_states": "states of the law", "mounts": "mounts"}
    lines = []
    for color, (key, name) in enumerate(said.items()):
        sizes, times = [float(size) for size in found[key]], list(found[key].values())
        x, y = [size / sizes[0] for size in sizes], [each / times[0] for each in times]
        lines.append(Line(name, x, y, color, marker="o^sD"[color]))
    return lines


@part("growth", "how cost grows with duration, rows, mounts and states of the law", _panels, read=_tables)
def growth(effort: Effort) -> Figures:
    """Times over the least, by what grows."""

    def grown(engine: str) -> Figures:
        return {
            "duration": over_duration(effort, engine),
            "rows": over_rows(effort, engine),
            "law_states": over_states(effort, engine),
        }

    small = grown("small-motion") | {"mounts": small_over_mounts(effort)}
    return {
        "growth": {"mujoco": grown("mujoco"), "small-motion": small},
        "step_over_four_upright_mounts": {plates: over_mounts(effort, plates) for plates in ("tied", "sliding")},
    }


def _over_first(works: Mapping[int, Callable[[], object]], effort: Effort) -> dict[str, float]:
    times = medians({str(size): work for size, work in works.items()}, effort.repetitions)
    first = next(iter(times.values()))
    return {size: seconds / first for size, seconds in times.items()}


def _stepped(scenario: Scenario, law: AnyController | None = None) -> Callable[[], float]:
    """What steps a scenario on its engine."""
    return SideBySide([scenario], law) if scenario.engine == "small-motion" else Stepping(scenario, law)


def over_duration(effort: Effort, engine: str) -> dict[str, float]:
    """Time of stepping the benchmark case over that of the shortest duration, by duration over the shortest."""
    least = effort.duration(0.25 * LONGER[engine])
    cases = {k: load_scenario("benchmark", [f"engine={engine}", f"duration={k * least}"]) for k in DURATIONS}
    return _over_first({k: _stepped(case) for k, case in cases.items()}, effort)


def over_rows(effort: Effort, engine: str) -> dict[str, float]:
    """Time of stepping the benchmark case over that with the fewest rows, by rows per second [Hz]."""
    given = [f"engine={engine}", f"duration={effort.duration(0.3 * LONGER[engine])}", f"timestep={STEP}"]
    cases = {rate: load_scenario("benchmark", [*given, f"record_rate={rate}"]) for rate in ROW_RATES}
    return _over_first({rate: _stepped(case) for rate, case in cases.items()}, effort)


def over_states(effort: Effort, engine: str) -> dict[str, float]:
    """Time of stepping under a dense law at 10 kHz over that with the fewest states, by number of states."""
    given = [f"engine={engine}", f"duration={effort.duration(0.2 * LONGER[engine])}", "compare=[]"]
    scenario = load_scenario("recorded", given)
    laws = {states: large_law(scenario.plant.mounts, states) for states in STATES}
    return _over_first({states: _stepped(scenario, law) for states, law in laws.items()}, effort)


def small_over_mounts(effort: Effort) -> dict[str, float]:
    """Time of stepping on the small-motion engine over that of the fewest mounts, by number of upright ones."""
    given = {"engine": "small-motion", "duration": effort.duration(1.0), "timestep": STEP}
    return _over_first({mounts: _stepped(standing(mounts, False, "tied", **given)) for mounts in MOUNTS}, effort)


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


def standing(mounts: int, skew: bool, plates: str, **more: Any) -> Scenario:
    """The default machine on so many isolators in a circle; skew ones lean inwards, half of them 0.3 m higher."""
    table: list[dict[str, Any]] = []
    for k in range(mounts):
        x, y = math.cos(2 * math.pi * k / mounts), math.sin(2 * math.pi * k / mounts)
        place = {"position": [0.75 * x, 0.75 * y]}
        if skew:
            place = {"position": [0.75 * x, 0.75 * y, 0.3 * (k % 2)], "direction": [-TILT * x, -TILT * y, 1.0]}
        table.append({"name": f"m{k + 1}", **place})
    return parse_scenario({"mount": table, "plates": plates, **more})
