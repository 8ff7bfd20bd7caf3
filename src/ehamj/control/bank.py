"""Laws of several rates and delays that run side by side into the same four valves."""

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ehamj.belonging import RUN
from ehamj.control.clock import common_divisor, exact
from ehamj.control.converter import Converter, difference, reads
from ehamj.control.foreign import is_foreign, own_table
from ehamj.control.law import UNSTABLE, Controller, stack
from ehamj.control.lines import Line
from ehamj.control.tables import check_keys, law_in
from ehamj.errors import InputError

LONGEST_PATTERN = 100_000
"""Samples after which the pattern of all rates must repeat, for its stability to be looked at."""


@dataclass(frozen=True)
class ControllerBank:
    """Laws each with its own period and delay; their held outputs are summed before fade, range and resolution.

    All share one `Converter`. What fade and range take from the sum goes into every law's anti-windup.

    Raises:
        InputError: if there is no law, if they do not share a converter, or together are unstable while their
            commands are limited.
    """

    parts: tuple[Controller, ...]

    def __post_init__(self) -> None:
        if not self.parts:
            raise InputError("controller.parts: is empty; it must hold at least one law")
        if found := difference(self.parts):
            name, ours, theirs = found
            raise InputError(f"controller.parts: {name} = {theirs} beside {ours}; all must share one converter")
        radius = self._limited_radius()
        if radius > UNSTABLE:
            raise InputError(
                "controller.parts: unstable while the commands are limited: from one common sample to the next, an "
                f"eigenvalue has magnitude {radius:.9g}; it must be at most 1"
            )

    @classmethod
    def combine(cls, laws: Sequence[Controller]) -> "Controller | Self":
        """Laws side by side: those of one period and delay become one law, and if all do, that law is returned.

        Raises:
            InputError: as the class.
        """
        groups: dict[tuple[float, float], list[Controller]] = {}
        for law in laws:
            groups.setdefault((law.period, law.latency), []).append(replace(law, delay=law.latency))
        parts = tuple(stack(group) for group in groups.values())
        return parts[0] if len(parts) == 1 else cls(parts)

    @property
    def inputs(self) -> tuple[str, ...]:
        """Every measured channel, each once."""
        return tuple(dict.fromkeys(name for part in self.parts for name in part.inputs))

    @property
    def lines(self) -> tuple[Line, ...]:
        """Lines that its laws follow, each with its place in its own law."""
        return tuple(line for part in self.parts for line in part.lines)

    @property
    def reads(self) -> tuple[str, ...]:
        """Every channel that is measured, those of the stage before the converter last."""
        return reads(self.inputs, self.converter)

    @property
    def period(self) -> float:
        """Longest time of which all periods are multiples [s]."""
        return float(common_divisor(part.period for part in self.parts))

    @property
    def converter(self) -> Converter:
        """The converter that all laws share."""
        return self.parts[0].converter

    @property
    def states(self) -> int:
        """Number of states of all laws."""
        return sum(part.states for part in self.parts)

    def with_anti_windup(self, time: float = 0.02) -> Self:
        """The bank with an anti-windup matrix for each law, see `Controller.with_anti_windup`."""
        return replace(self, parts=tuple(part.with_anti_windup(time) for part in self.parts))

    def scaled(self, factor: float) -> Self:
        """The bank with all its gains multiplied."""
        return replace(self, parts=tuple(part.scaled(factor) for part in self.parts))

    def turned(self, end: Literal["low", "high"]) -> Self:
        """The bank with all lines that its laws follow at the end of their ranges."""
        return replace(self, parts=tuple(part.turned(end) for part in self.parts))

    def response(self, hertz: ArrayLike) -> NDArray[np.complex128]:
        """Command over measured channel, (frequency, valves, inputs), the sum of all laws (`Controller.response`)."""
        names = self.inputs
        total = np.zeros((np.atleast_1d(hertz).size, len(self.converter.mounts), len(names)), complex)
        for part in self.parts:
            total[:, :, [names.index(name) for name in part.inputs]] += part.response(hertz)
        return total

    def save(self, path: str | Path) -> None:
        """Write the bank as JSON."""
        Path(path).write_text(json.dumps(self.to_dict(), indent=1) + "\n", encoding="utf-8")

    def to_dict(self) -> dict[str, Any]:
        """The bank as plain data."""
        return {"parts": [part.to_dict() for part in self.parts]}

    @classmethod
    def from_dict(cls, table: dict[str, Any]) -> Self:
        """The inverse of `to_dict`.

        Raises:
            InputError: as the class and `Controller.from_dict`.
        """
        parts = table.get("parts")
        if not isinstance(parts, list) or not all(isinstance(part, dict) for part in parts):
            raise InputError("controller.parts: must be a list of laws")
        check_keys("controller", table, ("parts", RUN))
        return cls(tuple(Controller.from_dict(part) for part in parts))

    def _limited_radius(self) -> float:
        """Spectral radius, from one common sample to the next, of all states while the valves get nothing."""
        base = common_divisor(part.period for part in self.parts)
        every = [round(exact(part.period) / base) for part in self.parts]
        pattern = math.lcm(*every)
        if pattern > LONGEST_PATTERN:
            raise InputError(
                f"controller.parts: periods {', '.join(f'{part.period:g}' for part in self.parts)} s have no common "
                "pattern that is short; choose multiples of each other"
            )
        n, m = self.states, len(self.converter.mounts)
        ends = np.cumsum([part.states for part in self.parts])
        size = n + m * len(self.parts)  # states, then what each law last wanted
        total = np.eye(size)
        for sample in range(pattern):
            due = [k for k in range(len(self.parts)) if sample % every[k] == 0]
            if not due:
                continue
            outputs, update = np.eye(size), np.eye(size)
            for k in due:
                own, last = slice(ends[k] - self.parts[k].states, ends[k]), slice(n + m * k, n + m * (k + 1))
                outputs[last] = 0.0
                outputs[last, own] = self.parts[k].C
                update[own, own] = self.parts[k].A
                windup = self.parts[k].anti_windup
                if windup is not None:
                    update[own, n:] -= np.tile(windup, len(self.parts))
            total = update @ outputs @ total
        winds = any(part.anti_windup is not None for part in self.parts)
        return float(np.abs(np.linalg.eigvals(total)).max()) if n and winds else 0.0


def load_controller(path: str | Path) -> Controller | ControllerBank:
    """Read a law or a bank of laws: JSON as ``save`` wrote it, or a discrete system as other tools write it, a struct
    in a MATLAB file (``.mat``) or python-control's arguments in JSON (`ehamj.control.foreign`).

    Raises:
        InputError: if the file cannot be read, and as the classes.
    """
    if Path(path).suffix.lower() == ".mat":
        from ehamj.control.matlab_law import matlab_table

        return law_in(path, _made, matlab_table)
    return law_in(path, _made)


def _made(table: dict[str, Any]) -> Controller | ControllerBank:
    table = own_table(table) if is_foreign(table) else table
    return (ControllerBank if "parts" in table else Controller).from_dict(table)
