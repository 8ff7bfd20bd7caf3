"""Noise and drift of the readings of instruments."""

import math

import numpy as np
from scipy import signal

from ehamj.arrays import Array
from ehamj.control.instruments import NOISE, Instrument, randomness
from ehamj.control.sensors import Sensors


class ReadingNoise:
    """Noise and drift of the readings, sample after sample; the same whatever the lengths asked for."""

    def __init__(self, channels: tuple[str, ...], sensors: Sensors, seed: int, period: float) -> None:
        found = [(sensors.of(name), randomness(seed, name, NOISE)) for name in channels]
        self._channels = [None if sensor is None else _Channel(sensor, random, period) for sensor, random in found]

    @property
    def silent(self) -> bool:
        """Whether there is none at all."""
        sensors = [one.sensor for one in self._channels if one is not None]
        return all(sensor.noise == sensor.drift == sensor.random_walk == 0.0 for sensor in sensors)

    def take(self, samples: int) -> Array:
        """The next samples, (samples, channels) in the channels' units."""
        found = np.zeros((samples, len(self._channels)))
        for k, one in enumerate(self._channels):
            if one is not None and samples:
                found[:, k] = one.take(samples)
        return found


class _Channel:
    """Noise and drift of one reading."""

    def __init__(self, sensor: Instrument, random: np.random.Generator, period: float) -> None:
        self.sensor, self._random, self._period, self._done = sensor, random, period, 0
        self._sign = float(random.choice((-1.0, 1.0)))
        self._decay = math.exp(-2.0 * np.pi * sensor.low * period)
        # Spread of what a sample adds to the rising noise: its density is then noise·noise_corner/f.
        self._kick = sensor.noise * sensor.noise_corner * 2.0 * np.pi * math.sqrt(0.5 * period)
        # Before the first sample the rising noise is drawn from its long-run spread, and the walk is zero.
        spread = self._kick / math.sqrt(1.0 - self._decay**2) if self._decay < 1.0 else 0.0
        self._slow, self._walked = spread * random.standard_normal(), 0.0
        # The instrument's low-pass at the sampling rate, where that carries it.
        corner = 2.0 * sensor.high * period
        self._low_pass = signal.butter(sensor.order, corner, output="sos") if corner < 1.0 else None
        self._filtered = None if self._low_pass is None else np.zeros((self._low_pass.shape[0], 2))

    def take(self, samples: int) -> Array:
        """The next samples, at least one, (samples,)."""
        sensor, drawn = self.sensor, self._random.standard_normal((samples, 3))
        times = (self._done + np.arange(samples)) * self._period
        self._done += samples
        walk = sensor.random_walk * math.sqrt(self._period) * drawn[:, 2]
        slow, _ = signal.lfilter([1.0], [1.0, -self._decay], self._kick * drawn[:, 1], zi=[self._decay * self._slow])
        walked, _ = signal.lfilter([1.0], [1.0, -1.0], walk, zi=[self._walked])
        self._slow, self._walked = slow[-1], walked[-1]
        electronic = sensor.noise * math.sqrt(0.5 / self._period) * drawn[:, 0] + slow
        if self._low_pass is not None:
            electronic, self._filtered = signal.sosfilt(self._low_pass, electronic, zi=self._filtered)
        return np.asarray(electronic + walked + self._sign * sensor.drift * times)
