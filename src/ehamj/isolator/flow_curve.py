"""Flow curve of the valve: a maker's flow over spool position, in place of a proportional one."""

import math
from itertools import pairwise
from typing import Any, ClassVar, Self

import numpy as np
from pydantic import model_validator

from ehamj.compiled import kernel
from ehamj.isolator.component import At, Option
from ehamj.settings import quantity

POINTS = 11
"""Points of the curve in memory, at equal shares of the stroke from 0 to 1."""


@kernel
def curved_opening(opening: float, at: At, own: Any) -> float:
    """Opening that gives a linear valve the flow of the curve [mA]; between its points it is straight."""
    if own.curved == 0.0:
        return opening
    place = min(abs(opening) / at.stroke, 1.0) * (POINTS - 1)
    k = min(int(place), POINTS - 2)
    share = own[k] + (place - k) * (own[k + 1] - own[k])
    return math.copysign(at.stroke * share, opening)


class FlowCurve(Option):
    """Flow over spool position."""

    flow_curve: tuple[tuple[float, float], ...] = quantity(
        (),
        "-",
        "q/q_N",
        "pairs of spool position and flow, as shares of the full ones, from (0, 0) to (1, 1)",
        "assumed",
    )

    takes: ClassVar[Any] = (*(f"flow_curve_{k}" for k in range(POINTS)), "curved")
    path: ClassVar[Any] = {"flow": curved_opening}
    arithmetic: ClassVar[bool] = False

    @classmethod
    def values_of(cls, isolator: Any) -> Any:
        """Share of the full flow at each point, and 1 if the valve has a curve."""
        shares = [k / (POINTS - 1) for k in range(POINTS)]
        if not isolator.flow_curve:
            return cls.Values(*shares, 0.0)
        places, flows = zip(*isolator.flow_curve, strict=True)
        return cls.Values(*(float(np.interp(share, places, flows)) for share in shares), 1.0)

    @property
    def curve_slope(self) -> float:
        """Slope of the curve at null [-]."""
        return self.flow_curve[1][1] / self.flow_curve[1][0] if self.flow_curve else 1.0

    @model_validator(mode="after")
    def _a_curve(self) -> Self:
        if self.flow_curve:
            places, flows = zip(*self.flow_curve, strict=True)
            if (places[0], flows[0]) != (0.0, 0.0) or (places[-1], flows[-1]) != (1.0, 1.0):
                raise ValueError(f"flow_curve = {list(self.flow_curve)} must go from [0, 0] to [1, 1]")
            off = [place for place in places if abs((POINTS - 1) * place - round((POINTS - 1) * place)) > 1e-9]
            if off:
                raise ValueError(f"flow_curve: position {off[0]:g} must be a multiple of {1 / (POINTS - 1):g}")
            if min(b - a for a, b in pairwise(places)) <= 0 or min(b - a for a, b in pairwise(flows)) < 0:
                raise ValueError(
                    f"flow_curve = {list(self.flow_curve)} must increase in position, and not fall in flow"
                )
        return self
