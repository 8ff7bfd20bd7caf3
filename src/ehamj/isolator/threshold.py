"""Threshold of the valve: small errors of position do not move the spool."""

from typing import Any, ClassVar

from ehamj.compiled import kernel
from ehamj.isolator.component import At, Option
from ehamj.settings import quantity


@kernel
def beyond_threshold(error: float, at: At, own: "Threshold") -> float:
    """What drives the spool [mA]: nothing within ±x_t of its target; beyond, the excess."""
    return error - min(max(error, -own.threshold), own.threshold)


class Threshold(Option):
    """Threshold of the valve."""

    threshold: float = quantity(0.0, "mA", "x_t", "error of position that does not move the spool", "assumed", ge=0)

    path: ClassVar[Any] = {"error": beyond_threshold}
