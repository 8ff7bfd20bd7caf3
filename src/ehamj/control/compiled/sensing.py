"""What the sensors of a controller do in a step, compiled: channels from signals, filters, readings at a sample."""

from typing import Any, NamedTuple

import numpy as np

from ehamj.compiled import copy, kernel
from ehamj.control.compiled.converter import converted
from ehamj.control.compiled.signals import Layout


class Sensing(NamedTuple):
    """The channels that a controller reads, and their instruments."""

    layout: Layout
    """Of the vector of signals."""
    terms: Any
    weights: Any
    """Each channel as a short sum of signals: which (channel, term), and their factors."""
    filters: Any
    """(n + 3, n, channel): A row by row, then B, C and the resting state of every filter."""
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
        n, filters = sensing.channels, sensing.channels * sensing.filters.shape[1]
        return cls(*(np.zeros(size) for size in (n, n, filters, n, n, filters)))


@kernel
def filter_readings(filters, feedthrough, raw, states, analogue, scratch):  # type: ignore[no-untyped-def]
    """One step of every sensor's filter: analogue readings, then the states at the next step.

    ``filters`` (n + 3, n, channels) holds A row by row, then B, C and the resting state; ``states`` (n·channels).
    """
    n, channels = filters.shape[1], filters.shape[2]
    for c in range(channels):
        analogue[c] = feedthrough[c] * raw[c]
    for j in range(n):
        own = states[j * channels : (j + 1) * channels]
        for c in range(channels):
            analogue[c] += filters[n + 1, j, c] * own[c]
    for i in range(n):
        row = scratch[i * channels : (i + 1) * channels]
        for c in range(channels):
            row[c] = filters[n, i, c] * raw[c]
        for j in range(n):
            own = states[j * channels : (j + 1) * channels]
            for c in range(channels):
                row[c] += filters[i, j, c] * own[c]
    copy(scratch, states)


@kernel
def settle_filters(filters, raw, states):  # type: ignore[no-untyped-def]
    """Let every sensor rest at its channel's present value."""
    n, channels = filters.shape[1], filters.shape[2]
    for i in range(n):
        for c in range(channels):
            states[i * channels + c] = filters[n + 2, i, c] * raw[c]


@kernel
def combine(terms, weights, signals, raw):  # type: ignore[no-untyped-def]
    """Channels as sums of signals."""
    for channel in range(terms.shape[0]):
        raw[channel] = 0.0
        for term in range(terms.shape[1]):
            raw[channel] += weights[channel, term] * signals[terms[channel, term]]


@kernel
def measure(sample, noise, own, memory):  # type: ignore[no-untyped-def]
    """Readings of one sample from what the instruments give; ``noise`` (sample, channel) may be empty."""
    readings, analogue = memory.readings, memory.analogue
    for c in range(readings.size):
        value = analogue[c] + noise[sample, c] if noise.shape[0] > 0 else analogue[c]
        readings[c] = converted(own.gains[c] * value + own.offsets[c], own.limits[c], own.resolutions[c])


@kernel
def read_sensors(number, sample, own, noise, signals, memory):  # type: ignore[no-untyped-def]
    """Filter the channels for one step; at a sample (number ``sample`` of ``noise``; −1: none) take the readings."""
    raw, rest, analogue = memory.raw, memory.rest, memory.analogue
    combine(own.terms, own.weights, signals, raw)
    for c in range(raw.size):
        if number == 0:
            rest[c] = own.zeroed[c] * raw[c]
        raw[c] -= rest[c]
    if own.filters.shape[1] > 0:
        if number == 0:
            settle_filters(own.filters, raw, memory.filters)
        filter_readings(own.filters, own.feedthrough, raw, memory.filters, analogue, memory.scratch)
    else:
        copy(raw, analogue)
    if sample >= 0:
        measure(sample, noise, own, memory)
