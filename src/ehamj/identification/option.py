"""What an option of a valve is, that measurements may or may not justify."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ehamj.isolator.actuator import Actuator


@dataclass(frozen=True)
class ValveOption:
    """An option that one number describes, 0 or a neutral value of which is a valve without it."""

    about: str
    """With its article, as in "the data justify …"."""
    key: str
    """Of the isolator's table; of a list that all have one value, the list."""
    sizes: tuple[float, ...]
    """At which a fit may begin, small ones first: an option of no size has no slope, or one to one side only. As the
    value differs from the neutral one, over `scale`."""
    bounds: tuple[float, float]
    """Within which it is looked for, likewise."""
    matters: float
    """Smallest size that anybody asks for, likewise: data that leave more open than this cannot tell."""
    seen_by: str
    """What test shows it, in words."""
    of_stroke: bool = False
    """Whether sizes are shares of the spool's stroke, and the value is in mA."""
    neutral: float = 0.0
    set: Mapping[str, Any] = field(default_factory=dict)
    """What else the isolator's table needs to have it."""

    def scale(self, actuator: Actuator) -> float:
        """What a size of 1 is, in the unit of the value."""
        return actuator.spool_stroke if self.of_stroke else 1.0

    def value(self, size: float, actuator: Actuator) -> float:
        """Value of an option of this size."""
        return self.neutral + size * self.scale(actuator)
