"""What a norm says of one place along one axis: the class met, what decides, and by how much."""

from collections.abc import Sequence
from typing import Final

from pydantic import Field

from ehamj.estimate.statistics import Statistic
from ehamj.findings import Finding
from ehamj.records.units import Quantity

WHOLE: Final = "all"
"""What stands for a band where the whole history decides."""
REST_DB: Final = 100.0
"""Margin above which nothing moves that anybody would call a vibration [dB]."""
REST: Final = 1e-12
"""RMS velocity in a band below which that is so by any limit [m/s]: ten times the rounding of a simulation."""


class Verdict(Finding):
    """The strictest class met in the bands that are known (None: not even the coarsest).

    A level exactly at its limit meets the class. ``margin_db`` is what the class met leaves in its deciding band, the
    one with the least; None where nothing moves or no class is met. ``excess_db`` is by how much the next stricter
    class is exceeded at worst, in ``next_band``. ``decided``: every band that could decide is known. Those are the
    bands in which the class met, or a coarser one, has a limit; where even the coarsest is not met, none is left.
    A band is named `WHOLE` where a limit of the whole history decides.
    """

    met: str | None = Field(alias="class")
    decided: bool
    deciding_band: str | None = Field(alias="deciding_band_hz")
    margin_db: float | None
    next_class: str | None
    next_band: str | None = Field(alias="next_band_hz")
    excess_db: float | None
    undecided: tuple[str, ...] = Field(alias="undecided_bands_hz")
    """Bands that could decide, and in which the level is not known."""
    bands: int | None = None
    """How many bands there are that could decide, known or not; None in a result that is older."""
    factor: float | None = None
    """Largest level over the norm's base curve, for a norm that has one."""
    statistic: Statistic | None = None
    """Of the levels that decided; None where nothing did and the norm has several, or in a result that is older."""
    peak: float | None = None
    """Where a limit of the peak decided: that of the swing that came nearest to it [SI]."""
    peak_hz: float | None = None
    """Frequency of that swing [Hz], where the limit depends on it; None: not clear, and the strictest value counted."""
    level: float | None = None
    """In the deciding band [SI, of ``quantity``]; None where a peak decided or nothing, and in older results."""
    limit: float | None = None
    """Of the class met, or of the coarsest where none is, in that band [SI]."""
    quantity: Quantity | None = None
    """Of level and limit."""

    @property
    def at_rest(self) -> bool:
        """Whether nothing moves that anybody would call a vibration."""
        if self.met is None:
            return False
        still = self.quantity == "velocity" and self.level is not None and self.level <= REST
        return still or self.margin_db is None or self.margin_db > REST_DB


def where(bands: Sequence[str]) -> str:
    """Bands of a verdict in words: "at 4, 5 Hz"."""
    return "over all frequencies" if WHOLE in bands else f"at {', '.join(bands)} Hz"
