"""Figures of merit in closed form, for tests of studies: they know no machine, and misbehave when they are asked to.

A module that any process can import, as workers do. ``fake.*`` of a design with the values ``machine.mass`` m and
``machine.cg.2`` h, and what a file beside the test asks for.
"""

import math
import os
import signal
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import ClassVar

from ehamj.errors import InputError
from ehamj.merits.merit import SOURCES, Design, Failed, Found, Machine, Merit, Source

SLOW = "EHAMJ_FAKE_SLOW"
"""Time that each block takes [s]."""
DEADLY = "EHAMJ_FAKE_DEADLY"
"""Mass that kills the process, and, behind a colon, a file: once it exists, it does so no more."""


class Fake(Source):
    """Closed forms."""

    block: ClassVar[int] = 8

    def merits(self, machine: Machine) -> Mapping[str, Merit]:
        names = {"fake.sum": "kg", "fake.product": "kg m", "fake.root": "1"}
        return {name: Merit(name, unit, f"{name} in closed form") for name, unit in names.items()}

    def evaluate(self, machine: Machine, designs: Sequence[Design], names: Sequence[str]) -> list[Found]:
        time.sleep(float(os.environ.get(SLOW, "0")))
        return [self._of(machine, one, names) for one in designs]

    def _of(self, machine: Machine, design: Design, names: Sequence[str]) -> Found:
        mass = float(design.values.get("machine.mass", machine.scenario.machine.mass))
        height = float(design.values.get("machine.cg.2", machine.scenario.machine.cg[2]))
        _die(mass)
        if mass < 0.0:
            return Failed(f"machine.mass = {mass:g} must be above 0")
        if mass == 13.0:
            raise InputError("machine.mass: 13 brings\nno luck")
        if mass == 17.0:
            raise ZeroDivisionError("by 17")
        own = {
            "fake.sum": mass + height,
            "fake.product": mass * height,
            "fake.root": math.nan if mass == 19.0 else math.sqrt(mass) * math.sin(height),
        }
        return {name: own[name] for name in names}


def _die(mass: float) -> None:
    deadly, _, once = os.environ.get(DEADLY, "").partition(":")
    if deadly and mass == float(deadly) and not (once and Path(once).exists()):
        if once:
            Path(once).touch()
        os.kill(os.getpid(), signal.SIGKILL)


if "fake" not in SOURCES:
    SOURCES.add("fake", Fake())
