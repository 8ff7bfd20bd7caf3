"""Hysteresis of the valve: play between the spool and its metering edges."""

from typing import Any, ClassVar

from ehamj.compiled import kernel
from ehamj.isolator.component import At, Option
from ehamj.settings import quantity


@kernel
def play(position: float, at: At, own: "Hysteresis") -> float:
    """The metering edges follow the spool with a play of x_y [mA], from where they stood (``at.held``).

    While the spool moves one way this is exact however far it moves; 0 wide, it is the spool itself.
    """
    return min(max(at.held, position - 0.5 * own.hysteresis), position + 0.5 * own.hysteresis)


class Hysteresis(Option):
    """Play between spool and metering edges."""

    hysteresis: float = quantity(0.0, "mA", "x_y", "play between spool and metering edges", "assumed", ge=0)

    path: ClassVar[Any] = {"metering": play}
