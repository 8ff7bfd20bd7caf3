"""Points of the machine that a user asks about, and motions relative to each other."""

import re
from collections.abc import Mapping, Sequence
from typing import Final, Protocol

from pydantic import ConfigDict, Field

from ehamj.errors import did_you_mean
from ehamj.plant.machine import Machine
from ehamj.settings import Settings, Vector3

MARGIN: Final = 1.0
"""How far a point may lie outside the machine's outline [m]: an arm or a workpiece; farther is a slip of the pen."""

RESERVED: Final = ("floor", "feet", "foot", "machine", "cg", "ground", "worst", "verdict", "title")
"""Names that mean something else where points are reported."""

NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,31}")

SPINDLE_NOSE: Final = (0.15, 0.0, 1.06 / 1.9)
"""Where the drawing has its spindle nose, over the machine's size (assumed)."""

Points = Mapping[str, Vector3]


def default_points(machine: Machine) -> dict[str, Vector3]:
    """The spindle nose of the drawing, which is stretched to the machine's size (assumed)."""
    x, y, z = (round(share * length, 6) for share, length in zip(SPINDLE_NOSE, machine.size, strict=True))
    return {"spindle-nose": (x, y, z)}


class Relative(Settings):
    """Motion of one place relative to another, such as a spindle against the floor that a robot stands on."""

    model_config = ConfigDict(serialize_by_alias=True)

    name: str = Field(description="short name", min_length=1)
    origin: str = Field(
        alias="from", description="a name in [points], 'cg', 'foot MOUNT' or 'ground MOUNT': what is seen"
    )
    to: str = Field(description="the same: from where it is seen")


def places(points: Points, mounts: Sequence[str]) -> tuple[str, ...]:
    """Everything that a relative motion can start from or go to."""
    return (*points, "cg", *(f"{what} {mount}" for what in ("foot", "ground") for mount in mounts))


def check_points(points: Points, machine: Machine, mounts: Sequence[str]) -> None:
    """Refuse names that cannot be told apart, and points that belong to no machine of this size.

    Raises:
        ValueError: naming the point and what is allowed.
    """
    for name, place in points.items():
        _check_name("points", name, mounts)
        check_place(f"points.{name}", place, machine)


class Named(Protocol):
    """Whatever a user gives a name."""

    @property
    def name(self) -> str:
        """By which it is found."""


def check_unique(key: str, entries: Sequence[Named]) -> None:
    """Refuse a name that an earlier entry of a list has.

    Raises:
        ValueError: naming the key and the value.
    """
    names = [entry.name for entry in entries]
    for k, name in enumerate(names):
        if name in names[:k]:
            raise ValueError(f"{key}.{k}.name = {name!r} must be unique")


def check_place(key: str, place: Vector3, machine: Machine) -> None:
    """Refuse what is too far from the machine to belong to it.

    Raises:
        ValueError: naming the key, the value and what is allowed.
    """
    length, width, height = machine.size
    low = (-length / 2 - MARGIN, -width / 2 - MARGIN, -MARGIN)
    high = (length / 2 + MARGIN, width / 2 + MARGIN, height + MARGIN)
    if any(not a <= value <= b for a, value, b in zip(low, place, high, strict=True)):
        allowed = ", ".join(f"{a:g} to {b:g}" for a, b in zip(low, high, strict=True))
        raise ValueError(
            f"{key} = {list(place)} must lie within {MARGIN:g} m of the machine's outline "
            f"(machine.size): x, y, z in {allowed} m"
        )


def check_relatives(relatives: Sequence[Relative], points: Points, mounts: Sequence[str]) -> None:
    """Refuse relative motions between places that do not exist, or under a name that is taken.

    Raises:
        ValueError: naming the key, the value and what is allowed.
    """
    known = places(points, mounts)
    check_unique("relative", relatives)
    for k, relative in enumerate(relatives):
        _check_name(f"relative.{k}.name", relative.name, mounts)
        for key, place in (("from", relative.origin), ("to", relative.to)):
            if place not in known:
                near = did_you_mean(place, known)
                raise ValueError(f"relative.{k}.{key} = {place!r}: {near}must be one of {', '.join(map(repr, known))}")
        if relative.origin == relative.to:
            raise ValueError(f"relative.{k}.to = {relative.to!r} must differ from its from")


def _check_name(where: str, name: str, mounts: Sequence[str]) -> None:
    taken = (*RESERVED, *mounts)
    if name in taken or not NAME.fullmatch(name):
        raise ValueError(
            f"{where}: the name {name!r} must consist of at most 32 letters, digits, - and _, "
            f"and not be one of {', '.join(taken)}"
        )
