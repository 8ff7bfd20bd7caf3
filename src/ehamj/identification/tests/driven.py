"""The scenario of a test at any point: driven as the rig was, by what its logger wrote."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ehamj.errors import InputError
from ehamj.identification.machine import with_values
from ehamj.identification.runs import with_step
from ehamj.identification.unknowns import Unknown, Values
from ehamj.measured.measured import Measured, MeasuredChannel
from ehamj.records.choices import Reading
from ehamj.scenario.load import changed
from ehamj.scenario.model import Scenario

if TYPE_CHECKING:
    from ehamj.identification.tests.record import RecordTest
    from ehamj.identification.tests.timed import Clock

LATEST = 0.02
"""Delay of an input at most, earlier or later [s]."""
FADE = 0.1
"""Time over which a record of the ground fades at both ends, where nothing is compared [s]."""


@dataclass(frozen=True)
class Driven:
    """The scenario of a test as it begins, and what of its inputs is not known."""

    base: Scenario
    keys: tuple[tuple[str, str], ...]
    """Scenario's key of each unknown of the inputs, and its name."""
    unknowns: tuple[Unknown, ...]
    parameters: tuple[str, ...]

    def at(self, values: Values) -> Scenario:
        """The scenario at a point.

        Raises:
            InputError: if it is none.
        """
        own = {key: values[key] for key in self.parameters}
        return with_values(self.base, own | {key: values[name] for key, name in self.keys})


def driven(
    test: "RecordTest", base: Scenario, measured: Measured, clock: "Clock", parameters: tuple[str, ...]
) -> Driven:
    """A test's scenario with what drove it: commands, forces and the ground as they were measured; what was not
    measured is as the scenario has it.

    Raises:
        InputError: if the scenario cannot be driven so.
    """
    table: dict[str, Any] = {"duration": clock.duration, "record_rate": clock.recorded}
    keys: list[tuple[str, Unknown]] = []
    signals = [one for one in measured.inputs if one.name.startswith("valve_command ")]
    forces = [one for one in measured.inputs if one.place is not None]
    ground = [one for one in measured.inputs if one.name.startswith("ground_")]
    if signals:
        recorded = [
            {"kind": "recorded", "mounts": [one.name.split(" ", 1)[1]], **_source(test, measured, one)}
            for one in signals
        ]
        table["control"] = {"kind": "open-loop", "signals": recorded}
        keys += [key for k, one in enumerate(signals) for key in _unknowns(test, one, f"control.signals.{k}")]
    if forces:
        own = [dict(force) for force in base.table["force"]]
        table["force"] = [*own, *(_force(test, measured, one) for one in forces)]
        keys += [key for k, one in enumerate(forces, len(own)) for key in _unknowns(test, one, f"force.{k}")]
    if ground:
        table["ground"] = _ground(test, measured, ground)
    made = with_step(changed(base, table))
    named = tuple((key, unknown.name) for key, unknown in keys)
    return Driven(made, named, tuple(unknown for _, unknown in keys), parameters)


def entry_of(test: "RecordTest", channel: MeasuredChannel) -> str:
    """Key of the table that says what a channel is; the channel's own name where no table does."""
    for key, said in test.measurement.items():
        if channel.name in (said.channel, f"force {key}") and channel.component in ("", key, said.component or key):
            return key
    return channel.name


def _source(test: "RecordTest", measured: Measured, channel: MeasuredChannel) -> dict[str, Any]:
    """Keys of a recorded input: its file and component."""
    said = test.measurement.get(entry_of(test, channel))
    if test.file is None or said is None:
        raise InputError(
            f"test {test.name!r}: {channel.name} is an input that was given in memory; write the record to a file, or "
            "let the scenario have the signal (set)"
        )
    own = {"unit": said.unit, "full_scale": said.full_scale, "hold": said.hold}
    return {
        "file": test.file, "component": channel.component, "scale": said.scale, "start": measured.begin,
        **{name: value for name, value in own.items() if value is not None}, **_read(test),
    }  # fmt: skip


def _read(test: "RecordTest") -> dict[str, Any]:
    """How the test's file is read, where that is stated."""
    stated = set(Reading.model_fields) & test.model_fields_set
    return {name: value for name, value in test.model_dump(include=stated, exclude_none=True).items() if value != {}}


def _force(test: "RecordTest", measured: Measured, channel: MeasuredChannel) -> dict[str, Any]:
    assert channel.place is not None
    point = channel.place.point if isinstance(channel.place.point, str) else list(channel.place.point)
    where = {"point": point, "direction": list(channel.place.direction)}
    return {"kind": "recorded", **where, **_source(test, measured, channel)}


def _ground(test: "RecordTest", measured: Measured, channels: list[MeasuredChannel]) -> dict[str, Any]:
    """The ground as a record of all its components, each at its mount and axis."""
    sources = [_source(test, measured, one) for one in channels]
    motions = {one.name.split(" ")[0].removeprefix("ground_") for one in channels}
    units = {source.get("unit") for source in sources}
    if len(motions) > 1 or len(units) > 1:
        raise InputError(
            f"test {test.name!r}: measurement: the ground's channels are of {', '.join(sorted(motions))} and of "
            "several units; those that drive must be alike, others may have role = 'output'"
        )
    axes = {str(source["component"]): one.name.split(" ", 1)[1] for source, one in zip(sources, channels, strict=True)}
    scales = {place: source["scale"] for source, place in zip(sources, axes.values(), strict=True)}
    unit = units.pop()
    return {
        "kind": "record", "file": test.file, "axes": axes, "quantity": motions.pop(), "start": measured.begin,
        # A line that the motion itself has over a short record is no drift; the high-pass takes what is one.
        "taper": FADE, "detrend": "constant", **_read(test), **({} if unit in (None, "SI") else {"unit": unit}),
        **({} if set(scales.values()) == {1.0} else {"scale": scales}),
    }  # fmt: skip


def _unknowns(test: "RecordTest", channel: MeasuredChannel, place: str) -> list[tuple[str, Unknown]]:
    """What of an input is not known, by the scenario's key."""
    key = entry_of(test, channel)
    said, found = test.measurement.get(key), []
    if said is None:
        return []
    if said.offset is not None:
        raise InputError(
            f"test {test.name!r}: measurement.{key}.offset = 'free': {channel.name} drives the model; an offset of it "
            "is none of what can be found, subtract it before"
        )
    if said.gain is not None:
        low, high = sorted((0.1 * said.scale, 10.0 * said.scale))
        found.append((f"{place}.scale", Unknown(f"{test.name}.{key}.gain", "1", said.scale, low, high, test=test.name)))
    if said.delay is not None:
        late = Unknown(f"{test.name}.{key}.delay", "s", 0.0, -LATEST, LATEST, test=test.name, size=1e-3)
        found.append((f"{place}.delay", late))
    return found
