"""Records of enDAQ loggers (IDE files), through idelib, which applies their calibration."""

import os
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ehamj.records.channel import Record
from ehamj.records.choices import SILENT, Choices
from ehamj.records.clock import clock, on_grid
from ehamj.records.components import Component, Loaded, answers_of, record_of
from ehamj.records.files import bounded, existing, reading
from ehamj.records.said import logged, one_line
from ehamj.records.units import is_motion

PLAIN = {
    "SampleRate": r"\s*[\d.]+\s*(/\s*[\d.]+\s*)?",
    "TimeCodeScale": r"\s*[\d.]+\s*(/\s*[\d.]+\s*)?",
    "ChannelFormat": r"\s*[<>=!@]?[bBhHiIlLqQfd\s]{1,64}",
}
"""What texts of a file must look like: idelib evaluates them as Python."""

MICROSECOND = 1e-6


class Held(NamedTuple):
    """A subchannel and its channel, as idelib has them, its full name, and its unit as written."""

    channel: Any
    subchannel: Any
    name: str
    unit: str


def read_ide(path: Path, choices: Choices = SILENT) -> Record:
    """The channels of an IDE file.

    A component is called ``channel/subchannel`` and answers to the subchannel's name too; without ``choices.axes``
    those that state no unit of motion (temperature, pressure) are passed over, and named. Raises ValueError where the
    file cannot be read, breaks off, or lists no channels.
    """
    existing(path)
    with _opened(path) as content:
        held = [
            Held(channel, sub, f"{one_line(channel.name)}/{one_line(sub.name)}", str(sub.units[1] or ""))
            for channel in content.channels.values()
            for sub in channel.subchannels
        ]
        taken = held if choices.axes is not None else [one for one in held if is_motion(one.unit)]
        if not taken:
            told = ", ".join(f"{one.name} [{one.unit}]" for one in held)
            raise ValueError(f"ground.file = {path.name!r} holds no channel of motion; it holds {told or 'none'}")
        components = []
        for one in taken:
            own = one_line(one.subchannel.name)
            components.append(Component(one.name, partial(_load, path, one, choices), (own, *answers_of(own))))
        over = ", ".join(f"{one.name} [{one.unit}]" for one in held if one not in taken)
        notes = [f"channels that hold no motion are passed over: {over}"] if over else []
        return record_of(path.name, components, choices, "set the channel's unit", notes)


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """The file's channels and data; raises ValueError for what idelib would guess, evaluate, or only warn of."""
    from idelib.importer import openFile, readData

    with bounded(path) as file, warnings.catch_warnings(), logged("idelib") as said:
        for kind in (UserWarning, UnicodeWarning):  # of formats that are missing, and names that cannot be read
            warnings.simplefilter("error", kind)
        with reading(path, " as an IDE file"):
            _check(file)
            file.seek(0)
            content = openFile(file, quiet=True)
            readData(content)
            if content.fileDamaged or said:
                raise ValueError("; ".join(said) or "it breaks off; save it again from the logger's program")
        yield content


def _check(file: Any) -> None:
    """Raise ValueError where a file breaks off or lists no channels, or texts that idelib evaluates are no numbers."""
    from ebmlite import loadSchema

    listed, begun = False, False
    size = os.fstat(file.fileno()).st_size
    for element in loadSchema("mide_ide.xml").load(file, headers=True):
        if element.payloadOffset + element.size > size:
            raise ValueError(f"it breaks off in {element.name} at byte {element.offset}")
        begun = begun or "DataBlock" in element.name
        for key, text in _texts(element.dump()) if element.name in ("RecordingProperties", "UserData") else ():
            listed = listed or (key == "ChannelID" and not begun)
            if key in PLAIN and not re.fullmatch(PLAIN[key], str(text)):
                raise ValueError(f"its {key} is {str(text)[:40]!r}, which is no plain number or format")
    if not listed:
        raise ValueError("it lists no channels before its data, so that what its numbers mean would be a guess")


def _texts(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """All names and values in nested dictionaries and lists."""
    if isinstance(value, dict):
        for name, part in value.items():
            yield from _texts(part, name)
    elif isinstance(value, list):
        for part in value:
            yield from _texts(part, key)
    else:
        yield key, value


def _load(path: Path, one: Held, choices: Choices) -> Loaded:
    """One subchannel, calibrated."""
    with reading(path, f" as an IDE file: {one.name}"):
        if one.subchannel.transform is None and one.channel.transform is None:
            raise ValueError(f"it states {one.unit!r}, and the file has no calibration that makes its numbers that")
        times, samples = np.asarray(one.subchannel.getSession().arraySlice(), float)
    if samples.size < 2:
        raise ValueError(f"ground.file = {path.name!r}: {one.name} holds {samples.size} samples")
    rate, index, notes = clock(times * MICROSECOND, path.name, choices.gaps)
    return Loaded(on_grid(index, samples), rate, one.unit, float(times[0]) * MICROSECOND, notes=tuple(notes))
