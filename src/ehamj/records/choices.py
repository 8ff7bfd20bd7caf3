"""What the user says about a record: the keys that resolve what a file leaves open."""

from typing import Any, Literal, Self

from pydantic import Field, model_validator

from ehamj.records.channel import Place
from ehamj.records.table_choices import TableChoices
from ehamj.records.units import KNOWN, Quantity, motion_unit
from ehamj.settings import FileName, Positive, Settings

AxisChoice = dict[str, Place] | None
QuantityChoice = Literal["auto", "displacement", "velocity", "acceleration"]
GapChoice = Literal["error", "interpolate"]
ResponseChoice = Literal["stages", "sensitivity"]


class Reading(Settings):
    """What the user says about how a file is read, whatever is in it."""

    gaps: GapChoice = Field(
        "error", description="what to do about gaps: refuse the record, or fill with straight lines"
    )
    overlap: Literal["refuse", "first", "last"] = Field(
        "refuse",
        description="what to do where traces of a channel overlap and differ (seismic formats): refuse the record, or "
        "take the trace that begins first, or last",
    )
    damaged: Literal["refuse", "skip"] = Field(
        "refuse",
        description="what to do about damaged records of miniSEED and broken rows of tables: refuse the file, or "
        "leave them out, as gaps",
    )
    table: TableChoices | None = Field(
        None, description="how a table of text (*.csv, *.txt, …) is written, where the file does not show it"
    )


class Choices(Reading):
    """What the user says about a record."""

    quantity: QuantityChoice = Field(
        "auto",
        description="what the samples are (SI, but for unit); auto: as the file says (instrument's response, units)",
    )
    unit: str | None = Field(
        None, description=f"unit of the samples of a record that states none, in any spelling: {KNOWN}; default: SI"
    )
    full_scale: Positive | dict[str, Positive] | None = Field(
        None,
        description="motion that the largest sample of a WAV file stands for [unit]; a table by component or axis, as "
        "in { 1 = 2e-3, z = 5e-3 }, gives each its own (z serves 'front-left z' too, where nothing names that)",
    )
    inventory: FileName | None = Field(
        None,
        description="file with the instrument's response: StationXML, dataless or XML SEED, RESP, SeisComP XML, "
        "station text, or SAC poles and zeros",
    )
    remove_response: bool = Field(True, description="turn counts into motion; false: samples are SI (seismic formats)")
    axes: AxisChoice = Field(
        None,
        description="axis of each component, by its name or its number in the file, of a table its column's (E, EHE, "
        "BW.RJOB..EHE, CSV column, "
        "UFF direction z or node 12:+Z, WAV channel 1, MATLAB variable z or data.z, TDMS or IDE group/channel), or "
        "axis of one mount, by its name ('front-left z'); the others are left out; default: E, N, Z to x, y, z",
    )
    response: ResponseChoice | None = Field(
        None,
        description="which counts where the instrument's stages and its overall sensitivity disagree: the stages, or "
        "the sensitivity, to which their shape is scaled; default: neither, the record is refused",
    )

    @model_validator(mode="after")
    def _agreeing(self) -> Self:
        if self.inventory is not None and not self.remove_response:
            raise ValueError(
                f"inventory = {self.inventory!r} is of no use with remove_response = false; leave one of them out"
            )
        if self.user_unit is not None and self.quantity not in ("auto", self.user_unit[0]):
            raise ValueError(
                f"quantity = {self.quantity!r} is not what unit = {self.unit!r} is of; leave one of them out"
            )
        return self

    @property
    def user_unit(self) -> tuple[Quantity, float] | None:
        """Quantity and SI value of the unit that the user states."""
        try:
            return None if self.unit is None else motion_unit(self.unit)
        except ValueError as error:
            raise ValueError(f"unit = {error}") from None


SILENT = Choices.stated()
"""The user says nothing."""


class Picks(Choices):
    """What the program wants of a record that is no ground: readers show it all components, and it ``takes`` its own.

    ``axes`` only says to readers that components are named, and nothing is of an instrument whose response is known.
    """

    takes: Any = None
    """As `ehamj.records.picked.taking` makes it."""
