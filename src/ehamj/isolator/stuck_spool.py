"""A spool that is stuck: it stands at a share of its stroke whatever the command."""

from typing import Any, ClassVar

from pydantic import Field

from ehamj.compiled import kernel
from ehamj.isolator.component import At, Option
from ehamj.settings import quantity


@kernel
def held_in_place(target: float, at: At, own: "StuckSpool") -> float:
    """Where the spool goes [mA]: to where it is stuck, and there it stays."""
    return own.spool_stuck_at * at.stroke if own.spool_stuck != 0.0 else target


class StuckSpool(Option):
    """Spool that no command moves."""

    spool_stuck: bool = Field(False, description="the spool stands at spool_stuck_at, whatever the command")
    spool_stuck_at: float = quantity(
        0.0, "-", "x/x_max", "where a stuck spool stands, as share of its stroke", "assumed", ge=-1, le=1
    )

    path: ClassVar[Any] = {"target": held_in_place}
