"""A test's file as channels of ehamj: components picked, in SI, judged, and brought onto one clock."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ehamj.arrays import Array
from ehamj.errors import InputError
from ehamj.measured.channels import FORCE, check_measured, role_of, unit_of
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
    if not measurement:
        raise InputError(f"{key}.measurement is empty: state what the components of {path.name!r} are")
    keys = {component: f"{key}.measurement.{toml_key(component)}" for component in measurement}
    names = {component: channel_of(component, one) for component, one in measurement.items()}
    roles: dict[str, Role] = {}
    for component, one in measurement.items():
        if one.channel is not None:
            check_measured(one.channel, mounts, keys[component])
        roles[component] = role_of(names[component], one.role, keys[component])
        earlier = next((other for other in roles if other != component and names[other] == names[component]), None)
        if earlier is not None:
            raise InputError(
                f"{keys[component]}.channel: {earlier} is {names[component]} already; leave one of them out"
            )
    picks = [_pick(component, one, names[component], keys[component]) for component, one in measurement.items()]
    found = read_picked(path, picks, reading, key)
    notes = list(dict.fromkeys(note for series in found for note in series.notes))
    doubted, resolutions = [], []
    for series, (component, one) in zip(found, measurement.items(), strict=True):
        notes += _judged(series, one, roles[component], names[component], keys[component])
        doubted.append(None if roles[component] == "input" else hum(series.samples, series.rate))
        step = resolution(series.samples)
        resolutions.append(None if step is None else abs(step * one.scale) / unit_of(names[component]).size)
    driven = {
        hum(series.samples, series.rate) for series, role in zip(found, roles.values(), strict=True) if role == "input"
    }
    notes += [
        f"{series.component} has a line at {line:g} Hz, as of the mains; it is fitted as if the machine made it"
        for series, line in zip(found, doubted, strict=True)
        if line is not None and line not in driven  # which explain it
    ]
    rate, begin, columns, remarks = on_one_clock(found, key, path.name)
    channels = tuple(
        MeasuredChannel(
            names[component],
            unit_of(names[component]).text,
            samples * (one.scale / unit_of(names[component]).size),
            roles[component],
            series.component,
            _place(one),
            _full_scale(one, names[component]),
            step,
        )
        for (component, one), series, samples, step in zip(
            measurement.items(), found, columns, resolutions, strict=True
        )
    )
    return Measured(name or path.name, rate, channels, begin, usable_to(rate), (*notes, *remarks))


def channel_of(component: str, one: MeasuredComponent) -> str:
    """Name of the channel that a component is: ``force KEY`` of a force."""
    return one.channel or f"{FORCE} {component}"


def _pick(component: str, one: MeasuredComponent, channel: str, key: str) -> Pick:
    return Pick(key, unit_of(channel).kind, channel, one.component or component, one.unit, one.full_scale)


def _place(one: MeasuredComponent) -> ForcePlace | None:
    return None if one.force is None else ForcePlace(one.force.point, of_length_one(one.force.direction))


def _full_scale(one: MeasuredComponent, channel: str) -> float | None:
    """Of a WAV file's converter, in the channel's unit."""
    if one.full_scale is None:
        return None
    size = 1.0 if one.unit in (None, SI) else unit(str(one.unit)).size
    return abs(one.scale) * one.full_scale * size / unit_of(channel).size


def _judged(series: Series, one: MeasuredComponent, role: Role, channel: str, key: str) -> list[str]:
    """Remarks on faults that are accepted, or that an input may have; raises InputError for others."""
    notes = []
    for fault in faults(series.samples):
        said = f"{series.component} ({channel}) {fault.said}"
        if role == "output" and fault.word not in one.accept:
            raise InputError(
                f'{key}: {said}; leave it out, or state accept = ["{fault.word}"] if it is as it should be'
            )
        notes.append(said)
    return notes


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
