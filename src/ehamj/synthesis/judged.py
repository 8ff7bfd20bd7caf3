"""A law with what it has in hand on each machine that it must hold on."""

from collections.abc import Mapping
from dataclasses import dataclass

from ehamj.control import LinearController
from ehamj.control.sensors import Sensors
from ehamj.control.settings import SampledSettings
from ehamj.linear.loop import Loop, feeds_back
from ehamj.linear.margins import LoopReport, report
from ehamj.synthesis.requirements import Machines, Requirements

Worst = tuple[float, float, float]
"""Gain [dB], phase [deg] and disk margin."""


@dataclass(frozen=True)
class Design:
    """A law: its settings, and what it has in hand on each machine; ``tuned``: its gains were chosen."""

    settings: SampledSettings
    law: LinearController
    reports: Mapping[str, LoopReport]
    requirements: Requirements
    tuned: bool = True

    @property
    def meets(self) -> bool:
        """Whether all machines are stable with the required margins."""
        return all(one.stable and self.requirements.met_by(one.worst) for one in self.reports.values())

    def worst_of(self, motion: str) -> Worst:
        """Least gain [dB], phase [deg] and disk margin of a motion's loop on all machines."""
        found = [one.motions[motion] for one in self.reports.values()]
        return min(m.gain for m in found), min(m.phase for m in found), min(m.disk for m in found)

    def leaves(self, motion: str) -> bool:
        """Whether the loop of a motion has the required margins on all machines."""
        return self.requirements.met_by(self.worst_of(motion))

    @property
    def least(self) -> tuple[tuple[float, str], ...]:
        """Least gain [dB], phase [deg] and disk margin of all machines, each with the machine that has it."""
        return tuple(min((one.worst[k], name) for name, one in self.reports.items()) for k in range(3))


def judged(
    settings: SampledSettings,
    law: LinearController,
    sensors: Sensors,
    machines: Machines,
    requirements: Requirements,
    seed: int = 0,
) -> Design:
    """A law, as its settings made it, with its margins on every machine; without a loop there are none.

    Args:
        settings: that made it.
        law: to be judged.
        sensors: that it reads.
        machines: the machine and its variations.
        requirements: margins.
        seed: that draws the directions of misaligned instruments.
    """
    models = machines if feeds_back(law) else {}
    reports = {name: report(model, Loop(law, sensors, seed)) for name, model in models.items()}
    return Design(settings, law, reports, requirements)
