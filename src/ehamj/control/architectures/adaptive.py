"""Adaptive cancellation of lines: motion at motors' frequencies is driven to nothing, though they slip and drift.

For each line ω and motion the mounts are asked for a piston velocity Re x, which learns from the measured velocity e,

    ẋ = (jω − 1/``leak``)·x − (2/``time``)·e/H,

H the response at the line from piston velocity to e, as the model has it: filtered-x LMS (Widrow and Stearns, Adaptive
Signal Processing, 1985, ch. 11) with a step normalised by H, so that every motion comes down in the same ``time``. At a
line that stays, that is a resonator (Glover, IEEE Trans. ASSP 25(6), 1977): the one of
`ehamj.control.architectures.resonant`, with the gain ``leak``/``time`` and ζ = 1/(``leak``·ω). What a resonator does
not do: ω follows the line within its range, and nothing is learnt while a command fades or is limited
(`ehamj.control.compiled.lines`).
"""

from itertools import pairwise
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.control.architectures.resonant import LineSettings, Resonance
from ehamj.control.lines import Line
from ehamj.settings import Positive


class AdaptiveSettings(LineSettings):
    """Cancellation of lines whose frequency is only nearly known, or drifts."""

    kind: Literal["adaptive"] = "adaptive"
    time: Positive = Field(0.3, description="time in which a line comes down by e [s]")
    leak: Positive = Field(
        15.0, description="time over which what was learnt is forgotten [s]; a line comes down to 1/(1 + leak/time)"
    )
    drift: Annotated[float, Field(ge=0, lt=0.5)] = Field(
        0.02, description="share by which a line may be off its frequency, within which it is followed [-]; 0: not"
    )
    pace: Positive = Field(1.0, description="time over which a line's frequency is followed [s]; at least 3 times time")

    @model_validator(mode="after")
    def _apart(self) -> Self:
        if self.pace < 3.0 * self.time:
            raise ValueError(f"pace = {self.pace:g} s must be at least 3 times time = {self.time:g} s")
        for line in self.lines:
            if line * self.time < 1.0:
                raise ValueError(
                    f"time = {self.time:g} s must be at least a period of each line, {1.0 / line:g} s at {line:g} Hz"
                )
        if self.leak < self.time:
            raise ValueError(f"leak = {self.leak:g} s must be at least time = {self.time:g} s")
        for low, high in pairwise(sorted(self.lines)):
            if low * (1.0 + self.drift) >= high * (1.0 - self.drift):
                raise ValueError(
                    f"lines = {low:g} and {high:g} Hz are both followed where their ranges meet, ± {self.drift:g} of "
                    "each; state a smaller drift"
                )
        return self

    def resonance(self, line: float) -> Resonance:
        return Resonance(self.leak / self.time, 1.0 / (2.0 * np.pi * line * self.leak))

    def followed(self, pairs: int) -> tuple[Line, ...]:
        firsts = (2 * pairs * k for k in range(len(self.lines)))
        return tuple(
            Line(first, pairs, line, line * (1.0 - self.drift), line * (1.0 + self.drift), self.time, self.pace)
            for first, line in zip(firsts, self.lines, strict=True)
        )
