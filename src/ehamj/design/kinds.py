"""Everything that can be designed: architectures with loops that are tuned, and syntheses, which find their loops."""

from typing import Any, Final

from ehamj.control.architectures.feedforward import FeedforwardSettings
from ehamj.control.settings import SHARED, ControlSettings, DigitalSettings
from ehamj.synthesis.kinds import STANDARD
from ehamj.synthesis.settings import SynthesisSettings

DESIGNABLE: Final = {name: one for name, one in STANDARD.items() if isinstance(one, DigitalSettings)}
"""What can be designed: the settings of each begin from their defaults."""


def beginning(kind: str, control: ControlSettings) -> DigitalSettings:
    """Settings of a kind that take clock, converter and held machine from a scenario's control; a synthesis also
    what is stated of its feedforward."""
    begin = DESIGNABLE[kind]
    if not isinstance(control, DigitalSettings):
        return begin
    given: dict[str, Any] = dict(control.shared)
    if isinstance(begin, SynthesisSettings):
        forward = [part for part in control.members if isinstance(part, FeedforwardSettings)]
        stated = forward[0] if forward else control.feedforward if isinstance(control, SynthesisSettings) else None
        if stated is not None:  # what is stated of it, about the synthesis's own
            own = {name: getattr(stated, name) for name in stated.model_fields_set.difference(SHARED, {"kind"})}
            given["feedforward"] = begin.feedforward.model_copy(update=own | {"isolate_from": 0.0})
        begins = [one.isolate_from for one in control.members if hasattr(one, "isolate_from")]
        given["isolate_from"] = max(begins, default=0.0)
    return begin.model_copy(update=given)
