"""What every reader of records shares: axes, quantities and units, times, gaps, and remarks on what was found."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ehamj.ground.channel import Channel, Place, Record
from ehamj.ground.quantities import UNITS, Quantity
from ehamj.settings import FileName, Positive, Settings
from ehamj.signals import Array

STANDARD_AXES: dict[str, Place] = {"E": "x", "N": "y", "Z": "z", "x": "x", "y": "y", "z": "z"}
JITTER = 1e-3
"""How far a time may lie from a uniform grid, in steps."""

AxisChoice = dict[str, Place] | None
QuantityChoice = Literal["auto", "displacement", "velocity", "acceleration"]
GapChoice = Literal["error", "interpolate"]


class Choices(Settings):
    """What the user says about a record."""

    quantity: QuantityChoice = Field(
        "auto",
        description="what the samples are (SI, but for unit); auto: as the file says (instrument's response, units)",
    )
    unit: str | None = Field(
        None, description=f"unit of the samples of a record that states none, one of {', '.join(UNITS)}; default: SI"
    )
    full_scale: Positive | None = Field(
        None, description="motion that the largest sample of a WAV file stands for [unit]"
    )
    inventory: FileName | None = Field(
        None, description="file with the instrument's response (StationXML, dataless SEED, …)"
    )
    remove_response: bool = Field(True, description="turn counts into motion; false: samples are SI (seismic formats)")
    axes: AxisChoice = Field(
        None,
        description="axis of each component (E, EHE, BW.RJOB..EHE, CSV column, UFF direction z or node 12:+Z, WAV "
        "channel 1, MATLAB variable), or axis of one mount ('front-left z'); the others are left out; default: E, N, Z "
        "to x, y, z",
    )
    gaps: GapChoice = Field(
        "error", description="what to do about gaps: refuse the record, or fill with straight lines"
    )

    @model_validator(mode="after")
    def _agreeing(self) -> Self:
        if self.inventory is not None and not self.remove_response:
            raise ValueError(
                f"inventory = {self.inventory!r} is of no use with remove_response = false; leave one of them out"
            )
        if self.unit is not None and self.unit not in UNITS:
            raise ValueError(f"unit = {self.unit!r} must be one of {', '.join(UNITS)}")
        if self.unit is not None and self.quantity not in ("auto", UNITS[self.unit][0]):
            raise ValueError(
                f"quantity = {self.quantity!r} is not what unit = {self.unit!r} is of; leave one of them out"
            )
        return self


SILENT = Choices()
"""The user says nothing."""


@contextmanager
def reading(path: Path, how: str, key: str = "ground.file") -> Iterator[None]:
    """Turns whatever a library raises at a damaged file into a ValueError: it cannot be read ``how``."""
    try:
        yield
    except Exception as error:
        raise ValueError(f"{key} = {path.name!r} cannot be read{how}: {error}") from error


def existing(path: Path, key: str = "ground.file") -> Path:
    """The path; raises ValueError, naming ``key``, where there is no such file."""
    if not path.is_file():
        raise ValueError(f"{key} = {path.name!r}: there is no such file in {path.parent}")
    return path


def choose_axes(components: dict[str, tuple[str, ...]], axes: AxisChoice) -> dict[str, Place]:
    """Axis of each component that is used.

    ``components`` maps each component's full name to all names it answers to; ``axes`` maps names to axes, None for the
    standard ones. Raises ValueError for a component without axis, a name without component, and an axis taken twice.
    """
    known = STANDARD_AXES if axes is None else axes
    chosen: dict[str, Place] = {}
    for component, names in components.items():
        axis = next((known[name] for name in names if name in known), None)
        if axis is not None:
            chosen[component] = axis
        elif axes is None:
            raise ValueError(
                f"ground.axes does not say which axis {component!r} is; name it, for instance "
                f'axes = {{ {names[-1] or component!r} = "x" }}; else {", ".join(STANDARD_AXES)} are known'
            )
    held = ", ".join(components)
    missing = [name for name in axes or {} if not any(name in names for names in components.values())]
    if missing:
        raise ValueError(f"ground.axes names {missing[0]!r}, which the record does not hold; it holds {held}")
    twice = [axis for axis, count in Counter(chosen.values()).items() if count > 1]
    if twice:
        both = ", ".join(component for component, axis in chosen.items() if axis == twice[0])
        raise ValueError(
            f"ground.axes: {both} are all {twice[0]}; each axis takes one component; choose with ground.axes"
        )
    if not chosen:
        raise ValueError(f"ground.axes = {axes} leaves no component; the record holds {held}")
    return chosen


def per_mount(places: Iterable[str]) -> bool:
    """Whether some of the places are those of a single mount."""
    return any(" " in place for place in places)


def agreed_unit(
    choices: Choices, found: tuple[Quantity, float] | None, name: str, remedy: str
) -> tuple[Quantity, float]:
    """What a channel holds, and its unit's SI value: as the file says (``found``), or as the user says.

    Raises ValueError where neither says it, or the two disagree.
    """
    wanted = choices.quantity
    if choices.unit is not None:
        if found is not None:
            raise ValueError(
                f"ground.unit = {choices.unit!r}, but the file states the unit of {name} itself; leave ground.unit out"
            )
        found = UNITS[choices.unit]
    if found is None:
        if wanted == "auto":
            raise ValueError(
                f"ground.quantity = 'auto', but the file does not say what {name} holds; set displacement, velocity or "
                f"acceleration (samples are then SI), or {remedy}"
            )
        return wanted, 1.0
    if wanted not in ("auto", found[0]):
        raise ValueError(
            f"ground.quantity = {wanted!r}, but the file says that {name} is {found[0]}; use 'auto' or {found[0]!r}"
        )
    return found


def clock(time: Array, name: str, gaps: GapChoice) -> tuple[float, Array, list[str]]:
    """Rate [Hz] of samples at ``time`` [s], their places on the uniform grid, and remarks on gaps.

    Raises ValueError where times do not rise, lie off the grid, or leave gaps that may not be filled.
    """
    forward = np.diff(time)
    rising = (forward > 0) & np.isfinite(forward)
    if time.size < 2 or not rising.all():
        row = int(np.argmin(rising)) + 2 if time.size > 1 else 1
        raise ValueError(f"ground.file = {name!r}: time must rise from row to row; it does not at sample {row}")
    index = np.concatenate([[0.0], np.cumsum(np.maximum(1.0, np.round(forward / np.median(forward))))])
    step = (time[-1] - time[0]) / index[-1]
    worst = int(np.argmax(np.abs(time - time[0] - index * step)))
    jitter = abs(time[worst] - time[0] - index[worst] * step) / step
    if jitter > JITTER:
        raise ValueError(
            f"ground.file = {name!r}: sampling is not uniform: sample {worst + 1} is {jitter:.2g} steps "
            f"off its place, {JITTER:g} are allowed; resample it, or state its rate instead of the times"
        )
    missing = int(index[-1]) + 1 - time.size
    if not missing:
        return 1.0 / step, index, []
    holes = int(np.sum(np.diff(index) > 1))
    return 1.0 / step, index, [filled(name, holes, missing * step, time.size * step, gaps)]


def on_grid(index: Array, samples: Array) -> Array:
    """Samples (n,) at places ``index`` of a uniform grid, with straight lines over what is missing."""
    return np.interp(np.arange(int(index[-1]) + 1), index, samples)


def filled(name: str, holes: int, missing: float, recorded: float, gaps: GapChoice) -> str:
    """The remark on ``missing`` seconds in so many holes; raises ValueError where they may not be filled."""
    whole = f"{holes} gap{'s' if holes > 1 else ''}, {missing:.4g} s in total"
    if missing > recorded:
        raise ValueError(f"ground.file = {name!r} has {whole}, more than it holds ({recorded:.4g} s); cut it")
    if gaps == "error":
        raise ValueError(
            f'ground.file = {name!r} has {whole}; set ground.gaps = "interpolate" to fill with straight lines'
        )
    return f"record {name} has {whole}, filled with straight lines"


def recorded(label: str, channels: Sequence[Channel], notes: Sequence[str] = (), name: str | None = None) -> Record:
    """The record of a file, called ``label`` unless it has a name; its notes begin with what was read."""
    parts = (f"{c.axis} from {c.name} ({c.quantity}, {c.end - c.time:g} s at {c.rate:g} Hz)" for c in channels)
    summary = f"record {label}: " + "; ".join(parts)
    return Record(name or label, tuple(channels), (summary, *_differences(channels), *notes))


def _differences(channels: Sequence[Channel]) -> list[str]:
    """Remarks where channels differ in rate or span."""
    notes = []
    if len({channel.rate for channel in channels}) > 1:
        notes.append("sampling rates differ: " + ", ".join(f"{c.axis} {c.rate:g} Hz" for c in channels))
    late, early = (max(values) - min(values) for values in ([c.time for c in channels], [c.end for c in channels]))
    if max(late, early) * min(channel.rate for channel in channels) > 1.5:
        notes.append(f"channels begin up to {late:g} s and end up to {early:g} s apart; the common part is used")
    return notes
