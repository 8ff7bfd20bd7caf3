"""What the user says about a table of text: the keys that resolve what its lines leave open."""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from ehamj.settings import Positive, Settings

LineNumber = Annotated[int, Field(ge=1)]
DateOrder = Literal["day-month-year", "month-day-year", "year-month-day"]


class TableChoices(Settings):
    """What the user says about a table of text (*.csv, *.txt, …); without a key, the file shows it."""

    encoding: str | None = Field(None, description="encoding of the text, such as utf-8, cp1252, cp850, utf-16")
    delimiter: Literal[",", ";", "\t", "|", " "] | None = Field(
        None, description="what parts the cells of a row; ' ': any number of blanks"
    )
    decimal: Literal[".", ","] | None = Field(None, description="decimal mark of numbers")
    thousands: Literal[",", ".", " ", "'"] | None = Field(
        None, description="mark between groups of three digits, as in 1,234.5; without, none is believed"
    )
    comment: str | None = Field(
        None, min_length=1, max_length=3, description="mark that lines to pass over begin with; default: # % ! // *"
    )
    header: LineNumber | None = Field(None, description="line with the columns' names, as an editor numbers it")
    unit_line: LineNumber | None = Field(None, description="line with the columns' units")
    first_row: LineNumber | None = Field(None, description="line of the first row of numbers")
    last_row: LineNumber | None = Field(None, description="line of the last row of numbers")
    columns: tuple[str, ...] | None = Field(None, description="names of the columns, in their order", min_length=1)
    units: dict[str, str] | None = Field(
        None, description="units of columns by name or number, as {z = 'mg', 3 = 'ms'}; they overrule the file's"
    )
    time: str | None = Field(None, description="name or number of the column that holds the times")
    time_unit: str | None = Field(
        None, description="unit of the times: s, ms, us, min, h; of times of day in two parts: mm:ss, hh:mm"
    )
    rate: Positive | None = Field(
        None, description="sampling rate [Hz]; a column of times is then passed over, and each row is the next sample"
    )
    date_order: DateOrder | None = Field(None, description="order in which dates are written")
    missing: tuple[str, ...] | None = Field(
        None, description="cells that stand for no value, such as OVERLOAD or -9999, besides empty ones, nan, n/a, ---"
    )

    @model_validator(mode="after")
    def _agreeing(self) -> Self:
        if self.encoding is not None:
            try:
                "a".encode(self.encoding)
            except (LookupError, ValueError) as error:
                some = "utf-8, utf-16, cp1252 and cp850 are some"
                raise ValueError(f"encoding = {self.encoding!r} is not that of a text; {some}") from error
        if self.decimal is not None and self.decimal == self.thousands:
            raise ValueError(f"decimal and thousands are both {self.decimal!r}; they must differ")
        if self.rate is not None and (self.time is not None or self.time_unit is not None):
            raise ValueError("rate and time state two clocks; leave one of them out")
        rising = [line for line in (self.first_row, self.last_row) if line is not None]
        if rising != sorted(rising):
            raise ValueError(f"first_row = {self.first_row} must be at most last_row = {self.last_row}")
        return self


UNSAID = TableChoices.stated()
"""The user says nothing."""
