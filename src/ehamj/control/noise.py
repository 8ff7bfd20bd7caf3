"""Noise and drift of the readings of instruments."""

import math

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from ehamj.control.instruments import NOISE, Instrument, randomness
from ehamj.control.sensors import Sensors

Array = NDArray[np.float64]


class ReadingNoise:
    """Noise and drift of the readings, sample after sample; the same whatever the lengths asked for."""

    def __init__(self, channels: tuple[str, ...], sensors: Sensors, seed: int, period: float) -> None:
        self._sensors = [sensors.of(name) for name in channels]
        self._random = [randomness(seed, name, NOISE) for name in channels]
        self._period, self._done = period, 0
        self._passes = [None if sensor is None else self._low_pass(sensor) for sensor in self._sensors]
        self._signs = [float(random.choice((-1.0, 1.0))) for random in self._random]
        self._states = [
            np.zeros(2) if sensor is None else self._start(sensor, random)
            for sensor, random in zip(self._sensors, self._random, strict=True)
        ]

    @property
    def silent(self) -> bool:
        """Whether there is none at all."""
        return all(s is None or s.noise == s.drift == s.random_walk == 0.0 for s in self._sensors)

    def take(self, samples: int) -> Array:
        """The next samples, (samples, channels) in the channels' units."""
        found = np.zeros((samples, len(self._sensors)))
        times = (self._done + np.arange(samples)) * self._period
        for k, (sensor, random) in enumerate(zip(self._sensors, self._random, strict=True)):
            if sensor is not None:
                drawn = random.standard_normal((samples, 3))
                slow, walked, self._states[k] = self._accumulate(sensor, drawn, self._states[k])
                white = sensor.noise * math.sqrt(0.5 / self._period) * drawn[:, 0]
                low_pass = self._passes[k]
                electronic = white + slow if low_pass is None else low_pass.take(white + slow)
                found[:, k] = electronic + walked + self._signs[k] * sensor.drift * times
        self._done += samples
        return found

    def _start(self, sensor: Instrument, random: np.random.Generator) -> Array:
        """State before the first sample: of the rising noise drawn from its long-run spread, of the walk zero."""
        decay = math.exp(-2.0 * np.pi * sensor.low * self._period)
        spread = self._kick(sensor) / math.sqrt(1.0 - decay**2) if decay < 1.0 else 0.0
        return np.array([spread * random.standard_normal(), 0.0])

    def _low_pass(self, sensor: Instrument) -> "_LowPass | None":
        """The instrument's low-pass at the sampling rate, where that carries it."""
        corner = 2.0 * sensor.high * self._period
        return _LowPass(sensor.order, corner) if corner < 1.0 else None

    def _kick(self, sensor: Instrument) -> float:
        """Spread of what a sample adds to the rising noise: its density is then noise·noise_corner/f."""
        return sensor.noise * sensor.noise_corner * 2.0 * np.pi * math.sqrt(0.5 * self._period)

    def _accumulate(self, sensor: Instrument, drawn: Array, state: Array) -> tuple[Array, Array, Array]:
        decay = math.exp(-2.0 * np.pi * sensor.low * self._period)
        slow, _ = signal.lfilter([1.0], [1.0, -decay], self._kick(sensor) * drawn[:, 1], zi=[decay * state[0]])
        walked, _ = signal.lfilter(
            [1.0], [1.0, -1.0], sensor.random_walk * math.sqrt(self._period) * drawn[:, 2], zi=[state[1]]
        )
        last = np.array([slow[-1], walked[-1]]) if drawn.shape[0] else state
        return slow, walked, last


class _LowPass:
    """A Butterworth low-pass of ``order`` at ``corner`` (share of half the sampling rate), fed piece by piece."""

    def __init__(self, order: int, corner: float) -> None:
        self._sections = signal.butter(order, corner, output="sos")
        self._state = np.zeros((self._sections.shape[0], 2))

    def take(self, values: Array) -> Array:
        """The filtered values, (n,)."""
        if values.size == 0:
            return values
        filtered, self._state = signal.sosfilt(self._sections, values, zi=self._state)
        return np.asarray(filtered)
