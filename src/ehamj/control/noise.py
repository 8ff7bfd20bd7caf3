"""Noise and drift of the readings of instruments."""

import math
import threading
from functools import cache, cached_property
from typing import Final, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ehamj.arrays import Array
from ehamj.control.compiled.noise import FACTORS, compiled_noise
from ehamj.control.instruments import NOISE, Instrument, randomness
from ehamj.control.sensors import Sensors

NUMBERS: Final = 3
"""Random numbers for each reading: for its white noise, its rising noise, its walk."""
PASSED: Final = 2048
"""Samples that are drawn at once only to be passed over."""
ROOM: Final = 32e6
"""What is kept of noise for those who hear the same later [byte]: some seconds of a machine's."""


class ReadingNoise:
    """Noise and drift of the readings, sample after sample; the same whatever the lengths asked for."""

    def __init__(self, channels: tuple[str, ...], sensors: Sensors, seed: int, period: float) -> None:
        self._source = channels, sensors, seed, period
        known = ((k, sensors.of(name)) for k, name in enumerate(channels))
        # What is silent draws nothing: each channel has random numbers of its own.
        self._noisy = {
            k: sensor
            for k, sensor in known
            if sensor is not None and (sensor.noise, sensor.drift, sensor.random_walk) != (0.0, 0.0, 0.0)
        }
        self._done = self._behind = 0

    @cached_property
    def _begun(self) -> "_Begun":
        """What is known before the first sample; of runs that hear the same, one asks."""
        channels, _, seed, period = self._source
        low_passes = {k: _low_pass(one.order, 2.0 * one.high * period) for k, one in self._noisy.items()}
        begun = _Begun.of(len(channels), max(map(len, low_passes.values()), default=0))
        for k, sensor in self._noisy.items():
            random = begun.random[k] = randomness(seed, channels[k], NOISE)
            begun.counts[k] = len(low_passes[k])
            begun.sections[k, : begun.counts[k]] = low_passes[k]
            begun.factors[k], begun.levels[k, 0] = _start(sensor, random, period)
        return begun

    def alike(self, other: "ReadingNoise") -> bool:
        """Whether another one, of which as many samples were taken, or none, gives the same."""
        return self is other or self._source == other._source

    def pass_over(self, samples: int) -> None:
        """Go on behind so many samples, which somebody else has taken: they are drawn only if later ones are."""
        self._behind += samples

    @property
    def silent(self) -> bool:
        """Whether there is none at all."""
        return not self._noisy

    def take(self, samples: int, found: Array | None = None) -> Array:
        """The next samples, (samples, channels) in the channels' units; put into ``found`` where it is given, which
        must be zero."""
        while self._behind:
            passed = min(self._behind, PASSED)
            self._behind -= passed
            self._drawn(passed, np.zeros((passed, len(self._source[0]))))
        return self._drawn(samples, found)

    def _drawn(self, samples: int, found: Array | None) -> Array:
        channels, _, _, period = self._source
        found = np.zeros((samples, len(channels))) if found is None else found
        drawn = np.empty((len(channels), samples, NUMBERS))
        random, *tables = self._begun
        for k, own in random.items():
            own.standard_normal(out=drawn[k])
        compiled_noise()(drawn, self._done, period, *tables, found)
        self._done += samples
        return found


class Heard:
    """Noise that was taken from its first sample on, for runs that hear the same one after the other: that of one
    source, the last, as far as there is room."""

    def __init__(self) -> None:
        self._lock, self._size = threading.Lock(), 0
        self._first: ReadingNoise | None = None
        self._pieces: dict[tuple[int, int], Array] = {}

    def take(self, noise: ReadingNoise, first: int, samples: int) -> Array:
        """`ReadingNoise.take` of samples from the ``first`` on, which nobody is to change."""
        with self._lock:
            if self._first is None or not self._first.alike(noise):
                self._first, self._pieces, self._size = noise, {}, 0
            found = self._pieces.get((first, samples))
        if found is not None:
            noise.pass_over(samples)
            return found
        found = noise.take(samples)
        found.flags.writeable = False
        with self._lock:
            if self._first is not None and self._first.alike(noise) and self._size + found.nbytes <= ROOM:
                self._size += found.nbytes
                self._pieces[first, samples] = found
        return found


class _Begun(NamedTuple):
    """Random numbers of the channels that are not silent, and what the compiled noise takes and remembers of all."""

    random: dict[int, np.random.Generator]
    factors: Array
    """(channel, `FACTORS`)"""
    sections: Array
    """(channel, section, 6) of the low-passes."""
    counts: NDArray[np.int64]
    """(channel,) sections, −1 of what is silent."""
    levels: Array
    """(channel, 2) of the rising noise and the walk."""
    filtered: Array
    """(channel, section, 2)"""

    @classmethod
    def of(cls, channels: int, most: int) -> "_Begun":
        """Silent channels, with room for so many sections at most."""
        factors, sections = np.zeros((channels, len(FACTORS))), np.zeros((channels, most, 6))
        counts, levels = np.full(channels, -1, np.int64), np.zeros((channels, 2))
        return cls({}, factors, sections, counts, levels, np.zeros((channels, most, 2)))


def _start(sensor: Instrument, random: np.random.Generator, period: float) -> tuple[tuple[float, ...], float]:
    """`FACTORS` of a channel, and its rising noise before the first sample, drawn from its long-run spread; the walk
    begins at zero."""
    sign, decay = float(random.choice((-1.0, 1.0))), math.exp(-2.0 * np.pi * sensor.low * period)
    # Spread of what a sample adds to the rising noise: its density is then noise·noise_corner/f.
    kick = sensor.noise * sensor.noise_corner * 2.0 * np.pi * math.sqrt(0.5 * period)
    white, walk = sensor.noise * math.sqrt(0.5 / period), sensor.random_walk * math.sqrt(period)
    spread = kick / math.sqrt(1.0 - decay**2) if decay < 1.0 else 0.0
    return (white, kick, decay, walk, sign * sensor.drift), spread * random.standard_normal()


@cache
def _low_pass(order: int, corner: float) -> Array:
    """A low-pass with its corner at so many times half the sampling rate, as sections of second order (section, 6):
    none where the rate does not carry it."""
    return np.asarray(scipy.signal.butter(order, corner, output="sos")) if corner < 1.0 else np.zeros((0, 6))
