"""What a study comes out with: answers in words, labelled tables, drawings."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import xarray as xr

from ehamj.plots import Figure

Progress = Callable[[str], None]
"""Called with what is being done now."""


def silent(text: str) -> None:
    """No progress is shown."""


@dataclass(frozen=True)
class Drawing:
    """A figure, drawn when it is asked for, and what it says."""

    caption: str
    draw: Callable[[], Figure]


@dataclass(frozen=True)
class Outcome:
    """One study of one machine.

    Every variable and coordinate of ``tables`` has ``long_name`` and, where it is a number, ``units``.
    """

    title: str
    question: str
    answers: tuple[str, ...]
    """What came out, a sentence or two each; the most important first."""
    tables: Mapping[str, xr.Dataset]
    drawings: Mapping[str, Drawing]
    notes: tuple[str, ...] = ()
    """What holds and what does not: assumptions, limits."""
    numbers: Mapping[str, Any] = field(default_factory=dict)
    """The few numbers that a script asks for, as plain data."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """What the study was asked with, as plain data."""


def labelled(dims: tuple[str, ...], values: Any, units: str, long_name: str) -> tuple[Any, Any, dict[str, str]]:
    """A variable for `xarray.Dataset`; ``units`` "" for what has none (names, flags)."""
    attributes = {"long_name": long_name} | ({"units": units} if units else {})
    return dims, values, attributes
