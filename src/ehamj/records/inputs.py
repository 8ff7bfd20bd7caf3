"""What a rig was driven with, as its logger wrote it, in place of a signal that is made."""

from pathlib import Path
from typing import Literal

from pydantic import Field

from ehamj.errors import InputError
from ehamj.records.choices import Reading
from ehamj.records.picked import Pick, Series, read_picked
from ehamj.records.units import Kind
from ehamj.series import Replayed, Stairs, Straight
from ehamj.settings import FileName, Positive
from ehamj.signals import Signal

Hold = Literal["smooth", "straight", "held"]


class RecordedInput(Reading):
    """A component of a record that drives the machine."""

    file: FileName = Field(
        min_length=1, description="record, relative to the scenario's folder, in any format that ground.file takes"
    )
    component: str | None = Field(
        None, description="component by its name or its number in the file; without: the only one that there is"
    )
    unit: str | None = Field(
        None,
        description="unit of the samples where the file states none, or what 1 V or one count of them stands for; "
        "'SI': they are SI",
    )
    full_scale: Positive | None = Field(None, description="what the largest sample of a WAV file stands for [unit]")
    scale: float = Field(1.0, description="factor on the samples; negative turns their sign [-]")
    start: float | None = Field(
        None,
        description="time on the file's clock at which the simulation begins; without: where the component begins [s]",
    )
    delay: float = Field(
        0.0, description="by how much later than recorded it acts, or earlier; what lies before or behind what was "
        "recorded of it holds the first or last sample [s]"
    )  # fmt: skip
    hold: Hold = Field(
        "smooth",
        description="between samples: smooth, a spline, as of what was sampled fast enough; straight lines; or held, "
        "as a converter holds what it gives",
    )

    def series(self, kind: Kind, what: str, key: str) -> Series:
        """What the file holds, in SI of ``kind``; ``key`` is the table's own, for messages.

        Raises:
            InputError: as `read_picked`.
        """
        pick = Pick(key, kind, what, self.component, self.unit, self.full_scale)
        return read_picked(Path(self.file), (pick,), self, key)[0]

    def replayed(self, kind: Kind, what: str, key: str, duration: float) -> Signal:
        """What it drives with from time 0 for ``duration`` [s], in SI of ``kind``.

        Raises:
            InputError: as `read_picked`, and where the record does not last as long.
        """
        found = self.series(kind, what, key)
        begin = found.time if self.start is None else self.start
        if begin < found.time - 1e-9 or begin + duration > found.end + 1e-9:
            raise InputError(
                f"{key}.start = {begin:g} s and the duration, {duration:g} s, ask for {begin:g} to "
                f"{begin + duration:g} s, but {found.component} of {Path(self.file).name!r} lasts from {found.time:g} "
                f"to {found.end:g} s"
            )
        return Replayed(self._between(found), self.scale, self.delay - begin)

    def _between(self, found: Series) -> Signal:
        if self.hold == "smooth":
            return found.smooth
        return (Straight if self.hold == "straight" else Stairs)(found.rate, found.samples, found.time)
