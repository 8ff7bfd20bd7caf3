"""Records in seismic formats, through ObsPy, with the instrument's response."""

import warnings
from collections.abc import Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ehamj.records.channel import Record
from ehamj.records.choices import SILENT, Choices
from ehamj.records.components import Component, Loaded, record_of
from ehamj.records.files import matching, reading
from ehamj.records.formats import read_record, record_format
from ehamj.records.joining import alike, joined
from ehamj.records.miniseed import check_whole, read_skipping, read_strictly
from ehamj.records.orientation import of_header, turned
from ehamj.records.responses import Responses, open_responses, sensed_by
from ehamj.records.said import warned
from ehamj.records.units import Quantity

if TYPE_CHECKING:
    from obspy import Stream, Trace, UTCDateTime

EXAMPLE = "example:BW.RJOB"

STATED: dict[str, tuple[Quantity, float]] = {"KNET": ("acceleration", 1.0)}
"""Formats whose calibration factor leads to motion in SI: they need no response."""

KNET_LETTERS = {"EW": "E", "NS": "N", "UD": "Z"}
"""Directions of K-NET and KiK-net (positive to the east, north and up), and the letters that stand for them."""

MOST_SAID = 5
"""So many remarks of ObsPy on a file are passed on."""


def read_seismic(path: Path, choices: Choices = SILENT) -> Record:
    """A record in one of `ehamj.records.formats`; the last part of ``path`` may hold wildcards, or it is `EXAMPLE`.

    Counts stay counts: each channel carries the response that the processing divides by. Traces of one name are one
    component; those without a name are components of their own, and so is, where they do not fit together, each trace
    of a name, by its number. Only what is picked is judged. Raises ValueError for a file that is missing, truncated or
    damaged, and for what is wrong with components that are picked.
    """
    label = path.name
    stream, notes = _open(path, choices)
    traces = [trace for trace in stream if trace.stats.npts]
    if not traces:
        raise ValueError(f"ground.file = {label!r} holds no samples")
    groups: dict[str, list[Trace]] = {}
    for number, trace in enumerate(traces):
        groups.setdefault(trace.id if _named(trace) else f"{number}", []).append(trace)
    singles = [(name, trace) for name, group in groups.items() if not _together(group) for trace in group]
    held = None if choices.inventory is None else open_responses(choices.inventory)
    beginning = min(trace.stats.starttime for trace in traces)
    load = partial(_load, label, choices, held, beginning)
    components = []
    for name, group in groups.items():
        if choices.axes is None and not _numeric(group[0]) and len(groups) > 1:
            notes.append(f"{name} holds text: passed over")
            continue
        numbers = [len(groups) + 1 + k for k, (whose, _) in enumerate(singles) if whose == name]
        components.append(_component(group[0], partial(load, group, _singly(group, numbers))))
    if choices.axes is not None:
        components += [
            Component(f"{name} from {trace.stats.starttime}", partial(load, [trace], "")) for name, trace in singles
        ]
    return record_of(label, components, choices, "let ground.remove_response find out", notes)


def _component(trace: "Trace", load: partial[Loaded]) -> Component:
    if not _named(trace):
        return Component("", load)
    channel = trace.stats.channel
    letter = KNET_LETTERS.get(channel[:2], "") if trace.stats.get("_format") == "KNET" else channel[-1:]
    return Component(trace.id, load, tuple(filter(None, (channel, letter))), trace.id.rsplit(".", 2)[0])


def _load(
    label: str, choices: Choices, held: "Responses | None", beginning: "UTCDateTime", traces: "list[Trace]", singly: str
) -> Loaded:
    """One component: its traces joined, and its response."""
    first = min(traces, key=lambda trace: trace.stats.starttime)
    name = first.id if _named(first) else "the trace"
    for trace in traces:
        if not _numeric(trace):
            raise ValueError(f"ground.file = {label!r}: channel {name} holds text or the like, not samples")
        if trace.data.shape != (trace.stats.npts,):
            raise ValueError(
                f"ground.file = {label!r}: {name} states {trace.stats.npts} samples and holds {trace.data.size}; the "
                "file may be truncated"
            )
        if not 0 < trace.stats.sampling_rate < np.inf:
            raise ValueError(
                f"ground.file = {label!r}: {name} states a sampling rate of {trace.stats.sampling_rate:g} Hz; it must "
                "be positive"
            )
    samples, rate, notes = joined(label, name, traces, choices, singly)
    time = float(first.stats.starttime - beginning)
    factors = {float(trace.stats.calib) for trace in traces}
    if len(factors) > 1:
        several = ", ".join(f"{factor:g}" for factor in sorted(factors))
        raise ValueError(f"ground.file = {label!r}: traces of {name} state several calibration factors: {several}")
    factor = factors.pop()
    form = str(first.stats.get("_format", ""))
    stated = of_header(first)
    if not choices.remove_response or (form in STATED and choices.inventory is None):
        unit = STATED.get(form) if choices.user_unit is None and choices.quantity == "auto" else None
        sign, remarks = turned(name, first.stats.channel, stated)
        return Loaded(sign * samples, rate, unit, time, None, (*notes, *remarks), factor)
    sensed = sensed_by(first, held, choices.response, max(trace.stats.endtime for trace in traces))
    sign, remarks = turned(name, first.stats.channel, sensed.orientation or stated)
    if factor != 1.0:
        notes.append(f"{name}: the file's calibration factor {factor:g} is not applied, since the response is removed")
    notes += [*sensed.notes, *remarks]
    return Loaded(sign * samples, rate, (sensed.quantity, 1.0), time, sensed.response, tuple(notes))


def _rate_of(interval: float) -> float:
    """Rate [Hz] of an interval in single precision [s], of which ObsPy keeps whole microseconds: 300.03 Hz for 300."""
    stated = float(str(np.float32(interval)))
    if not 0.0 < stated < np.inf:
        raise ValueError(f"its header states an interval of {stated:g} s between samples; it must be positive")
    rate = 1.0 / stated
    even = float(f"{rate:.6g}")
    return even if abs(even / rate - 1.0) < np.finfo(np.float32).eps else rate


def _named(trace: "Trace") -> bool:
    return bool(trace.stats.station or trace.stats.channel)


def _numeric(trace: "Trace") -> bool:
    return trace.data.dtype.kind in "iuf"


def _together(traces: "Sequence[Trace]") -> bool:
    """Whether traces of one name follow each other at one rate."""
    ordered = sorted(traces, key=lambda trace: trace.stats.starttime)
    return len(traces) == 1 or (
        alike(traces)
        and all(other.stats.starttime > one.stats.endtime + one.stats.delta / 2 for one, other in pairwise(ordered))
    )


def _singly(traces: "Sequence[Trace]", numbers: list[int]) -> str:
    """How single traces of a channel are picked, for messages."""
    if not numbers:
        return ""
    listed = "; ".join(
        f"{number} ({trace.stats.starttime}, {trace.stats.npts} samples at {trace.stats.sampling_rate:g} Hz)"
        for number, trace in zip(numbers, traces, strict=True)
    )
    return f"pick one of its traces in ground.axes by its number: {listed}"


def _open(source: Path, choices: Choices) -> tuple["Stream", list[str]]:
    """The traces of all files, and remarks on reading."""
    import obspy

    if str(source) == EXAMPLE:
        return obspy.read(), []
    stream, notes = obspy.Stream(), []
    for path in matching(source):
        found, remarks = _open_file(path, choices)
        stream += found
        notes += remarks
    return stream, notes


def _open_file(path: Path, choices: Choices) -> tuple["Stream", list[str]]:
    how = ", neither as a seismic format nor as *.csv; it may be truncated or damaged"
    with reading(path, how), warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        form = record_format(path)
        notes: list[str] = []
        if form.name != "MSEED":
            stream = read_record(path, form)
        elif choices.damaged == "skip":
            stream, notes = read_skipping(path)
        else:
            try:
                stream = read_strictly(path.read_bytes())
                check_whole(path)
            except Exception as error:
                raise ValueError(f'{error}; ground.damaged = "skip" leaves damaged records out') from error
        for trace in stream:
            trace.stats._format = form.name
            if form.name in ("SAC", "SACXY"):
                trace.stats.sampling_rate = _rate_of(trace.stats.sac.delta)
    texts = [text for text in warned(said) if not text.startswith("Sample spacing read from SAC")]
    return stream, [*notes, *(f"{path.name}: ObsPy says: {text}" for text in texts[:MOST_SAID])]
