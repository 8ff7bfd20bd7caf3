"""Options of a valve that measurements may or may not justify: one more is one entry."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from ehamj.isolator.actuator import Actuator
from ehamj.registry import Registry


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


OPTIONS: Final[Registry[ValveOption]] = Registry("option")
"""By the name that ``[choice] options`` has."""

_SLOWLY: Final = "a valve test whose commands turn back often and far beyond it, as a multisine does"

OPTIONS.add(
    "hysteresis",
    ValveOption("a hysteresis", "hysteresis", (0.001, 0.004, 0.016), (0.0, 0.1), 0.002, _SLOWLY, of_stroke=True),
)
OPTIONS.add(
    "overlap",
    ValveOption(
        "an overlap of the edges (negative: underlap)", "overlap", (0.002, 0.008, 0.03, -0.004), (-0.05, 0.1), 0.005,
        "a valve test that crosses null often, at amplitudes of some times the overlap", of_stroke=True,
    ),
)  # fmt: skip
OPTIONS.add(
    "air",
    ValveOption(
        "air in the oil", "air_fraction", (0.001, 0.004, 0.016), (0.0, 0.1), 0.002,
        "a leak-down (fault 'supply-lost'): at the supply's pressures air hardly differs from softer oil, at low "
        "ones it is the softer part",
    ),
)  # fmt: skip
OPTIONS.add(
    "null-offset",
    ValveOption(
        "an offset of the null", "null_offset", (0.001, -0.001, 0.01, -0.01), (-0.1, 0.1), 0.002,
        "pressures as they are, without a free offset: they tell where the edges stand at rest", of_stroke=True,
    ),
)  # fmt: skip
OPTIONS.add(
    "threshold",
    ValveOption("a threshold", "threshold", (0.0005, 0.002, 0.008), (0.0, 0.1), 0.002, _SLOWLY, of_stroke=True),
)
OPTIONS.add(
    "flow-curve",
    ValveOption(
        "a flow curve (flow at a tenth of the stroke, over the full one)", "flow_curve.1.1",
        (-0.03, 0.03, -0.06, 0.1), (-0.09, 0.4), 0.02,
        "a valve test that opens it to some tenths of its stroke: near null alone it is another flow gain",
        neutral=0.1, set={"flow_curve": [[0.0, 0.0], [0.1, 0.1], [1.0, 1.0]]},
    ),
)  # fmt: skip
