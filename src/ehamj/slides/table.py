"""A slide whose positions over time are a table, of one's own or from a file."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final, Literal, Self

import numpy as np
import scipy
from pydantic import Field, model_validator

from ehamj.arrays import Array
from ehamj.plain.text import text_of
from ehamj.settings import FileName
from ehamj.signals import Sample, Signal
from ehamj.slides.profile import Profile

REST: Final = [(1, 0.0), (2, 0.0)]
"""Speed and acceleration at both ends of a table."""


class TableProfile(Profile):
    """Positions over time, through which a quintic goes that begins and ends at rest: its acceleration is continuous.

    Before its first and after its last time the slide stands.
    """

    kind: Literal["table"]
    times: tuple[float, ...] = Field((), description="in rising order [s]")
    positions: tuple[float, ...] = Field((), description="coordinate along the rail at each of them [m]")
    file: FileName | None = Field(
        None, description="instead of both: a text of two columns, time [s] and coordinate [m]; # begins a comment"
    )

    @model_validator(mode="after")
    def _readable(self) -> Self:
        if (self.file is not None) == bool(self.times or self.positions):
            raise ValueError("a table is either times and positions, or a file")
        times, positions = self._rows
        if len(times) != len(positions) or len(times) < 2:
            raise ValueError(
                f"times has {len(times)} values and positions {len(positions)}: both must have as many, at least 2"
            )
        if not (np.isfinite(times).all() and np.isfinite(positions).all()):
            raise ValueError("times and positions must be finite numbers")
        if (back := np.flatnonzero(np.diff(times) <= 0)).size:
            k = int(back[0]) + 1
            raise ValueError(f"times.{k} = {times[k]:g} s must be later than the one before, {times[k - 1]:g} s")
        if times[0] < 0:
            raise ValueError(f"times.0 = {times[0]:g} s must be at least 0")
        return self

    @cached_property
    def _rows(self) -> tuple[Array, Array]:
        if self.file is None:
            return np.array(self.times, float), np.array(self.positions, float)
        told = f"file = {Path(self.file).name!r}"
        try:
            lines = [line.partition("#")[0] for line in text_of(Path(self.file)).splitlines()]
            rows = [[float(part) for part in line.replace(",", " ").replace(";", " ").split()] for line in lines]
        except (OSError, ValueError) as error:
            raise ValueError(f"{told}: {error}") from None
        rows = [row for row in rows if row]
        if any(len(row) != 2 for row in rows):
            raise ValueError(f"{told}: each line must hold two numbers, time [s] and coordinate [m]")
        times, positions = np.array(rows, float).reshape(-1, 2).T
        return times, positions

    @property
    def start(self) -> float:
        return float(self._rows[1][0])

    @cached_property
    def _course(self) -> "Through":
        times, positions = self._rows
        spline = scipy.interpolate.make_interp_spline(times, positions, k=5, bc_type=(REST, REST))
        return Through(scipy.interpolate.PPoly.from_spline(spline), times)

    def course(self, start: float) -> Signal:
        return self._course

    def farthest(self, start: float) -> list[tuple[str, float]]:
        times, positions = self._rows
        turns = self._course.spline.derivative().roots(extrapolate=False)
        turns = turns[np.isfinite(turns) & (turns > times[0]) & (turns < times[-1])]
        found = [(f"positions.{k}", float(x)) for k, x in enumerate(positions)]
        between = self._course.sample(turns).value
        return found + [(f"positions at {t:.4g} s", float(x)) for t, x in zip(turns, between, strict=True)]


@dataclass(frozen=True)
class Through:
    """A spline between its first and its last time; it stands outside."""

    spline: Any
    times: Array

    def sample(self, time: Array, left: bool = False) -> Sample:
        at = np.clip(time, self.times[0], self.times[-1])
        inside = (time > self.times[0]) & (time < self.times[-1])
        rates = [np.where(inside, self.spline(at, order), 0.0) for order in (1, 2)]
        return Sample(np.asarray(self.spline(at)), *rates)
