"""A user's own limits: a table of text, one column per class.

The first column is ``band [Hz]``, the centres of third-octave bands that have a limit, or ``frequency [Hz]``: points of
a curve, with straight lines between them on double logarithmic paper, read at the centres of the bands that it spans.
Each other column is a class with its unit, of displacement, velocity or acceleration, such as ``tool change [um/s]``.
Lines above may state what levels are compared and what the limits are called:

    # statistic: peak
    # title: spindle maker's limits

A limit of a ``peak`` is one of the whole history. It has a column ``frequency [Hz]``, which is that of the swing that a
peak belongs to; a table of one row holds at all frequencies.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final, Literal, NamedTuple

import numpy as np

from ehamj.arrays import Array
from ehamj.criteria.curves import Limit, Norm
from ehamj.errors import InputError
from ehamj.estimate.bands import Band, band_numbers, bands
from ehamj.estimate.statistics import WORDS, BandStatistic, Statistic
from ehamj.findings import Finding
from ehamj.records.lines import lines_of
from ehamj.records.table_choices import TableChoices
from ehamj.records.tables import Column, read_table
from ehamj.records.units import Quantity, motion_unit

KEY: Final = "criteria.norms"
JUDGED: Final = bands(1.0, 315.0)
"""Bands in which a run has levels."""

STATED: Final = re.compile(r"\s*[#%;!]*\s*(statistics?|title)\s*[:=]\s*(.*?)[\s,;]*", re.IGNORECASE)
LINES: Final = 50
"""Lines in which statements are looked for."""


class OwnClass(Finding):
    """Limits of one class over the rows."""

    name: str
    quantity: Quantity
    limits: tuple[float, ...]
    """[m], [m/s] or [m/s²]."""


class OwnLimits(Finding):
    """What a file states, as a result keeps it: the file may change, or go."""

    file: str
    """Its name without the folder."""
    title: str
    over: Literal["band", "frequency"]
    """Whether rows are third-octave bands, or points of a curve."""
    frequency: tuple[float, ...]
    """Of each row [Hz]."""
    statistic: Statistic
    classes: tuple[OwnClass, ...]
    """From coarsest to strictest."""

    def norm(self) -> "OwnNorm":
        """The norm with these limits.

        Raises:
            ValueError: for rows that no level can be held against.
        """
        frequency = np.array(self.frequency)
        curves = {one.name: Curve(one.quantity, np.array(one.limits)) for one in self.classes}
        order, note = tuple(curves), f"Limits of {self.file}."
        if self.statistic == "peak":
            return OwnNorm(self.title, order, whole=_of_the_peak(self.over, frequency, curves), note=note, stated=self)
        rule = _in_bands(self.over, frequency, curves, self.statistic)
        return OwnNorm(self.title, order, rule, note=note, stated=self)


@dataclass(frozen=True, eq=False, kw_only=True)
class OwnNorm(Norm):
    """A norm with what its file states."""

    stated: OwnLimits


class Curve(NamedTuple):
    """Limits of one class over the rows, [SI]."""

    quantity: Quantity
    values: Array


def own_norm(name: str, statistic: BandStatistic = "rms", written: TableChoices | None = None) -> OwnNorm:
    """The norm that a file states.

    Args:
        name: of the file.
        statistic: of the levels that are compared, where the file states none.
        written: what the user says about the table.

    Raises:
        InputError: naming the file, the place in it and what is allowed.
    """
    path = Path(name)
    told = f"{KEY} = {path.name!r}"
    try:
        found = read_table(path, KEY, written)
        columns, table = found.columns, found.values()
        stated = _stated(lines_of(path, KEY, written.encoding if written else None).lines[:LINES])
        kind = _kind(columns)
        _check_rows(columns, table)
        curves = {column.name: _curve(column, table[:, k]) for k, column in enumerate(columns[1:], start=1)}
        return OwnLimits(
            file=path.name,
            title=stated.get("title") or path.stem,
            over=kind,
            frequency=tuple(table[:, 0].tolist()),
            statistic=_statistic(stated.get("statistic", statistic)),
            classes=tuple(
                OwnClass(name=one, quantity=curves[one].quantity, limits=tuple(curves[one].values.tolist()))
                for one in _ordered(curves, table[:, 0])
            ),
        ).norm()
    except ValueError as error:
        raise InputError(f"{told}: {str(error).removeprefix(f'{told}: ').removeprefix(f'{KEY}: ')}") from error


def _stated(lines: Sequence[str]) -> dict[str, str]:
    """What lines above the rows say of all limits."""
    found: dict[str, str] = {}
    for number, line in enumerate(lines, start=1):
        if (match := STATED.fullmatch(line)) is not None:
            what = match[1].lower().rstrip("s")
            if what in found:
                raise ValueError(f"line {number} states a {what} again")
            found[what] = match[2]
    return found


def _statistic(text: str) -> Statistic:
    for name in WORDS:
        if text.lower() == name:
            return name
    raise ValueError(f"it states 'statistic: {text}'; that must be one of {', '.join(WORDS)}")


def _kind(columns: Sequence[Column]) -> Literal["band", "frequency"]:
    """Whether limits stand for bands, or for points of a curve."""
    first, *classes = columns
    if first.name.lower() not in ("band", "frequency") or (first.unit or "").lower() != "hz":
        unit = "" if first.unit is None else f" [{first.unit}]"
        raise ValueError(f"the first column must be 'band [Hz]' or 'frequency [Hz]', not '{first.name}{unit}'")
    if not classes:
        raise ValueError("a column with limits must follow, such as 'limit [um/s]'")
    names = [column.name for column in classes]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise ValueError(f"two columns are called {twice!r}; each class needs a name of its own")
    return "band" if first.name.lower() == "band" else "frequency"


def _check_rows(columns: Sequence[Column], table: Array) -> None:
    wrong = np.argwhere(~(np.isfinite(table) & (table > 0.0)))
    if wrong.size:
        row, column = wrong[0]
        raise ValueError(f"row {row + 1}: {columns[column].name} = {table[row, column]:g} must be positive and finite")
    falling = np.flatnonzero(np.diff(table[:, 0]) <= 0.0)
    if falling.size:
        row = int(falling[0]) + 1
        raise ValueError(f"row {row + 1}: {columns[0].name} = {table[row, 0]:g} Hz must be above the row before")


def _curve(column: Column, values: Array) -> Curve:
    try:
        quantity, size = motion_unit(column.unit or "")
    except ValueError as error:
        raise ValueError(f"column {column.name!r}: {error}") from None
    return Curve(quantity, size * values)


def _ordered(curves: Mapping[str, Curve], frequency: Array) -> tuple[str, ...]:
    """Classes from coarsest to strictest.

    Raises ValueError where two of them cross: neither would be the stricter.
    """
    power = {"displacement": 1, "velocity": 0, "acceleration": -1}
    speeds = {name: curve.values * (2 * np.pi * frequency) ** power[curve.quantity] for name, curve in curves.items()}
    order = sorted(speeds, key=lambda name: -float(np.log(speeds[name]).sum()))
    for coarse, strict in pairwise(order):
        above = np.flatnonzero(speeds[strict] > speeds[coarse] * (1.0 + 1e-9))
        if above.size:
            raise ValueError(
                f"row {above[0] + 1} ({frequency[above[0]]:g} Hz): {strict!r} is above {coarse!r} there and below "
                "elsewhere; of two classes one must be the stricter in every row, or put them into two files"
            )
    return tuple(order)


def _in_bands(
    kind: str, frequency: Array, curves: Mapping[str, Curve], statistic: Statistic
) -> Callable[[str, str, Band], Limit | None]:
    """The rule of limits in third-octave bands."""
    if kind == "band":
        places = {Band(int(number)): row for row, number in enumerate(band_numbers(frequency))}
        for band, row in places.items():
            if band not in JUDGED:
                raise ValueError(f"row {row + 1}: band {frequency[row]:g} Hz; levels are known from 1 to 315 Hz")
    elif len(frequency) < 2:
        raise ValueError("a curve over frequency needs at least 2 rows; the limit of one band has a column 'band [Hz]'")
    elif not any(frequency[0] <= band.nominal <= frequency[-1] for band in JUDGED):
        raise ValueError(f"{frequency[0]:g} to {frequency[-1]:g} Hz hold no centre of a band from 1 to 315 Hz")

    def rule(name: str, axis: str, band: Band) -> Limit | None:
        quantity, values = curves[name]
        if kind == "band":
            return Limit(float(values[places[band]]), quantity, statistic) if band in places else None
        if band not in JUDGED or not frequency[0] <= band.nominal <= frequency[-1]:
            return None
        at = float(np.exp(np.interp(np.log(band.nominal), np.log(frequency), np.log(values))))
        exact = values[frequency == band.nominal]
        return Limit(float(exact[0]) if exact.size else at, quantity, statistic)

    return rule


def _of_the_peak(kind: str, frequency: Array, curves: Mapping[str, Curve]) -> Callable[[str, str], Limit]:
    """The limit of the whole history's peak, over the frequency of its swing."""
    if kind == "band":
        raise ValueError("a peak is one of the whole history, not of a band: its column is 'frequency [Hz]'")

    def whole(name: str, axis: str) -> Limit:
        quantity, values = curves[name]
        if len(values) == 1:
            return Limit(float(values[0]), quantity, "peak")
        return Limit.of_swings(list(zip(frequency.tolist(), values.tolist(), strict=True)), quantity, logarithmic=True)

    return whole
