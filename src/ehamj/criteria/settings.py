"""What a user writes about criteria: the table [criteria] of a scenario."""

from typing import TYPE_CHECKING, Literal, Self

from pydantic import Field, model_validator

from ehamj.criteria import vc
from ehamj.criteria.curves import Norm
from ehamj.criteria.norms import NORMS
from ehamj.estimate.statistics import BandStatistic
from ehamj.settings import Settings

if TYPE_CHECKING:
    NormName = str
else:
    NormName = Literal[tuple(NORMS)]


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
        return self


class CriteriaSettings(Settings):
    """Criteria by which floor and machine are judged."""

    norms: tuple[NormName, ...] = Field(
        ("vc", "nist-a", "iso-2631-2"), description="norms that are judged; the first gives the verdict", min_length=1
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
    response_spectrum: ResponseSpectrumSettings | None = Field(
        None, description="response spectra (none where the table is left out)"
    )

    @model_validator(mode="after")
    def _once(self) -> Self:
        if len(set(self.norms)) < len(self.norms):
            raise ValueError(f"norms = {list(self.norms)} must name each norm once")
        return self

    def chosen(self) -> dict[str, Norm]:
        """The norms by name, the one of the verdict first."""
        norms = {name: NORMS[name].practices.get(self.low_frequency, NORMS[name]) for name in self.norms}
        return {name: norm.by(self.statistic) for name, norm in norms.items()} if self.statistic != "rms" else norms
