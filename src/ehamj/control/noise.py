"""Noise and drift of the readings of instruments."""

import math
from functools import cache
from typing import Final

import numpy as np
import scipy

from ehamj.arrays import Array
from ehamj.control.compiled.noise import FACTORS, compiled_noise
from ehamj.control.instruments import NOISE, Instrument, randomness
from ehamj.control.sensors import Sensors

NUMBERS: Final = 3
"""Random numbers for each reading: for its white noise, its rising noise, its walk."""


class ReadingNoise:
    """Noise and drift of the readings, sample after sample; the same whatever the lengths asked for."""

    def __init__(self, channels: tuple[str, ...], sensors: Sensors, seed: int, period: float) -> None:
        self._source = channels, sensors, seed, period
        known = ((k, sensors.of(name), name) for k, name in enumerate(channels))
        # What is silent draws nothing: each channel has random numbers of its own.
        noisy = {
            k: (sensor, randomness(seed, name, NOISE))
            for k, sensor, name in known
            if sensor is not None and (sensor.noise, sensor.drift, sensor.random_walk) != (0.0, 0.0, 0.0)
        }
        low_passes = {k: _low_pass(sensor.order, 2.0 * sensor.high * period) for k, (sensor, _) in noisy.items()}
        most = max(map(len, low_passes.values()), default=0)
        self._random, self._period, self._done = {k: random for k, (_, random) in noisy.items()}, period, 0
        self._factors, self._levels = np.zeros((len(channels), len(FACTORS))), np.zeros((len(channels), 2))
        self._sections, self._filtered = np.zeros((len(channels), most, 6)), np.zeros((len(channels), most, 2))
        self._counts = np.full(len(channels), -1, np.int64)
        for k, (sensor, random) in noisy.items():
            self._counts[k] = len(low_passes[k])
            self._sections[k, : self._counts[k]] = low_passes[k]
            self._factors[k], self._levels[k, 0] = _start(sensor, random, period)

    def alike(self, other: "ReadingNoise") -> bool:
        """Whether another one, of which as many samples were taken, or none, gives the same."""
        return self is other or self._source == other._source

    @property
    def silent(self) -> bool:
        """Whether there is none at all."""
        return not self._random

    def take(self, samples: int, found: Array | None = None) -> Array:
        """The next samples, (samples, channels) in the channels' units; put into ``found`` where it is given, which
        must be zero."""
        found = np.zeros((samples, self._counts.size)) if found is None else found
        drawn = np.empty((self._counts.size, samples, NUMBERS))
        for k, random in self._random.items():
            random.standard_normal(out=drawn[k])
        tables = (self._factors, self._sections, self._counts, self._levels, self._filtered)
        compiled_noise()(drawn, self._done, self._period, *tables, found)
        self._done += samples
        return found


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
