"""From command to picture: what each stage of a short run takes."""

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np

from ehamj.bench.parts import Effort, Figures, part
from ehamj.bench.reading import LOWER, Table
from ehamj.mujoco import hydraulics
from ehamj.plots.timings import Bars, Panel
from ehamj.result import Result
from ehamj.run.drive import drive
from ehamj.run.prepare import prepare
from ehamj.run.side_by_side import drive_block, small
from ehamj.run.simulate import judged, seen
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario

SCENARIO: Final = "recorded"
ROUNDS: Final = 2
"""At most: a round takes seconds."""


def _panels(figures: Mapping[str, Any]) -> list[Panel]:
    found = figures["stages"]
    axis = f"seconds, for {found['simulated_s']:g} s of {SCENARIO} ({LOWER})"
    return [
        Bars(f"From command to picture, {engine} engine", axis, found[key], {})
        for engine, key in (("MuJoCo", "mujoco_s"), ("small-motion", "small_motion_s"))
    ]


def _tables(figures: Mapping[str, Any]) -> list[Table]:
    found = figures["stages"]
    columns = {"MuJoCo engine [s]": found["mujoco_s"], "small-motion engine [s]": found["small_motion_s"]}
    words = f"A row is a stage of a run of {found['simulated_s']:g} simulated seconds and of what it writes; {LOWER}."
    names = {name: name for name in found["mujoco_s"]}
    return [Table.of(f"From command to picture, {SCENARIO}", words, "stage", columns, names)]


@part("stages", f"from command to picture: what each stage of a short run of {SCENARIO} takes", _panels, read=_tables)
def stages(effort: Effort) -> Figures:
    """Seconds of each stage [s]."""
    duration = effort.duration(2.0)
    given = [f"duration={duration}", "compare=[]"]
    engines = {engine: load_scenario(SCENARIO, [*given, f"engine={engine}"]) for engine in ("mujoco", "small-motion")}
    if effort.repetitions > 1:
        Stages().through(engines["mujoco"])  # what is imported and compiled only once is left out
    rounds = [
        {engine: Stages().through(scenario) for engine, scenario in engines.items()}
        for _ in range(min(ROUNDS, effort.repetitions))
    ]

    def seconds(engine: str) -> dict[str, float]:
        found = [one[engine] for one in rounds]
        return {name: float(np.median([one[name] for one in found])) for name in found[0]}

    return {
        "stages": {
            "simulated_s": duration,
            "mujoco_s": seconds("mujoco"),
            "small_motion_s": seconds("small-motion"),
        }
    }


class Stages:
    """One way from command to picture, with the time of each stage [s]."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    @contextmanager
    def _stage(self, name: str) -> Iterator[None]:
        began = time.perf_counter()
        yield
        self.seconds[name] = time.perf_counter() - began

    def through(self, scenario: Scenario) -> dict[str, float]:
        """Seconds of each stage [s], in order."""
        with self._stage("import"):  # in a process of its own, as a command does
            subprocess.run([sys.executable, "-c", "import ehamj.cli"], check=True)
        result = self._simulated(scenario)
        with tempfile.TemporaryDirectory() as folder:
            for name, write in _writers(result, Path(folder)).items():
                with self._stage(name):
                    write()
        return self.seconds

    def _simulated(self, scenario: Scenario) -> Result:
        began = time.perf_counter()
        with hydraulics():
            with self._stage("prepare"):
                prepared = prepare(scenario, None)
            with self._stage("sampling"):
                small_motion = scenario.engine == "small-motion"
                driven = next(drive_block([prepared], [small(prepared)])) if small_motion else drive(prepared)
        self.seconds["sampling"] -= driven.seconds
        self.seconds["stepping"] = driven.seconds
        with self._stage("observe"):
            run = seen(prepared, driven)
        with self._stage("summary"):
            return judged(run, began, None)


def _writers(result: Result, folder: Path) -> dict[str, Callable[[], None]]:
    """What writes the files of a run into a folder, by stage; libraries that it takes are imported within."""

    def replay() -> None:
        from ehamj.replay import write_replay

        write_replay(folder / "replay.rrd", {result.scenario.name: result})

    def report() -> None:
        from ehamj.report import write_report

        write_report(folder, {result.scenario.name: result})

    return {"NetCDF": lambda: result.write(folder), "replay": replay, "report": report}
