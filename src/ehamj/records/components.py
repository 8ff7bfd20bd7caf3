"""What every reader of records shares: axes, quantities and units, and remarks on what was found."""

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from ehamj.records.channel import Channel, Place, Record
from ehamj.records.choices import AxisChoice, Choices
from ehamj.records.units import UNITS, Quantity

STANDARD_AXES: dict[str, Place] = {"E": "x", "N": "y", "Z": "z", "x": "x", "y": "y", "z": "z"}


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
