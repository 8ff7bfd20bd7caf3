"""A floor of several machines that stand on it one beside the other in time: built once, and sampled once."""

import math
import threading
from collections import OrderedDict
from typing import Any, Final

import numpy as np

from ehamj.arrays import Array
from ehamj.ground.motion import GroundSample, GroundSettings, Motion, Start

ROOM: Final = 16e6
"""What a floor keeps of what it was asked for, for those who have not asked yet [byte]: a minute of stretches takes
more, but runs beside each other are rarely further apart."""
LASTING: Final = 32e6
"""What a floor keeps that is asked for again and again [byte]: some seconds of it."""
FLOORS: Final = 4
"""Floors that are kept, of those for which there are always more runs."""


class Floors:
    """Floors of so many runs: those of one ground, under one plan, of one seed are one.

    Without a number of runs there are always more, one after the other: the last `FLOORS` are kept, and what was asked
    for of each as far as there is room (`LASTING`). A floor that reads a file must not be one of them: it may change.
    """

    def __init__(self, runs: int | None) -> None:
        self._runs, self._lock = runs, threading.Lock()
        self._known: list[tuple[tuple[Any, ...], SharedMotion]] = []

    def motion(self, ground: GroundSettings, start: Start) -> Motion:
        """The ground's motion; raises as `GroundSettings.motion` does."""
        key = (ground, start.mounts, start.positions.tobytes(), start.duration, start.seed, start.upstream, start.part)
        with self._lock:  # who comes second waits for the first, and has it built already
            found = next((floor for known, floor in self._known if known == key), None)
            if found is None:
                found = SharedMotion(ground.motion(start), self._runs)
                self._known.append((key, found))
                if self._runs is None:
                    del self._known[:-FLOORS]
        return found


class SharedMotion:
    """A motion that several runs sample at the same times: who asks second is given what the first one got.

    The arrays it gives are read-only. What all have asked for is forgotten; what some have not is kept as far as there
    is room, and computed anew else.
    """

    def __init__(self, motion: Motion, runs: int | None) -> None:
        self._motion, self._lock = motion, threading.Lock()
        self._runs, self._room = math.inf if runs is None else runs, LASTING if runs is None else ROOM
        self._kept: OrderedDict[bytes, _Kept] = OrderedDict()

    def sample(self, time: Array) -> GroundSample:
        """The motion at ``time`` [s], shape (n,)."""
        if self._runs < 2:
            return self._motion.sample(time)
        key = np.asarray(time, float).tobytes()
        with self._lock:
            kept = self._kept.setdefault(key, _Kept())
            kept.asked += 1
            if kept.asked >= self._runs:
                self._kept.pop(key)
        with kept.lock:  # two that ask at once: one computes
            if kept.sample is None:
                kept.sample = self._motion.sample(time)
                for part in kept.sample:
                    part.flags.writeable = False
            found = kept.sample
        self._forget()
        return found

    def _forget(self) -> None:
        """Drop the oldest of what is kept until the rest has room."""
        with self._lock:
            sizes = [kept.size for kept in self._kept.values()]
            while sum(sizes) > self._room:
                self._kept.popitem(last=False)
                sizes.pop(0)

    @property
    def at_rest(self) -> bool:
        return self._motion.at_rest

    @property
    def notes(self) -> tuple[str, ...]:
        return self._motion.notes

    @property
    def usable_to(self) -> float:
        return self._motion.usable_to

    @property
    def usable_from(self) -> float:
        return self._motion.usable_from


class _Kept:
    """What was asked for at some times, by how many."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.asked = 0
        self.sample: GroundSample | None = None

    @property
    def size(self) -> int:
        """Bytes of it and of the times that name it."""
        return 0 if self.sample is None else sum(part.nbytes for part in self.sample) * 10 // 9
