"""How a modal test is done: band, resolution and duration, from a first look at the computed modes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from ehamj.arrays import Array, ComplexArray
from ehamj.errors import InputError
from ehamj.estimate.identification import Estimates, oscillating
from ehamj.linear.modes import Mode

MOST_LINES: Final = 1500
LONGEST_STEP: Final = 1e-4
"""Integration step [s] for modes up to about 600 Hz; its error there is 2e-4 of the frequency, by the fourth power."""
FOLLOWED: Final = 900.0
"""Highest frequency of a band [Hz] up to which that step serves."""
HIGHEST_DAMPING: Final = 0.5
"""Damping ratio above which a pole is no mode to identify."""
DECAYED: Final = 14.0
"""Time constants after which a motion counts as over: 1e-6 is left."""


@dataclass(frozen=True)
class Plan:
    """Settings of a measurement: band [Hz], spacing of its lines [Hz], decay rate of the slowest mode [1/s]."""

    low: float
    high: float
    spacing: float
    decay: float

    @classmethod
    def of(cls, computed: Sequence[Mode]) -> "Plan":
        """For the modes that were computed.

        Raises:
            InputError: if they lie too far apart for one measurement.
        """
        frequencies = [mode.frequency for mode in computed]
        # Two lines or so within the half-power width 2ζf of the sharpest mode.
        sharpest = min(2.0 * mode.damping_ratio * mode.frequency for mode in computed)
        spacing = 1.0 / math.ceil(1.0 / (0.6 * sharpest) * 100.0) * 100.0 if sharpest < 60.0 else 40.0
        low = max(spacing, 0.4 * min(frequencies))
        high = 1.45 * max(frequencies)
        decay = min(2 * np.pi * mode.damping_ratio * mode.frequency for mode in computed)
        if (high - low) / spacing > MOST_LINES:
            raise InputError(
                f"the machine's modes, {min(frequencies):.3g} to {max(frequencies):.3g} Hz with half-power widths down "
                f"to {sharpest:.3g} Hz, need {(high - low) / spacing:.0f} lines; one measurement has up to {MOST_LINES}"
            )
        return cls(low, high, spacing, decay)

    @property
    def step(self) -> float:
        """Integration step, and recording period of responses [s]."""
        return LONGEST_STEP / math.ceil(self.high / FOLLOWED)

    @property
    def lines(self) -> Array:
        """Lines of the band [Hz], multiples of the spacing."""
        first, last = math.ceil(self.low / self.spacing), math.floor(self.high / self.spacing)
        return self.spacing * np.arange(first, last + 1, dtype=np.float64)

    @property
    def over(self) -> float:
        """Time in which a motion dies out, in whole periods of the lines [s]."""
        return math.ceil(DECAYED / self.decay * self.spacing) / self.spacing

    def within(self, poles: ComplexArray, shapes: ComplexArray) -> Estimates:
        """The oscillations of a fit that lie in the band."""
        found = oscillating(poles, shapes, 2 * np.pi * self.low)
        size = np.abs(found.poles)
        kept = (size < 2 * np.pi * self.high) & (-found.poles.real < HIGHEST_DAMPING * size)
        return Estimates(found.poles[kept], found.shapes[:, kept])


def with_noise(signals: Array, share: float, *seed: int) -> Array:
    """Signals (…, channel) with white noise of a share of each channel's RMS."""
    if share == 0.0:
        return signals
    random = np.random.default_rng(list(seed)).normal(size=signals.shape)
    rms = np.sqrt(np.mean(signals**2, axis=tuple(range(signals.ndim - 1))))
    return np.asarray(signals + share * rms * random)
