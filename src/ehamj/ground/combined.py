"""Several ground motions at once: a record, a line and a shock add up."""

from dataclasses import dataclass

import numpy as np

from ehamj.ground.motion import GroundSample, Motion
from ehamj.signals import Array


@dataclass(frozen=True)
class Combined:
    """The sum of several motions, ``factor`` times as large; ``note`` says what it is."""

    parts: tuple[Motion, ...]
    factor: float = 1.0
    note: str | None = None

    @property
    def at_rest(self) -> bool:
        return all(part.at_rest for part in self.parts)

    @property
    def notes(self) -> tuple[str, ...]:
        said = tuple(note for part in self.parts for note in part.notes)
        return said if self.note is None else (self.note, *dict.fromkeys(said))

    @property
    def usable_to(self) -> float:
        return min(part.usable_to for part in self.parts)

    def sample(self, time: Array) -> GroundSample:
        total = self.parts[0].sample(time)
        for part in self.parts[1:]:
            for whole, own in zip(total, part.sample(time), strict=True):
                np.add(whole, own, out=whole)
        return total if self.factor == 1 else GroundSample(*(self.factor * part for part in total))
