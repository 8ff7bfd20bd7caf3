"""What tells the times of an array in a MATLAB file: a vector of times, a rate, or a step, by their names.

Known are plain names in any case (``fs``, ``Time``, ``dt``), with a unit at the end (``t_ms``, ``fs_kHz``) or beside,
and what these programs write: B&K PULSE (``File_Header.SampleFrequency``), Simcenter Testlab (``x_values.increment``),
Dewesoft (``Data1_time_NAME``, ``Sample_rate``), Simulink (``time``).
"""

import re
from dataclasses import dataclass
from typing import Any

import numpy as np

from ehamj.records.clock import rounding
from ehamj.records.matlab_names import HEADS, Scope, plain, unit_beside
from ehamj.records.matlab_values import Numbers
from ehamj.records.units import is_silent, unit
from ehamj.signals import Array

TIMES = frozenset(("time", "t", "tm", "ts", "times", "timevector", "seconds"))
RATES = frozenset(
    (
        *("fs", "rate", "ratehz", "srate", "fsamp", "fsample", "samplerate", "samplingrate"),
        *("samplefrequency", "samplingfrequency", "samplefreq", "samplingfreq"),
    )
)
STEPS = frozenset(
    (
        "dt",
        "ts",
        "deltat",
        "timestep",
        "sampletime",
        "samplingtime",
        "sampleinterval",
        "samplinginterval",
        "samplingperiod",
    )
)
DAYS = (6e5, 8e5)
"""Times that look like MATLAB's day numbers: the years 1642 to 2190."""


def split(key: str) -> tuple[str, str]:
    """Plain name and the unit that it ends with: ``t_ms``, ``Fs_kHz``; empty where it has none."""
    match = re.fullmatch(r"(.+?)_*\(?(ms|us|s|sec|hz|khz)\)?", key, re.IGNORECASE)
    if match and plain(match[1]) in TIMES | RATES | STEPS and (plain(key) not in TIMES | RATES | STEPS):
        return plain(match[1]), match[2]
    return plain(key), ""


@dataclass(frozen=True)
class Clock:
    """What tells the times of an array: a vector of times, or numbers for a rate or a step."""

    scope: Scope
    """Where it was found."""
    name: str
    times: Numbers | None
    unit: str
    """Of the times as written; empty: s."""
    stated: tuple[tuple[str, Any, str], ...]
    """Rates and steps: their name, value, and unit as written."""
    start: Any = ""
    """Time of the first sample beside a step."""

    @property
    def length(self) -> int | None:
        """Number of times, None for a rate."""
        return None if self.times is None else int(np.prod(self.times.shape))

    def rates(self, where: str) -> list[float]:
        """The rates that are stated [Hz]; raises ValueError where one is no rate, or two contradict each other."""
        found = []
        for name, value, written in self.stated:
            number = _number(value)
            is_rate = split(name)[0] in RATES
            size = _size(written, f"{where}: {name}", "frequency" if is_rate else "time")
            rate = number * size if is_rate else 1.0 / (number * size) if number > 0 else np.nan
            if not 0 < rate < np.inf:
                raise ValueError(f"{where}: {name} = {number:g} must be a positive number, in {written or 'Hz or s'}")
            found.append(rate)
        if found and max(found) > 1.001 * min(found):
            told = ", ".join(f"{name} = {_number(value):g}" for name, value, _ in self.stated)
            raise ValueError(f"{where}: {told} contradict each other; delete all but one")
        return found

    def seconds(self, where: str) -> tuple[Array, float]:
        """The times and what they are rounded to [s]; raises ValueError where they look like days."""
        assert self.times is not None
        stored = self.times.read()
        time = np.asarray(stored, float).ravel()
        if time.size and DAYS[0] < time[0] < DAYS[1] and np.ptp(time) < 366:
            raise ValueError(f"{where}: {self.name} begins at {time[0]:g}, as MATLAB's day numbers do; save seconds")
        size = _size(self.unit, f"{where}: {self.name}", "time")
        return time * size, rounding(stored) * size

    def begin(self, where: str) -> float:
        """Time of the first sample [s], stated beside a step and in its unit, 0 where it is not."""
        found, (name, _, written) = _number(self.start), self.stated[0]
        size = 1.0 if split(name)[0] in RATES else _size(written, f"{where}: {name}", "time")
        return found * size if np.isfinite(found) else 0.0


def _size(written: str, what: str, kind: str) -> float:
    """SI value of a unit of ``kind``; 1 where none is written."""
    if is_silent(written):
        return 1.0
    try:
        found = unit(written)
    except ValueError as error:
        raise ValueError(f"{what}: {error}") from None
    if found.kind != kind:
        raise ValueError(f"{what} is in {written!r}, which is a unit of {found.kind}, not of {kind}")
    return found.size


def _number(value: Any) -> float:
    """A number, also one written as text; nan where it is none."""
    if isinstance(value, Numbers):
        return float(np.real(np.ravel(value.read())[0])) if np.prod(value.shape) == 1 else np.nan
    match = re.match(r"\s*([-+]?\d+(?:[.,]\d*)?(?:[eE][-+]?\d+)?)\s*(?:hz)?\s*$", str(value), re.IGNORECASE)
    return float(match[1].replace(",", ".")) if match else np.nan


def _single(value: Any) -> bool:
    return isinstance(value, str) or (isinstance(value, Numbers) and np.prod(value.shape) == 1)


def is_clock(key: str, scope: Scope) -> bool:
    """Whether a name is one of times, rates or steps."""
    value, name = scope[key], split(key)[0]
    if _single(value) or plain(key).startswith("data1time"):
        return True
    return name in TIMES or any(
        plain(f"time{other}") == plain(key) or plain(f"{other}time") == plain(key) for other in scope
    )


def clock_of(key: str, shape: tuple[int, ...], scopes: tuple[Scope, ...]) -> Clock | None:
    """What tells the times of the array ``key``, from the innermost scope that has anything."""
    for scope in scopes:
        own = {plain(f"time{key}"), plain(f"{key}time"), plain(key).replace("data1", "data1time", 1)} - {plain(key)}
        special = [k for k in scope if plain(k) in own]
        vectors = special or [k for k in scope if split(k)[0] in TIMES]
        vectors = [k for k in vectors if isinstance(scope[k], Numbers) and not _single(scope[k])]
        fitting = [k for k in vectors if int(np.prod(scope[k].shape)) in shape] or vectors
        heads = [value for k, value in scope.items() if plain(k) in HEADS and isinstance(value, dict)]
        stated = [one for place in (scope, *heads) for one in _stated(place, place is not scope)]
        if fitting:
            written = split(fitting[0])[1] or unit_beside(scope, fitting[0])
            return Clock(scope, fitting[0], scope[fitting[0]], written, tuple(stated))
        if stated:
            start = next((head["start_value"] for head in heads if "start_value" in head), "")
            return Clock(scope, stated[0][0], None, "", tuple(stated), start)
    return None


def _stated(scope: Scope, head: bool) -> list[tuple[str, Any, str]]:
    """Rates and steps of a scope; a ``head`` may be Testlab's ``x_values``, where a step is called ``increment``."""
    quantity = scope.get("quantity")
    label = quantity.get("label", "") if head and isinstance(quantity, dict) else ""
    return [
        (key, value, split(key)[1] or unit_beside(scope, key) or str(label))
        for key, value in scope.items()
        if _single(value) and (split(key)[0] in RATES | STEPS or (head and plain(key) == "increment"))
    ]
