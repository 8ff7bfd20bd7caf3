"""The traces of one channel on one grid: gaps, overlaps, and clocks that were set anew."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ehamj.records.choices import Choices
from ehamj.records.clock import filled
from ehamj.signals import Array

if TYPE_CHECKING:
    from obspy import Trace

OFF_GRID = 1e-2
"""From where on it is said that a trace lies between the samples of the first, in steps."""

SAME_RATE = 1e-6
"""How far the rates of traces of one channel may differ, relative: rounding of what headers hold."""


def alike(traces: "Sequence[Trace]") -> bool:
    """Whether traces can be one channel: they have one rate."""
    rates = [trace.stats.sampling_rate for trace in traces]
    return bool(min(rates) > 0 and max(rates) <= min(rates) * (1 + SAME_RATE))


def joined(
    label: str, name: str, traces: "Sequence[Trace]", choices: Choices, singly: str
) -> tuple[Array, float, list[str]]:
    """Samples and rate [Hz] of the traces of one channel, and remarks.

    Args:
        label: the file's name.
        name: the channel's.
        traces: its traces.
        choices: what to do about gaps and overlaps.
        singly: how single traces of it can be picked, for messages.

    Raises:
        ValueError: for rates that differ, and for overlaps and gaps that may not be.
    """
    traces = sorted(traces, key=lambda trace: (trace.stats.starttime, trace.stats.endtime))
    if not alike(traces):
        rates = ", ".join(f"{rate:g}" for rate in sorted({trace.stats.sampling_rate for trace in traces}))
        raise ValueError(f"ground.file = {label!r}: {name} is sampled at {rates} Hz; {singly}")
    rate, begin = traces[0].stats.sampling_rate, traces[0].stats.starttime
    places = [float(trace.stats.starttime - begin) * rate for trace in traces]
    firsts = [round(place) for place in places]
    size = max(first + trace.stats.npts for first, trace in zip(firsts, traces, strict=True))
    held = sum(trace.stats.npts for trace in traces)
    if size > 2 * held:
        filled(label, len(traces) - 1, (size - held) / rate, held / rate, choices.gaps)  # raises: more gap than record
    samples, taken, conflicts = np.full(size, np.nan), np.zeros(size, bool), 0
    doubled = 0
    # What is written last remains: with "first" that is the trace that begins first.
    for k in reversed(range(len(traces))) if choices.overlap == "first" else range(len(traces)):
        data, part = np.asarray(traces[k].data, float), slice(firsts[k], firsts[k] + traces[k].stats.npts)
        both = taken[part]
        conflicts += int(np.sum(samples[part][both] != data[both]))
        doubled += int(np.sum(both))
        samples[part], taken[part] = data, True
    notes = []
    if conflicts and choices.overlap == "refuse":
        raise ValueError(
            f"ground.file = {label!r}: traces of {name} overlap by {doubled / rate:.4g} s and differ there; set "
            f'ground.overlap = "first" or "last" (the trace that begins first, or last, counts), or {singly}'
        )
    if conflicts:
        notes.append(
            f"{name}: traces overlap by {doubled / rate:.4g} s; there the one that begins {choices.overlap} counts"
        )
    elif doubled:
        notes.append(f"{name}: {doubled / rate:.4g} s are there twice, with the same samples")
    off = max(abs(place - first) for place, first in zip(places, firsts, strict=True))
    if off > OFF_GRID:
        notes.append(f"{name}: traces lie up to {1e3 * off / rate:.3g} ms off the first one's samples; set onto them")
    missing = ~taken
    if missing.any():
        holes = int(np.sum(np.diff(missing.astype(int)) == 1))
        notes.append(filled(label, holes, missing.sum() / rate, taken.sum() / rate, choices.gaps))
        at = np.flatnonzero(taken)
        samples = np.interp(np.arange(size), at, samples[at])
    return samples, rate, notes
