"""Synthesised laws under stated margins: loops as the weights give them, lowered motion by motion until these hold."""

from collections.abc import Callable
from typing import Final

from ehamj.control import Controller
from ehamj.control.architectures.feedforward import FeedforwardSettings
from ehamj.control.settings import ControlSettings, DigitalSettings
from ehamj.design.hinfinity import HInfinitySettings, hinfinity
from ehamj.design.lqg import LqgSettings, lqg
from ehamj.design.motions import MotionWeights
from ehamj.design.requirements import Machines, Requirements
from ehamj.design.tuning import Design, holds
from ehamj.errors import InputError
from ehamj.linear.loop import Loop
from ehamj.linear.margins import LoopReport, report
from ehamj.plant.levers import MOTIONS
from ehamj.scenario.model import Scenario

Synthesised = HInfinitySettings | LqgSettings

SYNTHESES: Final[dict[str, tuple[type[Synthesised], Callable[..., Controller]]]] = {
    "h-infinity": (HInfinitySettings, hinfinity),
    "lqg": (LqgSettings, lqg),
}
"""Settings and solver by the name of the synthesis."""

LOWER: Final = 0.85
TRIES: Final = 12


def synthesised(
    scenario: Scenario, machines: Machines, settings: Synthesised, requirements: Requirements | None = None
) -> Design:
    """The law of a synthesis that leaves the margins on a machine and all its variations.

    Args:
        scenario: machine and instruments.
        machines: the machine and its variations.
        settings: weights to begin with; gains come down by 15 % until the margins hold.
        requirements: margins.

    Raises:
        InputError: if no law exists, or none leaves the margins.
    """
    wanted = requirements or Requirements()
    failure = InputError("design: no law was found")
    for _ in range(TRIES):
        try:
            law = SYNTHESES[settings.kind][1](scenario, settings, machines.models["as designed"])
        except InputError as error:
            failure, reports = error, {}
        else:
            reports = {name: report(model, Loop.of(scenario, law)) for name, model in machines.models.items()}
            design = Design(settings, law, reports, wanted)
            if design.meets:
                return design
            failure = InputError(
                f"design: no {settings.kind} law leaves {wanted.gain_margin:g} dB, {wanted.phase_margin:g}° and a disk "
                f"margin of {wanted.disk_margin:g} with gains from the given ones down to "
                f"{100 * LOWER ** (TRIES - 1):.0f} % of them; ask for less"
            )
        settings = _lowered(settings, reports, wanted)
    raise failure


def beginning(kind: str, control: ControlSettings) -> Synthesised:
    """Settings of a synthesis that take clock, converter and feedforward from a scenario's control."""
    if not isinstance(control, DigitalSettings):
        return SYNTHESES[kind][0]()
    forward = [part for part in control.members if isinstance(part, FeedforwardSettings)]
    given = {"feedforward": forward[0]} if forward else {}
    return SYNTHESES[kind][0].model_validate({**control.shared, **given})


def _lowered(settings: Synthesised, reports: dict[str, LoopReport], wanted: Requirements) -> Synthesised:
    """Settings with lower gains where a motion lacks margins; everywhere where none does by itself."""
    short = [
        motion
        for motion in MOTIONS
        if any(
            not holds((own.gain, own.phase, own.disk), wanted)
            for own in (one.motions[motion] for one in reports.values())
        )
    ]
    changed = {}
    for motion in short or MOTIONS:
        weights: MotionWeights = getattr(settings, motion)
        changed[motion] = weights.model_copy(update={"gain": LOWER * weights.gain})
    return settings.model_copy(update=changed)
