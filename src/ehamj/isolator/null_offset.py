"""Null offset of the valve."""

from typing import Any, ClassVar

from ehamj.compiled import kernel
from ehamj.isolator.component import At, Option
from ehamj.settings import quantity


@kernel
def off_null(position: float, at: At, own: "NullOffset") -> float:
    """Opening of edges that are open while the spool is centred [mA]."""
    return position + own.null_offset


class NullOffset(Option):
    """Opening of the valve with its spool centred."""

    null_offset: float = quantity(0.0, "mA", "x_n", "opening of the valve with its spool centred", "assumed")

    path: ClassVar[Any] = {"opening": off_null}
