"""What a user writes about criteria: the table [criteria] of a scenario."""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from ehamj.criteria import vc
from ehamj.criteria.curves import Norm
from ehamj.criteria.norms import NORMS
from ehamj.criteria.response_spectrum import frequencies
from ehamj.estimate.statistics import BandStatistic
from ehamj.records.table_choices import TableChoices
from ehamj.settings import FileName, Settings

if TYPE_CHECKING:
    NormName = str
else:
    NormName = Literal[tuple(NORMS)]

ENDING: Final = r"\.[A-Za-z][A-Za-z0-9]{0,4}$"
"""How an entry ends that is a file and no norm's name."""


def _ending(name: str) -> str:
    if not re.search(ENDING, name):
        raise ValueError("the file with own limits by its name and ending, such as limits.csv")
    return name


LimitsFile = Annotated[
    FileName,
    AfterValidator(_ending),
    Field(json_schema_extra={"pattern": ENDING}, description="table of limits, relative to the scenario's folder"),
]


class ResponseSpectrumSettings(Settings):
    """Response spectra of floor, machine and points; they cost computing time."""

    damping: float = Field(0.05, gt=0, lt=1, description="damping ratio of the oscillators [-]")
    first: float = Field(1.0, gt=0, description="lowest natural frequency [Hz]")
    last: float = Field(100.0, gt=0, description="highest natural frequency, at most record_rate/10 [Hz]")
    per_octave: Literal[3, 6, 12, 24] = Field(3, description="natural frequencies per octave")

    @model_validator(mode="after")
    def _order(self) -> Self:
        if self.last < self.first:
            raise ValueError(f"last = {self.last:g} Hz must be at least first = {self.first:g} Hz")
        if not frequencies(self.first, self.last, self.per_octave).size:
            raise ValueError(
                f"no natural frequency lies from first = {self.first:g} Hz to last = {self.last:g} Hz, with "
                f"{self.per_octave} per octave from 1 Hz on; widen it"
            )
        return self


class CriteriaSettings(Settings):
    """Criteria by which floor and machine are judged."""

    norms: tuple[NormName | LimitsFile, ...] = Field(
        ("vc", "nist-a", "iso-2631-2"),
        description="norms that are judged, the first of which gives the verdict: names, or files with own limits, "
        "such as limits/spindle.csv: a column 'band [Hz]' (third-octave centres) or 'frequency [Hz]' (points of a "
        "curve), then a column with its unit per class, and above, where they are no RMS, a line '# statistic: peak', "
        "max_1s, slow, fast, l10, l50 or l90; limits of a peak go with the frequency of its swing, and one row holds "
        "for all",
        min_length=1,
    )
    low_frequency: vc.LowFrequency = Field(
        "classic",
        description="VC curves at low frequency: constant acceleration from 4 to 8 Hz, or VC-C and stricter flat from "
        "1 Hz",
    )
    statistic: BandStatistic = Field(
        "rms",
        description="level that is held against limits of RMS in bands: RMS over the whole run, largest sliding 1 s "
        "RMS, largest slow (1 s) or fast (0.125 s) weighted level, or the 1 s RMS exceeded for 10, 50 or 90 % of the "
        "time; limits of a peak keep the peak",
    )
    table: TableChoices | None = Field(
        None, description="how the files with own limits are written, where they do not show it; as ground.table"
    )
    response_spectrum: ResponseSpectrumSettings | None = Field(
        None, description="response spectra (none where the table is left out)"
    )

    @model_validator(mode="after")
    def _once(self) -> Self:
        if len(set(self.norms)) < len(self.norms):
            raise ValueError(f"norms = {list(self.norms)} must name each norm once")
        names = [Path(name).name for name in self.norms]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"norms = {list(self.norms)} names two files {twice!r}; rename one of them")
        return self

    def chosen(self) -> dict[str, Norm]:
        """The norms by name (of a file without its folder), the one of the verdict first.

        Raises:
            InputError: if a file with limits cannot be used.
        """
        return {Path(name).name: self.norm(name) for name in self.norms}

    def norm(self, name: str) -> Norm:
        """One of the norms, by its entry; see `chosen`."""
        if name not in NORMS:
            from ehamj.criteria.own import own_norm

            return own_norm(name, self.statistic, self.table)
        norm = NORMS[name].practices.get(self.low_frequency, NORMS[name])
        return norm if self.statistic == "rms" else norm.by(self.statistic)
