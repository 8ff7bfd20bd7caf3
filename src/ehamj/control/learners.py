"""What a law knows of one isolator before it learns, and within what it learns: numbers that its file holds.

Learnt are, of each mount, the `LEARNT` quantities; `ehamj.control.compiled.learning` says how.
"""

import math
from collections.abc import Sequence
from typing import Any, Final, NamedTuple, Self

from ehamj.control.tables import numbers_in
from ehamj.errors import InputError

POSITIVE: Final = ("area_1", "area_2", "area", "flow", "oil", "rate", "low", "high", "memory", "prior", "pace", "least")
"""What must be positive of a learner."""
NOT_NEGATIVE: Final = ("leak", "stretch", "creep", "stroke_lag", "pressure_lag")
"""What must be zero or positive."""


class Learnt(NamedTuple):
    """What is learnt of one mount; nothing learnt: the stated values, 1, 1, 0, 0, 0."""

    flow_gain: float
    """Flow gain over the stated one [-]."""
    compliance: float
    """Compliance of the oil, V_t/(4β), over the stated one [-]."""
    overlap: float
    """More than stated, of each edge [mA]."""
    play: float
    """More than stated: threshold and half of the hysteresis [mA]."""
    null_offset: float
    """More than stated [mA]."""


STATED: Final = Learnt(1.0, 1.0, 0.0, 0.0, 0.0)
"""Where learning begins."""


class Learner(NamedTuple):
    """What is known of one isolator, and how it is learnt."""

    area_1: float
    """Of the piston, at chamber 1 [m²]."""
    area_2: float
    area: float
    """Oil that the piston displaces per travel, as the valve's edges share it [m²]."""
    flow: float
    """K_Q as stated [m³/s per mA]."""
    oil: float
    """Compliance as stated, V_t/(4βA) [m³/N]."""
    leak: float
    """K_C/A [m³/s per N]."""
    stretch: float
    """K_L/K_h as stated [-]."""
    creep: float
    """c, below which leakage and membrane bind [rad/s]."""
    stroke_lag: float
    """Delay of the stroke's reading at low frequency [s]."""
    pressure_lag: float
    """The same of the pressures' [s]."""
    least_gain: float
    """Range of what is learnt; see `Learnt`."""
    most_gain: float
    least_compliance: float
    most_compliance: float
    least_overlap: float
    most_overlap: float
    least_play: float
    most_play: float
    least_offset: float
    most_offset: float
    rate: float
    """Of the blocks over which the isolator is balanced [Hz]."""
    low: float
    """Band that is learnt from [Hz]."""
    high: float
    memory: float
    """Time over which is forgotten [s]."""
    prior: float
    """For how long a motion that is all in one quantity counts against its range [s]."""
    pace: float
    """Time over which what is used follows what is found [s]."""
    least: float
    """Flow in the band, as an opening, RMS, below which nothing is learnt [mA]."""

    def to_dict(self) -> dict[str, Any]:
        """As plain data."""
        return self._asdict()

    @classmethod
    def from_dict(cls, table: Any) -> Self:
        """The inverse of `to_dict`.

        Raises:
            InputError: if a key is missing or unknown, or a number is not one, or out of its range.
        """
        numbers = cls(*numbers_in(table, cls._fields, "controller.learners"))
        if not all(map(math.isfinite, numbers)) or min(getattr(numbers, name) for name in POSITIVE) <= 0.0:
            raise InputError(f"controller.learners: numbers must be finite, and {', '.join(POSITIVE)} positive")
        below = [name for name in NOT_NEGATIVE if getattr(numbers, name) < 0.0]
        if below:
            raise InputError(
                f"controller.learners: {below[0]} = {getattr(numbers, below[0]):g} must be zero or positive, as "
                f"{', '.join(NOT_NEGATIVE)} all must"
            )
        if not numbers.low < numbers.high < 0.25 * numbers.rate:
            raise InputError(
                f"controller.learners: low = {numbers.low:g} Hz and high = {numbers.high:g} Hz must rise, and end "
                f"below a quarter of rate = {numbers.rate:g} Hz"
            )
        for low, stated, high in zip(numbers.ranges[::2], STATED, numbers.ranges[1::2], strict=True):
            if not low <= stated <= high:
                raise InputError(f"controller.learners: a range from {low:g} to {high:g} must hold {stated:g}")
        if numbers.least_gain <= 0.0 or numbers.least_compliance <= 0.0:
            raise InputError("controller.learners: least_gain and least_compliance must be positive")
        return numbers

    @property
    def ranges(self) -> tuple[float, ...]:
        """Least and most of each of `Learnt`."""
        return self[Learner._fields.index("least_gain") : Learner._fields.index("rate")]

    def ahead(self, latency: float) -> float:
        """By how much what the valve was told comes before the stroke that shows it, of a stage with a latency [s]."""
        return latency + self.stroke_lag

    def samples(self, period: float, latency: float) -> int:
        """Samples of a block of a stage with a period and a latency [s]: as ``rate`` asks for, and so many that what
        the valve was told is in the block that it is balanced with."""
        wanted = math.ceil(1.0 / (self.rate * period) - 1e-9)
        return max(wanted, math.ceil(self.ahead(latency) / period - 1e-9) + 1)


def strokes(mounts: Sequence[str]) -> tuple[str, ...]:
    """Strokes that are read to learn."""
    return tuple(f"stroke {mount}" for mount in mounts)
