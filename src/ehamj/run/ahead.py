"""What it takes to look at an instant before its time, without a trace: memory of one's own, noise that is kept."""

from dataclasses import replace

import numpy as np

from ehamj.arrays import Array
from ehamj.control.loop import DigitalLoop
from ehamj.control.noise import ReadingNoise
from ehamj.run.prepare import Prepared


def twin_of(loop: DigitalLoop) -> DigitalLoop:
    """A loop that remembers for itself."""
    law, readings = ([part.copy() for part in memory] for memory in (loop.law_memory, loop.readings))
    return replace(loop, law_memory=type(loop.law_memory)(*law), readings=type(loop.readings)(*readings))


def remember(loop: DigitalLoop, twin: DigitalLoop) -> None:
    """Let a twin remember what a loop does."""
    for own, its in ((loop.law_memory, twin.law_memory), (loop.readings, twin.readings)):
        for source, target in zip(own, its, strict=True):
            target[:] = source


class NoiseAhead:
    """Noise of readings, of which that of the next sample may be heard before it is taken."""

    def __init__(self, prepared: Prepared) -> None:
        self._noise: ReadingNoise | None = prepared.noise
        self._next: Array | None = None

    def take(self, samples: int) -> Array | None:
        """That of the next samples."""
        if self._noise is None or samples == 0:
            return None
        ahead, self._next = self._next, None
        if ahead is None:
            return self._noise.take(samples)
        return np.concatenate([ahead, self._noise.take(samples - 1)]) if samples > 1 else ahead

    def ahead(self, samples: int) -> Array | None:
        """That of the next sample, which is still to be taken."""
        if self._noise is not None and samples and self._next is None:
            self._next = self._noise.take(1)
        return self._next if samples else None
