"""A controller's loop stepped without a machine: what it commands from given signals."""

from collections.abc import Sequence

import numpy as np

from ehamj.arrays import Array
from ehamj.compiled.kept import compiled
from ehamj.control.compiled.laws import AT_ONCE, convert_held, release, take_sample
from ehamj.control.compiled.sensing import read_sensors
from ehamj.control.loop import DigitalLoop

STEP = 1e-4
"""Step of the integrator that there is none of [s]."""


@compiled
def steps(laws, memory, sensing, readings, signals, noise, found, lanes):  # type: ignore[no-untyped-def]
    """What the stepping loop does with a controller."""
    control = np.zeros(found.shape[1] // 4)
    for k in range(found.shape[0]):
        release(k, laws, memory, control, lanes)
        read_sensors(k, k // laws.base if k % laws.base == 0 else -1, sensing, noise, signals[k], readings, lanes)
        if take_sample(k, k * STEP, laws, readings.readings, memory, lanes) == AT_ONCE:
            convert_held(k, laws, memory, control, lanes)
        for i in range(control.size):
            found[k, i] = control[i]
        for i in range(memory.switching.size):
            found[k, control.size + i] = memory.switching[i]


def run(loop: DigitalLoop, signals: Array, noise: Array, width: int = 1) -> Array:
    """Commands in each step, and what switches within it add at its start, middle and end, (step, 4·valve·lane).

    From signals (step, signal·lane) and noise (sample, channel·lane).
    """
    found = np.empty((signals.shape[0], 4 * 4 * width))
    steps(loop.laws, loop.law_memory, loop.sensing, loop.readings, signals, noise, found, (0.0,) * width)
    return found


def together(parts: Sequence[Array]) -> Array:
    """Tables (row, entry) of each lane as one of all (row, entry·lane)."""
    return np.ascontiguousarray(np.stack(parts, axis=2).reshape(parts[0].shape[0], -1))
