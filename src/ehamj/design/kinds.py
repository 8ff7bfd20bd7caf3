"""Everything that can be designed: architectures with loops that are tuned, and syntheses, which find their loops."""

from typing import Any, Final

from ehamj.control.architectures.feedforward import FeedforwardSettings
from ehamj.control.settings import ControlSettings, DigitalSettings
from ehamj.synthesis.kinds import STANDARD, SYNTHESES
from ehamj.synthesis.settings import SynthesisSettings

DESIGNABLE: Final = {name: one for name, one in STANDARD.items() if isinstance(one, DigitalSettings)}
"""What can be designed: the settings of each begin from their defaults."""


def beginning(kind: str, control: ControlSettings) -> DigitalSettings:
    """Settings of a kind that take clock, converter and held machine from a scenario's control; a synthesis also its
    feedforward."""
    begin = DESIGNABLE[kind]
    if not isinstance(control, DigitalSettings):
        return begin
    given: dict[str, Any] = dict(control.shared)
    forward = [part for part in control.members if isinstance(part, FeedforwardSettings)]
    if kind in SYNTHESES and (forward or isinstance(control, SynthesisSettings)):
        given["feedforward"] = control.feedforward if isinstance(control, SynthesisSettings) else forward[0]
    return begin.model_copy(update=given)
