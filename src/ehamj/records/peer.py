"""Strong-motion records as the PEER ground motion database writes them: AT2, VT2 and DT2."""

import math
import re
from functools import partial
from pathlib import Path

from ehamj.records.channel import Record
from ehamj.records.choices import SILENT, Choices
from ehamj.records.components import Component, Loaded, record_of
from ehamj.records.files import matching
from ehamj.records.lines import lines_of
from ehamj.records.text import check_quantity, numbers
from ehamj.records.units import time_unit

HEADER = 4
"""Lines of a header: database; event, date, station, component; quantity and unit; number and step of samples."""

_QUANTITY = re.compile(r"\b(acceleration|velocity|displacement)\b.*\bunits?\s+of\s+(\S+)", re.IGNORECASE)
_NUMBER = r"([-+]?[\d.]+(?:[eEdD][-+]?\d+)?)"
_SAMPLING = (
    re.compile(rf"NPTS\s*=\s*(\d+)\s*,?.*?\bDT\s*=\s*{_NUMBER}\s*([^\s,;]*)", re.IGNORECASE),
    re.compile(rf"^\s*(\d+)\s+{_NUMBER}\s+NPTS\s*,?\s*DT\b\s*(?:IN\b)?\s*([^\s,;]*)", re.IGNORECASE),
)
"""Number of samples, step, and its unit as written."""
VERTICAL = {"UP": 1.0, "UD": 1.0, "VER": 1.0, "VERT": 1.0, "V": 1.0, "DWN": -1.0, "DOWN": -1.0}
"""Vertical components by their names, and the sign that makes up positive."""


def read_peer(path: Path, choices: Choices = SILENT) -> Record:
    """A record of the PEER database: four header lines, then samples in free format, in time [s] from 0.

    The last part of ``path`` may hold wildcards, for one file per component. A component is called as the second line
    ends (an azimuth, ``UP``, ``DWN``) and answers to its file's name; vertical ones answer to ``Z``. Raises ValueError
    where a header does not say quantity, unit, number and step, or the samples are not as many.
    """
    components = []
    for file in matching(path):
        lines = lines_of(file, "ground.file").lines
        name = lines[1].rpartition(",")[2].strip() if len(lines) > 1 and "," in lines[1] else ""
        answers = (name, file.name, file.stem, *(("Z",) if name.upper() in VERTICAL else ()))
        components.append(Component(file.name, partial(_load, file.name, lines, name), tuple(filter(None, answers))))
    return record_of(path.name, components, choices, "write the unit into its third line")


def looks_peer(head: bytes) -> bool:
    """Whether a file begins as those of PEER do."""
    lines = head.decode("latin-1").splitlines()[:HEADER]
    return len(lines) == HEADER and _QUANTITY.search(lines[2]) is not None and _sampling(lines[3]) is not None


def _sampling(line: str) -> re.Match[str] | None:
    return next((found for pattern in _SAMPLING if (found := pattern.search(line))), None)


def _step(where: str, sampling: re.Match[str]) -> float:
    """Time between samples [s], in seconds where the line names no unit; raises ValueError where it is no time."""
    written = sampling[3] or "SEC"
    try:
        size = time_unit(written)
    except ValueError as error:
        raise ValueError(f"{where}: its fourth line states DT in {written!r}: {error}; correct it there") from None
    try:
        step = size * float(re.sub("[dD]", "e", sampling[2]))
    except ValueError:
        step = math.nan
    if not 0 < step < math.inf:
        raise ValueError(f"{where}: its fourth line states DT = {sampling[2]} {written}; it must be a positive number")
    return step


def _load(label: str, lines: list[str], name: str) -> Loaded:
    where = f"ground.file = {label!r}"
    quantity = _QUANTITY.search(lines[2]) if len(lines) > HEADER else None
    sampling = _sampling(lines[3]) if len(lines) > HEADER else None
    if quantity is None:
        raise ValueError(
            f"{where}: its third line must say as in 'ACCELERATION TIME SERIES IN UNITS OF G' what it holds, "
            f"it says {lines[2].strip()[:60] if len(lines) > 2 else 'nothing'!r}"
        )
    if sampling is None:
        raise ValueError(
            f"{where}: its fourth line must say as in 'NPTS= 4000, DT= .0100 SEC' how it is sampled, it says "
            f"{lines[3].strip()[:60]!r}"
        )
    unit = quantity[2].strip(".,;").replace("SEC/SEC", "S/S")
    check_quantity(where, quantity[1].lower(), unit)
    step = _step(where, sampling)
    samples = numbers(label, lines, HEADER, int(sampling[1]), "NPTS")
    sign = VERTICAL.get(name.upper(), 1.0)
    notes = () if sign > 0 else (f"{label}: its component is {name}, so that its sign is turned: up is positive",)
    return Loaded(sign * samples, 1.0 / step, unit, notes=notes)
