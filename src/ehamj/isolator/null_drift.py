"""A valve whose null drifts: its opening with the spool centred grows at a steady rate, up to a bound."""

from typing import Any, ClassVar, Self

from pydantic import model_validator

from ehamj.compiled import kernel
from ehamj.isolator.component import At, Option
from ehamj.settings import quantity


@kernel
def drifted(position: float, at: At, own: "NullDrift") -> float:
    """Opening of edges whose null has drifted [mA]."""
    shift = own.null_drift * max(at.time - own.null_drift_from, 0.0)
    return position + min(max(shift, -own.null_drift_limit), own.null_drift_limit)


class NullDrift(Option):
    """Null offset that grows."""

    null_drift: float = quantity(0.0, "mA/s", "ẋ_n", "rate at which the valve's null drifts", "assumed")
    null_drift_from: float = quantity(0.0, "s", "t_n", "time from which it drifts", "assumed", ge=0)
    null_drift_limit: float = quantity(0.0, "mA", "x_n,max", "drift at which it ends", "assumed", ge=0)

    path: ClassVar[Any] = {"opening": drifted}

    @model_validator(mode="after")
    def _bounded(self) -> Self:
        if self.null_drift != 0.0 and self.null_drift_limit == 0.0:
            raise ValueError(f"null_drift = {self.null_drift:g} mA/s needs null_drift_limit, where it ends [mA]")
        return self
