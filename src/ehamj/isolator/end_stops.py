"""End stops of the spool."""

import math
from typing import Any, ClassVar

from pydantic import Field

from ehamj.compiled import kernel
from ehamj.isolator.component import At, Option


@kernel
def held_by_stop(motion: tuple[float, float], at: At, own: "EndStops") -> tuple[float, float]:
    """Rate and acceleration of a spool with stops at ±x_max: a stop takes no push and gives no bounce."""
    rate, acceleration = motion
    if own.end_stops != 0.0 and abs(at.position) >= at.stroke and at.position * rate >= 0.0:
        rate = 0.0
        if at.position * acceleration > 0.0:
            acceleration = 0.0
    return rate, acceleration


@kernel
def at_stop(spool: tuple[float, float], at: At, own: "EndStops") -> tuple[float, float]:
    """Position and rate of the spool after a step, which may have carried it past its stop."""
    position, rate = spool
    if own.end_stops != 0.0 and abs(position) >= at.stroke:
        position = math.copysign(at.stroke, position)
        if position * rate > 0.0:
            rate = 0.0
    return position, rate


class EndStops(Option):
    """End stops of the spool."""

    end_stops: bool = Field(False, description="the spool stops at ±spool_stroke")

    path: ClassVar[Any] = {"motion": held_by_stop, "settled": at_stop}
