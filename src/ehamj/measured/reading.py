"""A test's file as channels of ehamj: components picked, in SI, judged, and brought onto one clock."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.measured.channels import FELT, FORCE, ChannelUnit, check_measured, role_of, unit_of
from ehamj.measured.doubts import faults, hum, resolution
from ehamj.measured.measured import ForcePlace, Measured, MeasuredChannel, Role
from ehamj.measured.resampling import resampled, usable_to
from ehamj.measured.settings import MeasuredComponent, Measurement
from ehamj.records.choices import Reading
from ehamj.records.components import toml_key
from ehamj.records.picked import SI, Pick, Series, read_picked
from ehamj.records.units import unit
from ehamj.settings import unit as of_length_one

FEWEST = 64
"""Samples that all channels of a test have in common at least."""
ALIGNED = 1e-3
"""Share of a sample within which clocks are one."""


def read_measured(
    path: Path, measurement: Measurement, mounts: tuple[str, ...], reading: Reading, key: str, name: str = ""
) -> Measured:
    """What was measured in a test.

    Args:
        path: of the file, in any format that `ehamj.records.readers` knows.
        measurement: what each of its components is; others are passed over.
        mounts: of the machine, whose channels they are.
        reading: how the file is read.
        key: of the test's table, for messages: ``test.0``.
        name: of the test.

    Raises:
        InputError: naming key, component and way out: for a component that is not there, of another unit than its
            channel's, dead, clipped or coarse (unless accepted), too short, or of another time than the others.
    """
    wanted = wanted_of(measurement, mounts, key, path.name)
    found = read_picked(path, [one.pick for one in wanted], reading, key)
    notes = [*dict.fromkeys(note for series in found for note in series.notes)]
    notes += _judged(found, wanted)
    notes += _humming(found, wanted)
    rate, begin, columns, remarks = on_one_clock(found, key, path.name)
    channels = tuple(_channel(*one) for one in zip(wanted, found, columns, strict=True))
    return Measured(name or path.name, rate, channels, begin, usable_to(rate), (*notes, *remarks))


@dataclass(frozen=True)
class Wanted:
    """A component that is wanted, and what it is."""

    component: str
    """Its key in the table."""
    said: MeasuredComponent
    channel: str
    role: Role
    key: str
    """For messages."""

    @property
    def unit(self) -> ChannelUnit:
        """Of the channel."""
        return unit_of(self.channel)

    @property
    def pick(self) -> Pick:
        """What is picked of the file."""
        name = self.said.component or self.component
        return Pick(self.key, self.unit.kind, self.channel, name, self.said.unit, self.said.full_scale)


def wanted_of(measurement: Measurement, mounts: tuple[str, ...], key: str, label: str) -> list[Wanted]:
    """What a table wants of a file; raises InputError for what is no channel, cannot be an input, or stands twice."""
    if not measurement:
        raise InputError(f"{key}.measurement is empty: state what the components of {label!r} are")
    found: list[Wanted] = []
    for component, said in measurement.items():
        own, channel = f"{key}.measurement.{toml_key(component)}", channel_of(component, said)
        if said.channel is not None:
            check_measured(channel, mounts, own)
        earlier = next((one.component for one in found if one.channel == channel), None)
        if earlier is not None:
            raise InputError(f"{own}.channel: {earlier} is {channel} already; leave one of them out")
        role = role_of(channel, said.role, own)
        if said.hold is not None and (role == "output" or channel.startswith("ground_")):
            raise InputError(
                f"{own}.hold = {said.hold!r}: {channel} is neither a command nor a force that drives; leave it out"
            )
        found.append(Wanted(component, said, channel, role, own))
    return found


def channel_of(component: str, one: MeasuredComponent) -> str:
    """Name of the channel that a component is: ``force KEY`` of a force, ``acceleration KEY`` of an accelerometer."""
    return one.channel or f"{FELT if one.force is None else FORCE} {component}"


def place_of(said: MeasuredComponent) -> ForcePlace | None:
    """Where a force acts or an accelerometer stands; None of what is neither."""
    own = said.force or said.accelerometer
    return None if own is None else ForcePlace(own.point, of_length_one(own.direction))


def _channel(one: Wanted, series: Series, samples: Array) -> MeasuredChannel:
    said, size = one.said, one.said.scale / one.unit.size
    step, full = resolution(series.samples), None
    if said.full_scale is not None:  # of a WAV file
        full = abs(size) * said.full_scale * (1.0 if said.unit in (None, SI) else unit(str(said.unit)).size)
    return MeasuredChannel(
        one.channel,
        one.unit.text,
        samples * size,
        one.role,
        series.component,
        place_of(said),
        full,
        None if step is None else abs(size) * step,
    )


def _judged(found: Sequence[Series], wanted: Sequence[Wanted]) -> list[str]:
    """Remarks on faults that are accepted, or that an input may have; raises InputError naming all others."""
    notes, wrong = [], []
    for series, one in zip(found, wanted, strict=True):
        for fault in faults(series.samples):
            told = f"{series.component} ({one.channel}) {fault.said}"
            if one.role == "output" and fault.word not in one.said.accept:
                way = f'leave it out, or state accept = ["{fault.word}"] if it is as it should be'
                wrong.append(f"{one.key}: {told}; {way}")
            notes.append(told)
    if wrong:
        raise InputError("\n".join(wrong))
    return notes


def _humming(found: Sequence[Series], wanted: Sequence[Wanted]) -> list[str]:
    """Remarks on hum of outputs that no input explains."""
    lines = [hum(series.samples, series.rate) for series in found]
    driven = {line for line, one in zip(lines, wanted, strict=True) if one.role == "input"}
    return [
        f"{series.component} has a line at {line:g} Hz, as of the mains; it is fitted as if the machine made it"
        for series, one, line in zip(found, wanted, lines, strict=True)
        if one.role == "output" and line is not None and line not in driven
    ]


def on_one_clock(found: Sequence[Series], key: str, label: str) -> tuple[float, float, list[Array], list[str]]:
    """Rate [Hz], begin on the file's clock [s], samples of each, and remarks: the time that all have in common, at the
    lowest of their rates.

    Raises:
        InputError: where they have no time in common, or too little.
    """
    begin, end = max(one.time for one in found), min(one.end for one in found)
    late = next(one for one in found if one.time == begin)
    early = next(one for one in found if one.end == end)
    if end <= begin:
        raise InputError(
            f"{key}.file = {label!r}: {early.component} ends at {end:g} s, and {late.component} begins at {begin:g} s "
            "only: they have no time in common; leave one of them out"
        )
    rate = min(one.rate for one in found)
    count = (
        min(int(np.floor((one.time - begin + (one.samples.size - 1) / one.rate) * rate + ALIGNED)) for one in found) + 1
    )
    if count < FEWEST:
        raise InputError(
            f"{key}.file = {label!r}: its channels have {count} samples in common ({end - begin:g} s at {rate:g} Hz); "
            f"at least {FEWEST} are needed"
        )
    notes, columns = [], []
    for one in found:
        first = (begin - one.time) * one.rate
        if one.rate == rate and abs(first - round(first)) < ALIGNED:
            columns.append(one.samples[round(first) : round(first) + count])
            continue
        columns.append(resampled(one.samples, one.rate, begin - one.time + np.arange(count) / rate, rate))
        notes.append(
            f"{one.component} is resampled from {one.rate:g} Hz to the clock of the others, {rate:g} Hz, without phase "
            f"(unchanged up to {usable_to(rate):g} Hz)"
        )
    if begin - min(one.time for one in found) > 1.5 / rate or max(one.end for one in found) - end > 1.5 / rate:
        notes.append(f"record {label}: {late.component} begins last and {early.component} ends first; what all have in "
                     f"common is used, {begin:g} to {end:g} s")  # fmt: skip
    return rate, begin, columns, notes
