"""Studies whose figures of merit are closed forms: they know no machine, and misbehave where they are asked to.

A module that any process can import, as workers do: ``fake.*`` of designs with ``machine.mass`` m and ``machine.cg.2``
h, where m counts designs from 0. Design 5 is impossible, 13 is refused, 17 raises, a merit of 19 is not defined.
"""

import math
import multiprocessing
import os
import signal
import time
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ehamj.campaign.conduct import Conducted, conduct
from ehamj.campaign.plans.plan import Batches, Goals, Plan
from ehamj.campaign.stages import Search
from ehamj.campaign.tables import frame
from ehamj.errors import InputError
from ehamj.merits.merit import SOURCES, Design, Failed, Found, Machine, Merit, Source
from ehamj.scenario.load import load_scenario

NAMES = ("fake.sum", "fake.product", "fake.root")
REFUSED = {5: "must be above", 13: "brings no luck", 17: "ZeroDivisionError: by 17"}
"""Designs that fail, and something of what is said."""
DEADLY = 12
"""Design that ends its process, if the space says so."""


class Fake(Source):
    """Closed forms, in blocks of 8."""

    block: ClassVar[int] = 8

    def merits(self, machine: Machine) -> Mapping[str, Merit]:
        word = "fake" if self.block == 8 else "many"
        units = {"sum": "kg", "product": "kg m", "root": "1"}
        return {f"{word}.{name}": Merit(f"{word}.{name}", unit, "in closed form") for name, unit in units.items()}

    def evaluate(self, machine: Machine, designs: Sequence[Design], names: Sequence[str]) -> list[Found]:
        assert len(designs) <= self.block
        time.sleep(float(designs[0].values.get("pause", 0.0)))
        return [self._of(one.values, names) for one in designs]

    def _of(self, values: Mapping[str, Any], names: Sequence[str]) -> Found:
        mass, height = float(values["machine.mass"]), float(values["machine.cg.2"])
        die(values.get("deadly"))
        if mass == 5.0:
            return Failed("machine.mass = 5 must be above 5")
        if mass == 13.0:
            raise InputError("machine.mass: 13 brings\nno luck")
        if mass == 17.0:
            raise ZeroDivisionError("by 17")
        return {name: closed(mass, height)[name.partition(".")[2]] for name in names}


def closed(mass: float, height: float) -> dict[str, float]:
    """All merits of a design."""
    root = math.nan if mass == 19.0 else math.sqrt(mass) * math.sin(height)
    return {"sum": mass + height, "product": mass * height, "root": root}


class Many(Fake):
    """The same in large blocks."""

    block: ClassVar[int] = 500


def die(how: str | None) -> None:
    """End this process: always, or once, which a file of that name says."""
    if how and not Path(how).exists():
        if how != "always":
            Path(how).touch()
        os.kill(os.getpid(), signal.SIGKILL)


for name, source in (("fake", Fake()), ("many", Many())):
    if name not in SOURCES:
        SOURCES.add(name, source)


class Drawn(Plan):
    """Designs one after the other, heights drawn, in batches."""

    kind: str = "drawn"
    number: int = 64
    seed: int = 0
    batch: int = 1000

    def count(self, space: Any) -> int:
        return self.number

    def batches(self, space: Any, goals: Goals) -> Batches:
        points = np.random.default_rng(self.seed).random((self.number, 2))
        points[:, 0] = np.arange(self.number) / 1e6
        for first in range(0, self.number, self.batch):
            yield points[first : first + self.batch]


@dataclass(frozen=True)
class Plain:
    """Mass and height; how design `DEADLY` ends its process, and how long a block takes [s]."""

    deadly: str | None = None
    pause: float = 0.0

    @property
    def keys(self) -> tuple[str, ...]:
        return ("machine.mass", "machine.cg.2", "deadly", "pause")

    units: ClassVar = ("kg", "m", "1", "s")

    def values(self, points: np.ndarray) -> list[dict[str, Any]]:
        return [self._of(float(round(1e6 * mass)), height) for mass, height in points.tolist()]

    def _of(self, mass: float, height: float) -> dict[str, Any]:
        own = {"deadly": self.deadly} if self.deadly and mass == DEADLY else {}
        return {"machine.mass": mass, "machine.cg.2": height, "pause": self.pause, **own}


@cache
def machine() -> Machine:
    return Machine(load_scenario("recorded"))


def search(plan: Drawn | None = None, space: Plain | None = None, goals: Goals | None = None, **other: Any) -> Search:
    """A search of fake merits."""
    own = {"name": "search", "machine": machine(), "names": NAMES, **other}
    return Search(**own, plan=plan or Drawn(), space=space or Plain(), goals=goals or Goals())  # type: ignore[arg-type]


def done(folder: Path, stage: Search | None = None, **how: Any) -> Conducted:
    """A study that is done, on one thread."""
    return conduct(folder, [stage or search()], {"title": "fake"}, **{"scheduler": "threads:1", **how})


def done_aloud(told: Any, folder: Path, stage: Search, **how: Any) -> None:
    """As `done`, in a process of its own, which says when it begins."""
    machine()
    told.send("begins")
    done(folder, stage, **how)


def begun(folder: Path, stage: Search, **how: Any) -> Any:
    """A process of its own that has just begun a study; a copy of this one, which takes no time."""
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    machine()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "This process .* is multi-threaded", DeprecationWarning)
        process = context.Process(target=done_aloud, args=(theirs, folder, stage), kwargs=how)
        process.start()
    theirs.close()
    ours.recv()
    return process


def results(folder: Path) -> Any:
    """All that is equal however a study was done."""
    return frame(folder).drop(columns=["seconds", "deadly", "pause"])
