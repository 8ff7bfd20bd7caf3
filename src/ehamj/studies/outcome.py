"""What a study comes out with: answers in words, labelled tables, drawings."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from ehamj.notebook import html_list
from ehamj.plots import Figure, Line
from ehamj.plots.charts import DASHES
from ehamj.run.progress import Progress, counted, silent

__all__ = ["Drawing", "Outcome", "Progress", "counted", "curves", "decibel", "silent"]


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

    def _repr_html_(self) -> str:
        """Question and answers, as a notebook shows them, and what else there is."""
        kept = f"drawings: {', '.join(self.drawings) or 'none'}; tables: {', '.join(self.tables) or 'none'}"
        return html_list(f"{self.title}: {self.question}", self.answers, kept)


def curves(values: xr.DataArray, of: str, dashes: int = len(DASHES), name: str = "{}") -> list[Line]:
    """A line for each entry of the dimension ``of`` over the other one, in its own colour and in turn of ``dashes``."""
    (over,) = (dim for dim in values.dims if dim != of)
    entries = enumerate(values[of].values)
    x = values[over].values
    return [
        Line(name.format(str(entry).replace("_", " ")), x, values.sel({of: entry}).values, k, k % dashes)
        for k, entry in entries
    ]


def decibel(gain: xr.DataArray) -> xr.DataArray:
    """20 lg of a gain [dB]."""
    return 20 * xr.apply_ufunc(np.log10, gain)
