"""A force that was measured, as by the load cell of a hammer or a shaker."""

from typing import Literal

import numpy as np
from pydantic import Field

from ehamj.forces.force import ForceSettings
from ehamj.records.inputs import RecordedInput
from ehamj.settings import Fade
from ehamj.signals import Array, Signal, faded

KEY = "force"
"""Of the table, in messages."""
WHAT = "[[force]]"


class RecordedForce(RecordedInput, ForceSettings):
    """What a load cell wrote."""

    kind: Literal["recorded"]
    fade_in: Fade = Field(0.0, description="time over which the force fades in [s]")

    @property
    def longest_step(self) -> float:
        return 1.0 / self.series("force", WHAT, KEY).rate

    def parts(self, duration: float, random: np.random.Generator) -> list[tuple[Array, Signal]]:
        return [(self.axis, faded(self.replayed("force", WHAT, KEY, duration), self.fade_in))]
