"""A record of a test: channels over time, inputs among them, compared in time or in frequency."""

from typing import Any, Literal

from pydantic import Field

from ehamj.errors import InputError
from ehamj.identification.residual import Residuals
from ehamj.identification.tests.test import Context, TestSettings
from ehamj.settings import FileName

Comparison = Literal["time", "frequency", "both"]


class RecordTest(TestSettings):
    """Commands, strokes, pressures, motions and forces over time."""

    kind: Literal["record"]
    file: FileName | None = Field(None, description="file of the record; without: given in Python, by the test's name")
    measurement: dict[str, Any] = Field(default_factory=dict, description="what each component of the file is")
    settle: float = Field(0.2, ge=0, description="at the beginning, not compared [s]")
    compare: Comparison = Field(
        "time",
        description="time: the nonlinear engine; frequency: the linear model; both: frequency to find where to begin, "
        "then time",
    )

    def residuals(self, context: Context) -> Residuals:
        """See `TestSettings.residuals`."""
        raise InputError(f"test {self.name!r}: kind = 'record' is not compared yet")
