"""Records in TDMS files (LabVIEW, FlexLogger, NI-DAQ), through npTDMS, which applies their scaling."""

import logging
import re
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ehamj.records.channel import Record
from ehamj.records.choices import SILENT, Choices
from ehamj.records.clock import clock, on_grid, rounding
from ehamj.records.components import Component, Loaded, answers_of, record_of
from ehamj.records.files import bounded, existing, reading
from ehamj.records.said import logged, one_line
from ehamj.records.units import is_silent, time_unit
from ehamj.signals import Array

if TYPE_CHECKING:
    from nptdms import TdmsChannel, TdmsFile

UNITS = ("unit_string", "NI_UnitDescription", "unit", "units")
"""Properties that state a channel's unit, by their names in small letters after the first two."""


def read_tdms(path: Path, choices: Choices = SILENT) -> Record:
    """The channels of a TDMS file.

    A component is called ``group/channel`` and answers to the channel's name too. The clock is the waveform's
    (``wf_increment``, ``wf_start_offset``, ``wf_start_time``), or a channel ``time`` in the same group; the unit is the
    property ``unit_string``. Raises ValueError where the file cannot be read or breaks off, and see `clock`.
    """
    existing(path)
    passed = []
    with _opened(path) as file:
        starts = (_start(channel) for group in file.groups() for channel in group.channels())
        start = min((one for one in starts if one is not None), default=None)
        components = []
        for group in file.groups():
            times = [c for c in group.channels() if _is_time(c)]
            for channel in group.channels():
                own = one_line(channel.name)
                name = one_line(f"{channel.group_name}/{own}")
                if channel.dtype.kind not in "iuf" or len(channel) < 2:
                    passed.append(name)
                elif channel not in times:
                    load = partial(_load, path, channel, next(iter(times), None), start, choices)
                    components.append(Component(name, load, (own, *answers_of(own))))
        if not components:
            raise ValueError(f"ground.file = {path.name!r} holds no channel of numbers")
        notes = [f"channels without numbers are passed over: {', '.join(passed)}"] if passed else []
        return record_of(path.name, components, choices, "set the channel's property unit_string", notes)


@contextmanager
def _opened(path: Path) -> "Iterator[TdmsFile]":
    """The file's directory; raises ValueError where it states more values than there are."""
    from nptdms import TdmsFile
    from nptdms.log import log_manager

    log_manager.console_handler.setLevel(logging.CRITICAL)  # what it warns of is refused, in our words
    try:
        with bounded(path) as raw, logged("nptdms") as said:
            with reading(path, " as TDMS"):
                file = TdmsFile.open(raw)
                most = path.stat().st_size
                for channel in (channel for group in file.groups() for channel in group.channels()):
                    if len(channel) > most:
                        raise ValueError(f"{channel.path} states {len(channel)} values, and the file has {most} bytes")
                    channel.dtype.kind  # noqa: B018 - raises for types that npTDMS does not know
                if file.file_status.incomplete_final_segment or said:
                    raise ValueError("; ".join(said) or "its last segment is cut off")
            yield file
    finally:
        log_manager.console_handler.setLevel(log_manager.log_level)


def _is_time(channel: "TdmsChannel") -> bool:
    return re.fullmatch(r"\s*(time|t)\s*([\[(].*)?", channel.name, re.IGNORECASE) is not None


def _start(channel: "TdmsChannel") -> Any:
    """When the waveform starts, None where it does not say."""
    start = channel.properties.get("wf_start_time")
    return start if isinstance(start, np.datetime64) and not np.isnat(start) else None


def _stated(channel: "TdmsChannel") -> str | None:
    """The channel's unit as written, None where it states none."""
    small = {key.lower(): value for key, value in channel.properties.items()}
    written = [str(small[key.lower()]) for key in UNITS if key.lower() in small]
    return next((text for text in written if not is_silent(text)), None)


def _load(path: Path, channel: "TdmsChannel", times: "TdmsChannel | None", start: Any, choices: Choices) -> Loaded:
    """One channel, scaled as its properties say; ``times`` is the channel of times in its group."""
    where = f"ground.file = {path.name!r}: channel {one_line(channel.name)}"
    with reading(path, f" as TDMS: {where.rpartition(': ')[2]}"):
        samples = np.asarray(channel[:], float)
    properties, stated = channel.properties, _stated(channel)
    step = properties.get("wf_increment")
    if step is not None:
        label = str(properties.get("wf_xunit_string") or "s")
        size = _seconds(label, f"{where}: the unit of its abscissa (wf_xunit_string)")
        rate = 1.0 / (step * size) if step * size > 0 else np.nan
        if not np.isfinite(rate):
            raise ValueError(f"{where} states wf_increment = {step:g}; the step of its samples must be positive")
        offset = float(properties.get("wf_start_offset") or 0.0) * size
        own = properties.get("wf_start_time")
        late = 0.0 if start is None or own is None else float((own - start) / np.timedelta64(1, "ns")) * 1e-9
        return Loaded(samples, rate, stated, offset + late)
    if times is None:
        raise ValueError(
            f"{where} states no wf_increment, and no channel of its group is named time: save it as a waveform, or set "
            "its property wf_increment to the step between samples [s] (1 / rate), or add a channel time [s]"
        )
    label = _stated(times) or times.name.partition("[")[2].rstrip(" ]") or "s"
    with reading(path, f" as TDMS: channel {times.name}"):
        stored = times[:]
        time: Array = np.asarray(stored, float)
    if time.size != samples.size:
        raise ValueError(f"{where} has {samples.size} values, and the channel {times.name} has {time.size}")
    size = _seconds(label, f"{where}: the unit of the channel {times.name}")
    time = time * size
    rate, index, notes = clock(time, path.name, choices.gaps, rounding(stored) * size)
    return Loaded(on_grid(index, samples), rate, stated, float(time[0]), notes=tuple(notes))


def _seconds(label: str, what: str) -> float:
    """SI value of a unit of time [s]; raises ValueError naming ``what`` it is of."""
    try:
        return time_unit(label)
    except ValueError as error:
        raise ValueError(f"{what}: {error}") from None
