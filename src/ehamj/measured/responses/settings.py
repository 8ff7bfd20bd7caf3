"""What a user says of a file of frequency responses."""

from typing import Literal, Self

from pydantic import Field, model_validator

from ehamj.records.table_choices import TableChoices
from ehamj.settings import Positive, Settings


class ResponsePair(Settings):
    """One response of a file whose columns do not say of what they are: tables of text, Touchstone."""

    output: str = Field(description="key of [test.measurement] of the output")
    input: str = Field(description="key of [test.measurement] of the input")
    number: int | None = Field(
        None, ge=1, description="which complex number of a row it is, of a Touchstone-like file, from 1"
    )
    real: str | None = Field(None, description="column of the real part, by name or number")
    imaginary: str | None = Field(None, description="column of the imaginary part")
    magnitude: str | None = Field(None, description="column of the magnitude, instead of both, in dB where it says so")
    phase: str | None = Field(None, description="column of the phase, in the unit that it states or phase_unit")
    coherence: str | None = Field(None, description="column of the coherence γ² [-]")

    @model_validator(mode="after")
    def _complex(self) -> Self:
        cartesian, polar = (self.real, self.imaginary), (self.magnitude, self.phase)
        if (cartesian.count(None), polar.count(None)) not in ((2, 2), (0, 2), (2, 0)):
            raise ValueError("real and imaginary, or magnitude and phase: both of one kind, and none of the other")
        return self


class ResponseChoices(Settings):
    """What the user says of a file of frequency responses."""

    averages: Positive | None = Field(
        None, description="independent averages n that each response is the mean of, which coherence needs [-]"
    )
    deviation: Positive | None = Field(
        None,
        description="standard deviation of a complex value over the value, where coherence and averages do not tell "
        "it [-]",
    )
    pair: tuple[ResponsePair, ...] = Field(
        (), description="what columns are, where a table of text or a Touchstone-like file holds several responses"
    )
    phase_unit: Literal["deg", "rad"] | None = Field(None, description="unit of phases of a table that states none")
    table: TableChoices | None = Field(
        None, description="how a table of text is written, where the file does not show it"
    )
