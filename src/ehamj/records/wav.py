"""Records in WAV files, whose samples are shares of a full scale that the user states."""

import struct
import warnings
from functools import partial
from pathlib import Path

import numpy as np
import scipy

from ehamj.records.channel import Record
from ehamj.records.choices import SILENT, Choices
from ehamj.records.components import Component, Loaded, record_of
from ehamj.records.files import bounded, check_samples, existing, reading
from ehamj.signals import Array

CLIPPED = 1.0 - 1e-4
"""Share of the full scale from which a sample counts as clipped."""

READ = frozenset(("fmt ", "data", "fact", "ds64", "JUNK", "PAD ", "FLLR", "LIST", "PEAK"))
"""Chunks that say nothing of what a sample means, or that are read."""


def read_wav(path: Path, choices: Choices = SILENT) -> Record:
    """A WAV record: ``choices.full_scale`` is the motion that the largest possible sample stands for.

    Integers count from -1 to 1 of the full scale, floating-point samples are shares of it already; files may be
    extensible (WAVE_FORMAT_EXTENSIBLE), big-endian (RIFX) or large (RF64). Components are called by their number, from
    ``1``. Raises ValueError where the file cannot be read or is truncated, and where the full scale or the quantity is
    not given.
    """
    if choices.full_scale is None:
        raise ValueError(
            "ground.full_scale is missing: a WAV file does not say what its samples mean; give the motion that its "
            "largest sample stands for, in ground.unit"
        )
    existing(path)
    with reading(path, " as WAV"):
        chunks, frames = _chunks(path)
    check_samples(path, frames)
    with reading(path, " as WAV"), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of chunks that are not read: said below, by their names
        with bounded(path) as file:
            rate, data = scipy.io.wavfile.read(file)
    if rate <= 0:
        raise ValueError(f"ground.file = {path.name!r} states a sampling rate of {rate} Hz; it must be positive")
    columns = data[:, None] if data.ndim == 1 else data
    names = [str(n + 1) for n in range(columns.shape[1])]
    components = [Component(name, partial(_load, columns, n, float(rate), choices)) for n, name in enumerate(names)]
    skipped = ", ".join(sorted(set(chunks) - READ))
    notes = [f"chunks {skipped} are not read: what they state of a scale is ground.full_scale's"] if skipped else []
    record = record_of(path.name, components, choices, "use a format that states it", notes)
    _check_scales(path.name, record, names, choices)
    return record


def _chunks(path: Path) -> tuple[list[str], int]:
    """Names of the file's chunks, in order, and how many samples a component has; raises ValueError where its data end
    before they should."""
    size = path.stat().st_size
    found, held, frame = [], 0, 1
    with path.open("rb") as file:
        head = file.read(12)
        big = head[:4] == b"RIFX"
        large = 0
        while len(part := file.read(8)) == 8:
            length = struct.unpack(">I" if big else "<I", part[4:])[0]
            name = part[:4].decode("latin-1")
            if name == "ds64":
                large = struct.unpack("<Q", file.read(16)[8:])[0]
                file.seek(-16, 1)
            if name == "fmt ":
                frame = struct.unpack(">H" if big else "<H", file.read(14)[12:])[0]
                file.seek(-14, 1)
            if name == "data" and head[:4] == b"RF64":
                length = large
            held = length if name == "data" else held
            left = size - file.tell()
            if length > left and "data" not in found:
                what = "samples" if name == "data" else f"chunk {name!r}"
                raise ValueError(f"it is truncated: it states {length} bytes of {what} and holds {left}")
            found.append(name)
            file.seek(length + length % 2, 1)
    if not {"fmt ", "data"} <= set(found):
        raise ValueError("it has no chunks fmt and data")
    return found, held // max(frame, 1)


def _load(columns: np.ndarray, n: int, rate: float, choices: Choices) -> Loaded:
    share = _share(columns[:, n])
    over = int(np.sum(np.abs(share) >= CLIPPED))
    notes = [f"{n + 1} looks clipped: {over} samples stand at the WAV file's full scale"] if over else []
    return Loaded(_full_scale(choices, str(n + 1)) * share, rate, notes=tuple(notes))


def _called(name: str, place: str) -> tuple[str, ...]:
    """The names in a table of full scales that serve a component, the most special first."""
    return tuple(dict.fromkeys((name, place, place.rpartition(" ")[2])))


def _full_scale(choices: Choices, name: str) -> float:
    """Motion that the largest sample of a component stands for [unit]."""
    found = choices.full_scale
    if isinstance(found, dict):
        serving = [one for one in _called(name, (choices.axes or {}).get(name, "")) if one in found]
        if not serving:
            raise ValueError(
                f"ground.full_scale names {', '.join(found) or 'nothing'}, but neither component {name} nor its axis"
            )
        return float(found[serving[0]])
    assert found is not None
    return float(found)


def _check_scales(label: str, record: Record, names: list[str], choices: Choices) -> None:
    """Raise ValueError where a table of full scales names what serves no component; the file's others may be there."""
    if not isinstance(choices.full_scale, dict):
        return
    known = {channel.name: _called(channel.name, channel.axis) for channel in record.channels}
    serving = {next(one for one in called if one in choices.full_scale) for called in known.values()}
    for key in choices.full_scale:
        if key in serving or (key in names and key not in known):
            continue
        if (over := next((name for name, called in known.items() if key in called), None)) is not None:
            taken = next(one for one in known[over] if one in choices.full_scale)
            raise ValueError(
                f"ground.full_scale names component {over} of {label!r} twice, as {taken!r} and as {key!r}; leave one "
                "of them out"
            )
        held = ", ".join(f"{name} ({called[1]})" if name in known else name for name, called in known.items())
        raise ValueError(f"ground.full_scale names {key!r}, which is no component in use; {label!r} holds {held}")


def _share(data: np.ndarray) -> Array:
    """Samples as shares of the full scale."""
    if data.dtype.kind == "f":
        with np.errstate(invalid="ignore"):  # what is not finite is refused by its place
            return np.asarray(data, float)
    if data.dtype.kind == "u":  # 8 bit, around 128
        return (data.astype(float) - 128.0) / 128.0
    return data.astype(float) / -float(np.iinfo(data.dtype).min)
