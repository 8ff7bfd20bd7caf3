"""What is wrong with a channel by itself, before any model is asked: dead, clipped, coarse; or looks odd: hum."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import scipy

from ehamj.arrays import Array
from ehamj.ground.doubts import clipped_samples

FEWEST_STEPS: Final = 8
"""Steps of its converter that a channel must pass through, 3 bit: fewer are those of a wire that is off."""
DWELL: Final = 3.0
"""Samples at the extreme value over those one step below it that look clipped: at the top of a slow swing there are up
to 1/(√2 − 1) = 2.4 times as many, and fewer with each step below; of noise there are fewer at the top than below it."""
BY_CHANCE: Final = 6
"""Samples at the extreme value that a single swing may leave there beyond that."""
STEPS_LOOKED_AT: Final = 20_000
"""Samples of which the steps are looked for."""
MAINS: Final = (50.0, 60.0)
"""[Hz]"""
STANDS_OUT: Final = 100.0
"""Power of a line over that of its neighbours from which it is told, 20 dB."""


@dataclass(frozen=True)
class Fault:
    """What is wrong with a channel, by the word that lets it pass in ``accept``."""

    word: str
    said: str


def resolution(samples: Array) -> float | None:
    """Step of the converter, where neighbouring values are a whole number of one step apart; None where they are not.

    Rounding of numbers that a file writes with six digits or more hides no step of 16 bit.
    """
    values = np.unique(samples[:STEPS_LOOKED_AT])
    steps = np.diff(values)
    if steps.size == 0:
        return None
    fine = 1e-9 * max(abs(float(values[0])), abs(float(values[-1])))
    steps = steps[steps > fine]
    if steps.size == 0:
        return None
    least = float(steps.min())
    whole = float(np.mean(steps[steps < 1.5 * least]))
    counts = np.rint(steps / whole)
    if np.abs(steps / whole - counts).max() > 0.1:
        return None
    return float(steps.sum() / counts.sum())


def faults(samples: Array) -> list[Fault]:
    """What is wrong with a channel's samples (n,)."""
    span = float(np.ptp(samples))
    if span == 0.0:
        return [Fault("dead", f"never changes, it stands at {samples[0]:g}")]
    step = resolution(samples)
    if step is not None and span / step < FEWEST_STEPS:
        steps = round(span / step)
        return [Fault("coarse", f"has {steps} step{'s' * (steps != 1)} of its converter in all: it is dead, or its "
                                "range is far too wide")]  # fmt: skip
    clipped = clipped_share(samples, step)
    return [Fault("clipped", f"is clipped: {100.0 * clipped:.2g} % of its samples stand at its extremes")] * (
        clipped > 0
    )


def clipped_share(samples: Array, step: float | None = None) -> float:
    """Share of the samples that clipping left at the largest or the smallest value; 0 where they only turn there."""
    if not clipped_samples(samples):
        return 0.0
    found = 0
    step = step or 1e-6 * float(np.ptp(samples))
    for signed in (samples, -samples):
        below = signed.max() - signed
        levels = np.bincount(np.minimum(np.rint(below[below < 2.5 * step] / step), 2).astype(np.int64), minlength=3)
        top, second, third = map(int, levels)
        rises = third >= second and top >= 2 * (second + BY_CHANCE)
        if rises or top >= DWELL * second + BY_CHANCE:
            found += top
    return found / samples.size


def hum(samples: Array, rate: float) -> float | None:
    """Frequency of a line of the mains that stands out of what is beside it [Hz], None where there is none."""
    if samples.size < 4 * rate / 10.0:  # neighbours within 10 Hz need lines that are apart
        return None
    power = np.abs(scipy.fft.rfft((samples - samples.mean()) * np.hanning(samples.size))) ** 2
    frequency = np.arange(power.size) * rate / samples.size
    for mains in MAINS:
        apart = np.abs(frequency - mains)
        at, beside = apart < max(0.3, 2.5 * rate / samples.size), (apart > 2.0) & (apart < 10.0)
        if mains < 0.4 * rate and beside.sum() > 8 and power[at].max() > STANDS_OUT * power[beside].mean():
            return mains
    return None
