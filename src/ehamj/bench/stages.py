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
from ehamj.mujoco import hydraulics
from ehamj.mujoco.model import drawn_xml
from ehamj.plots.timings import Bars, Panel
from ehamj.result import Result
from ehamj.run.drive import drive
from ehamj.run.observe import observe
from ehamj.run.prepare import prepare
from ehamj.run.summarise import summarise
from ehamj.scenario.load import load_scenario
from ehamj.scenario.model import Scenario

SCENARIO: Final = "recorded"
ROUNDS: Final = 2
"""At most, after one that warms up: a round takes seconds."""


def _panels(figures: Mapping[str, Any]) -> list[Panel]:
    return [
        Bars(f"From command to picture: {SCENARIO}, {figures['stages']['simulated_s']:g} s", "seconds", seconds, {})
        for seconds in (figures["stages"]["mujoco_s"],)
    ]


@part("stages", f"from command to picture: what each stage of a short run of {SCENARIO} takes", _panels)
def stages(effort: Effort) -> Figures:
    """Seconds of each stage [s]."""
    duration = effort.duration(2.0)
    scenario = load_scenario(SCENARIO, [f"duration={duration}", "compare=[]"])
    rounds = [Stages().through(scenario) for _ in range(1 + min(ROUNDS, effort.repetitions))][1:]
    seconds = {name: float(np.median([one[name] for one in rounds])) for name in rounds[0]}
    return {"stages": {"simulated_s": duration, "mujoco_s": seconds}}


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
        with hydraulics():
            with self._stage("prepare"):
                prepared = prepare(scenario, None)
            with self._stage("sampling"):
                driven = drive(prepared)
        self.seconds["sampling"] -= driven.seconds
        self.seconds["stepping"] = driven.seconds
        with self._stage("observe"):
            dataset = observe(prepared, driven.rows, driven.struck)
        with self._stage("summary"):
            dataset.attrs["complete"] = 1
            summary = summarise(prepared, driven, dataset, sum(self.seconds.values()), None)
            model = drawn_xml(scenario.plant, prepared.timestep)
        return Result(scenario, dataset, summary, model, prepared.law)


def _writers(result: Result, folder: Path) -> dict[str, Callable[[], None]]:
    """What writes the files of a run into a folder, by stage; libraries that it takes are imported within."""

    def replay() -> None:
        from ehamj.replay import write_replay

        write_replay(folder / "replay.rrd", {result.scenario.name: result})

    def report() -> None:
        from ehamj.report import write_report

        write_report(folder, {result.scenario.name: result})

    return {"NetCDF": lambda: result.write(folder), "replay": replay, "report": report}
