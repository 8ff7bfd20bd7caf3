"""The converter between a law and the valves, and of every reading: range, resolution, and the share that fades in."""

import math
from typing import NamedTuple

from ehamj.compiled import kernel


class Conversion(NamedTuple):
    """Range ±v_max [V] and resolution [V] (0: exact) of the commands, when they set in [s], and their fade [s]."""

    limit: float
    resolution: float
    switch_on: float
    fade: float


@kernel
def converted(value: float, limit: float, resolution: float) -> float:
    """What a converter makes of a value: limited to ±``limit``, rounded to ``resolution`` (0: exact)."""
    value = min(max(value, -limit), limit)
    if resolution > 0.0:
        value = resolution * math.floor(value / resolution + 0.5)
    return value


@kernel
def faded(time: float, own: Conversion) -> float:
    """Share of the commands that reaches the valves at a time: 0 before it sets in, then 3s² − 2s³ over the fade."""
    since = time - own.switch_on
    if since < -5e-10:  # half a nanosecond: times of steps are rounded
        return 0.0
    if since >= own.fade - 5e-10:
        return 1.0
    s = max(since, 0.0) / own.fade
    return s * s * (3.0 - 2.0 * s)


@kernel
def taken(total, share, own, result):  # type: ignore[no-untyped-def]
    """What fade and range take from the wanted commands of each valve (and lane), applied − wanted."""
    for k in range(total.size):
        result[k] = converted(share * total[k], own.limit, 0.0) - total[k]
