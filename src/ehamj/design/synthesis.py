"""Synthesised laws under stated margins: loops as the weights give them, lowered motion by motion until these hold."""

from typing import Any, Final

from ehamj.control.architectures.feedforward import FeedforwardSettings
from ehamj.control.settings import ControlSettings, DigitalSettings
from ehamj.design.kinds import SYNTHESES
from ehamj.design.motions import MotionWeights, SynthesisSettings
from ehamj.design.requirements import Machines, Requirements
from ehamj.design.tuning import Design, judged
from ehamj.errors import InputError
from ehamj.plant.levers import MOTIONS
from ehamj.scenario.model import Scenario

LOWER: Final = 0.85
TRIES: Final = 12


def synthesised(
    scenario: Scenario, machines: Machines, settings: SynthesisSettings, requirements: Requirements | None = None
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
        short: list[str] = []
        try:
            law = settings.law(scenario, machines["as designed"])
        except InputError as error:
            failure = error
        else:
            design = judged(settings, law, scenario, machines, wanted)
            if design.meets:
                return design
            short = [name for name in MOTIONS if not design.leaves(name)]
            failure = InputError(
                f"design: no {settings.kind} law leaves {wanted.gain_margin:g} dB, {wanted.phase_margin:g}° and a disk "
                f"margin of {wanted.disk_margin:g} with gains from the given ones down to "
                f"{100 * LOWER ** (TRIES - 1):.0f} % of them; ask for less"
            )
        # Where a motion lacks margins; everywhere where none does by itself.
        lowered: dict[str, MotionWeights] = {name: getattr(settings, name) for name in short or MOTIONS}
        settings = settings.model_copy(
            update={name: own.model_copy(update={"gain": LOWER * own.gain}) for name, own in lowered.items()}
        )
    raise failure


def beginning(kind: str, control: ControlSettings) -> SynthesisSettings:
    """Settings of a synthesis that take clock, converter and feedforward from a scenario's control."""
    given: dict[str, Any] = {}
    if isinstance(control, DigitalSettings):
        forward = [part for part in control.members if isinstance(part, FeedforwardSettings)]
        given = {**control.shared, **({"feedforward": forward[0]} if forward else {})}
    return SYNTHESES[kind].model_validate(given)
