"""Dates and times of day as loggers write them, to seconds."""

import re
from collections.abc import Sequence
from datetime import datetime
from typing import Literal, NamedTuple

import numpy as np

from ehamj.records.table_choices import DateOrder
from ehamj.signals import Array

Parts = Literal["mm:ss", "hh:mm"]
"""What the parts of a time are that has two."""

DATE = r"(?P<a>\d{1,4})(?P<mark>[-/.])(?P<b>\d{1,2}|[A-Za-zä]{3})(?P=mark)(?P<c>\d{1,4})\.?"
CLOCK = r"(?P<h>\d{1,2}):(?P<m>\d{2})(?::(?P<s>\d{2}))?(?:[.,](?P<f>\d{1,18})|:(?P<ms>\d{3}))?"
HALF = r"(?:\s*(?P<half>[AaPp])\.?[Mm]\.?)?"
ZONE = r"\s*(?P<zone>Z|UTC|GMT|[-+]\d{2}:?(?:\d{2})?)?"
BOTH = re.compile(rf"{DATE}(?:T|\s+|_|-){CLOCK}{HALF}{ZONE}", re.ASCII)
ONLY_DATE = re.compile(DATE, re.ASCII)
ONLY_CLOCK = re.compile(CLOCK + HALF + ZONE, re.ASCII)
ISO = re.compile(r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d(?:[.,]\d{1,9})?Z?", re.ASCII)

ORDERS: dict[DateOrder, str] = {"day-month-year": "dmy", "month-day-year": "mdy", "year-month-day": "ymd"}
_MONTHS = "jan jan feb feb mar mär apr apr may mai jun jun jul jul aug aug sep sep oct okt nov nov dec dez"
MONTHS = {name: 1 + k // 2 for k, name in enumerate(_MONTHS.split())}
"""By their names in English and German."""
DAY = 86_400_000_000_000
"""Nanoseconds of a day."""
NONE = np.iinfo(np.int64).min
"""Stands for no time, as in NumPy."""


class Stamps(NamedTuple):
    """Times since the first [s], with NaN where a cell is empty, and to what they are rounded [s]."""

    time: Array
    resolution: float


def is_stamp(cell: str) -> bool:
    """Whether a cell holds a date, a time of day, or both."""
    return len(cell) < 50 and any(form.fullmatch(cell) for form in (BOTH, ONLY_CLOCK, ONLY_DATE))


def is_date(cell: str) -> bool:
    """Whether a cell holds a date alone."""
    return ONLY_DATE.fullmatch(cell) is not None


def parts_of(unit: str | None) -> Parts | None:
    """What a header's ``[mm:ss]`` or ``[h:min]`` says that times in two parts are, None where it says nothing."""
    plain = re.sub(r"[^a-z:]", "", (unit or "").lower())
    if re.fullmatch(r"m(?:m|in)?:s(?:s|ec)?", plain):
        return "mm:ss"
    return "hh:mm" if re.fullmatch(r"h(?:h|r)?:m(?:m|in)?", plain) else None


def stamps(cells: Sequence[str], order: DateOrder | None, parts: Parts | None = None) -> Stamps:
    """Times of cells that hold dates with times of day, or times of day alone (which go on after midnight).

    Raises ValueError, saying why, where a cell is another, or where the order of day and month matters and is open,
    or whether times in two ``parts`` are hours and minutes.
    """
    iso = order is None and all(cell == "" or ISO.fullmatch(cell) for cell in cells)
    nanoseconds = _iso(cells) if iso else _any(cells, order, parts)
    known = nanoseconds[nanoseconds != NONE]
    if not known.size:
        raise ValueError("holds no time")
    fractions = (re.search(r"[.,](\d+)\s*(?:[AaPp]\.?[Mm]|Z|UTC|GMT|[-+]|$)", cell) for cell in cells[:1000])
    ends = zip(fractions, cells[:1000], strict=True)
    digits = max(len(found[1]) if found else 3 * (cell.count(":") == 3) for found, cell in ends)
    time = np.where(nanoseconds != NONE, 1e-9 * (nanoseconds - known[0]), np.nan)
    return Stamps(time, 10.0**-digits)


def _iso(cells: Sequence[str]) -> np.ndarray:
    """Nanoseconds of ISO dates and times without a zone, or of UTC; `NONE` where a cell is empty."""
    plain = [cell.replace(",", ".").removesuffix("Z") or "NaT" for cell in cells]
    try:
        found = np.array(plain, dtype="datetime64[ns]")
    except ValueError as error:
        raise ValueError(f"holds a date or time that there is none: {error}") from error
    return found.astype(np.int64)


def _any(cells: Sequence[str], order: DateOrder | None, parts: Parts | None) -> np.ndarray:
    """Nanoseconds of dates and times in any form; `NONE` where a cell is empty."""
    found = [BOTH.fullmatch(cell) or ONLY_CLOCK.fullmatch(cell) for cell in cells]
    wrong = next((cell for cell, match in zip(cells, found, strict=True) if match is None and cell), None)
    if wrong is not None:
        raise ValueError(f"holds {wrong[:40]!r}, which is no time")
    dated = {match.re is BOTH for match in found if match is not None}
    if len(dated) > 1:
        raise ValueError("holds times with a date and times without")
    dates = {match.group("a", "mark", "b", "c") for match in found if match is not None and match.re is BOTH}
    days = _days(dates, order) if dates else {}
    nanoseconds = np.array([NONE if match is None else _of_day(match, parts) for match in found], dtype=np.int64)
    if dates:
        day = np.array([0 if m is None else days[m.group("a", "mark", "b", "c")] for m in found], dtype=np.int64)
        return np.where(nanoseconds == NONE, NONE, nanoseconds + day * DAY)
    known = np.flatnonzero(nanoseconds != NONE)
    back = np.concatenate([[0], np.cumsum(np.diff(nanoseconds[known]) < -DAY // 2)]) if known.size else known
    nanoseconds[known] += back * DAY
    return nanoseconds


def _of_day(match: re.Match[str], parts: Parts | None) -> int:
    """Nanoseconds since midnight UTC (or of the clock's own zone, where it names none)."""
    part = match.groupdict()
    hour, minute, second = int(part["h"]), int(part["m"]), part["s"]
    fraction = (part["f"] or part["ms"] or "0").ljust(9, "0")[:9]
    if second is None:
        if match.re is BOTH or part["half"] or (parts == "hh:mm" and part["f"] is None):
            second = "0"
        elif part["f"] is None and parts is None:
            raise ValueError(
                f"holds {match[0]!r}, which may be minutes and seconds or hours and minutes: head it [mm:ss] or "
                "[hh:mm], or state time_unit = 'mm:ss' or 'hh:mm'"
            )
        else:  # 12:34.5 has no hours
            hour, minute, second = 0, hour, part["m"]
    if part["half"]:
        if not 1 <= hour <= 12:
            raise ValueError(f"holds {match[0]!r}, which is no time")
        hour = hour % 12 + 12 * (part["half"] in "Pp")
    if hour > 24 or minute > 59 or int(second) > 60:
        raise ValueError(f"holds {match[0]!r}, which is no time")
    zone = re.fullmatch(r"([-+])(\d\d):?(\d\d)?", part["zone"] or "")
    ahead = int(f"{zone[1]}1") * (60 * int(zone[2]) + int(zone[3] or 0)) if zone else 0
    whole = (3600 * hour + 60 * minute + int(second)) * 1_000_000_000 + int(fraction)
    return whole - 60_000_000_000 * ahead


def _days(dates: set[tuple[str, ...]], order: DateOrder | None) -> dict[tuple[str, ...], int]:
    """Days since the epoch of each date; raises ValueError where the order matters and is open."""
    possible = {}
    for form in (ORDERS[order],) if order else _orders(dates):
        try:
            possible[form] = {date: _day(date, form) for date in dates}
        except ValueError:
            continue
    if not possible:
        example = "".join(min(dates)[i] for i in (0, 1, 2, 1, 3))
        raise ValueError(f"holds {example!r}, which is no date" + (f" as {order}" if order else ""))
    spans = {form: max(days.values()) - min(days.values()) for form, days in possible.items()}
    if len(set(spans.values())) > 1:
        example = "".join(min(dates)[i] for i in (0, 1, 2, 1, 3))
        raise ValueError(f"holds dates such as {example!r}, whose day and month cannot be told apart: set date_order")
    return next(iter(possible.values()))


def _orders(dates: set[tuple[str, ...]]) -> tuple[str, ...]:
    """Orders in which the dates may be written: points go with the day first, and four digits are a year."""
    if all(len(date[0]) == 4 for date in dates):
        return ("ymd",)
    if all(date[1] == "." or date[2].isalpha() for date in dates):
        return ("dmy",)
    return ("dmy", "mdy") if all(len(date[3]) == 4 for date in dates) else ("dmy", "mdy", "ymd")


def _day(date: tuple[str, ...], form: str) -> int:
    """Days since the epoch of a date; raises ValueError where there is no such date."""
    month = int(date[2]) if date[2].isdigit() else MONTHS.get(date[2].lower(), 0)
    numbers = dict(zip(form, (int(date[0]), month, int(date[3])), strict=True))
    year = numbers["y"] + (2000 if numbers["y"] < 100 else 0)
    return datetime(year, numbers["m"], numbers["d"]).toordinal() - datetime(1970, 1, 1).toordinal()
