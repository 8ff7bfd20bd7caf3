"""What the sensors of a controller do in a step, compiled: channels from signals, filters, readings at a sample.

Arrays are flat, the lanes of a block of machines last: entry i of a lane is at ``i * len(lanes) + lane``.
"""

from typing import Any, NamedTuple

import numpy as np

from ehamj.compiled import copy, kernel
from ehamj.control.compiled.converter import converted
from ehamj.control.compiled.signals import Layout


class Sensing(NamedTuple):
    """The channels that a controller reads, and their instruments; layout, terms and order are those of all lanes."""

    layout: Layout
    """Of the vector of signals."""
    terms: Any
    weights: Any
    """Each channel as a short sum of signals: which (channel, term), and their factors (channel·term)."""
    order: int
    """States n of the longest filter; 0: none filters."""
    filters: Any
    """((n + 3)·n·channel): A row by row, then B, C and the resting state of every filter."""
    entries: Any
    """((n + 3)·n): whether an entry of these is other than zero in any channel; the rest is passed over."""
    feedthrough: Any
    zeroed: Any
    """One for a channel that counts from its value at the start, zero for the others."""
    gains: Any
    """Factor on each reading: one, unless the sensor has failed."""
    offsets: Any
    """What is added to it: zero, unless the sensor has failed."""
    limits: Any
    """Range of each reading."""
    resolutions: Any

    @property
    def channels(self) -> int:
        """How many are read."""
        return int(self.terms.shape[0])


class Readings(NamedTuple):
    """What the sensors remember: readings, the channels' values at the start, states of the filters; and scratch."""

    readings: Any
    rest: Any
    filters: Any
    raw: Any
    analogue: Any
    scratch: Any

    @classmethod
    def of(cls, sensing: Sensing) -> "Readings":
        """Memory for these sensors."""
        n, filters = sensing.gains.size, sensing.gains.size * sensing.order
        return cls(*(np.zeros(size) for size in (n, n, filters, n, n, filters)))


@kernel
def filter_row(own, row, states, result):  # type: ignore[no-untyped-def]
    """result += a row of every filter times its states."""
    size, n, filters, entries = result.size, own.order, own.filters, own.entries
    for j in range(n):
        if entries[row * n + j]:
            factors, state = filters[(row * n + j) * size : (row * n + j + 1) * size], states[j * size : (j + 1) * size]
            for c in range(size):
                result[c] += factors[c] * state[c]


@kernel
def filter_readings(own, raw, states, analogue, scratch):  # type: ignore[no-untyped-def]
    """One step of every sensor's filter: analogue readings, then the states (n·channels) at the next step."""
    size, n, filters, feedthrough = raw.size, own.order, own.filters, own.feedthrough
    for c in range(size):
        analogue[c] = feedthrough[c] * raw[c]
    filter_row(own, n + 1, states, analogue)
    for i in range(n):
        factors, row = filters[(n * n + i) * size : (n * n + i + 1) * size], scratch[i * size : (i + 1) * size]
        for c in range(size):
            row[c] = factors[c] * raw[c]
        filter_row(own, i, states, row)
    copy(scratch, states)


@kernel
def settle_filters(filters, n, raw, states):  # type: ignore[no-untyped-def]
    """Let every sensor rest at its channel's present value."""
    size = raw.size
    for i in range(n):
        for c in range(size):
            states[i * size + c] = filters[((n + 2) * n + i) * size + c] * raw[c]


@kernel
def combine(terms, weights, signals, raw, lanes):  # type: ignore[no-untyped-def]
    """Channels as sums of signals."""
    width, count = len(lanes), terms.shape[1]
    for channel in range(terms.shape[0]):
        for lane in range(width):
            raw[channel * width + lane] = 0.0
        for term in range(count):
            weight, signal = (channel * count + term) * width, terms[channel, term] * width
            for lane in range(width):
                raw[channel * width + lane] += weights[weight + lane] * signals[signal + lane]


@kernel
def measure(sample, noise, own, memory):  # type: ignore[no-untyped-def]
    """Readings of one sample from what the instruments give; ``noise`` (sample, channel) may be empty."""
    readings, analogue, noisy = memory.readings, memory.analogue, noise.shape[0] > 0
    gains, offsets, limits, resolutions = own.gains, own.offsets, own.limits, own.resolutions
    for c in range(readings.size):
        value = analogue[c] + noise[sample, c] if noisy else analogue[c]
        readings[c] = converted(gains[c] * value + offsets[c], limits[c], resolutions[c])


@kernel
def read_sensors(number, sample, own, noise, signals, memory, lanes):  # type: ignore[no-untyped-def]
    """Filter the channels for one step; at a sample (number ``sample`` of ``noise``; −1: none) take the readings."""
    raw, rest, analogue, zeroed = memory.raw, memory.rest, memory.analogue, own.zeroed
    combine(own.terms, own.weights, signals, raw, lanes)
    for c in range(raw.size):
        if number == 0:
            rest[c] = zeroed[c] * raw[c]
        raw[c] -= rest[c]
    if own.order > 0:
        if number == 0:
            settle_filters(own.filters, own.order, raw, memory.filters)
        filter_readings(own, raw, memory.filters, analogue, memory.scratch)
    else:
        copy(raw, analogue)
    if sample >= 0:
        measure(sample, noise, own, memory)
