"""Strong-motion records as the European (ESM) and the Italian (ITACA) archive write them: DYNA and ITACA ASCII."""

import math
import re
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from ehamj.records.channel import Record
from ehamj.records.choices import SILENT, Choices
from ehamj.records.components import Component, Loaded, record_of
from ehamj.records.files import matching
from ehamj.records.lines import lines_of
from ehamj.records.text import check_quantity, numbers

QUANTITIES = {
    "ACCELERATION": "acceleration",
    "UNPROCESSED ACCELERATION": "acceleration",
    "PROCESSED ACCELERATION": "acceleration",
    "VELOCITY": "velocity",
    "DISPLACEMENT": "displacement",
}
"""Data types that are time histories; spectra are none."""

ITACA_AXES = {"WE": "E", "EW": "E", "NS": "N", "UP": "Z"}
"""Components of the older ITACA header."""

_LINE = re.compile(r"([A-Z][A-Z0-9_/^()\s-]*?)\s*:(.*)")
_FIRST = "DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS"


def looks_esm(head: bytes) -> bool:
    """Whether a file begins with the archives' header."""
    return re.match(rb"(\xef\xbb\xbf)?EVENT_NAME\s*:", head) is not None


def read_esm(path: Path, choices: Choices = SILENT) -> Record:
    """A record of the ESM or ITACA database: lines ``KEY: value``, then one sample per line.

    The last part of ``path`` may hold wildcards, for one file per component. A component is called
    ``network.station.location.stream`` and answers to its stream (``HNZ``) and the stream's last letter. Raises
    ValueError where a header does not state data type, unit, number and step, or the samples are not as many.
    """
    components = []
    for file in matching(path):
        lines = lines_of(file, "ground.file").lines
        header = _header(lines)
        stream = header.get("STREAM") or ITACA_AXES.get(header.get("COMPONENT", ""), "")
        station = ".".join(header.get(key, "") for key in ("NETWORK", "STATION_CODE", "LOCATION"))
        answers = (stream, stream[-1:], file.name)
        name = f"{station}.{stream}" if stream else file.name
        load = partial(_load, file.name, lines, header)
        components.append(Component(name, load, tuple(filter(None, answers)), station))
    return record_of(path.name, components, choices, "state UNITS in its header")


def _header(lines: list[str]) -> dict[str, str]:
    """Keys and values of the lines before the first that is none."""
    found: dict[str, str] = {}
    for line in lines:
        match = _LINE.fullmatch(line.strip())
        if match is None:
            break
        found[match[1]] = match[2].strip()
    return found


def _load(label: str, lines: list[str], header: dict[str, str]) -> Loaded:
    where = f"ground.file = {label!r}"

    def stated(key: str) -> str:
        if not header.get(key):
            raise ValueError(f"{where}: its header states no {key}; it is no record of ESM or ITACA, or a damaged one")
        return header[key]

    def number(key: str) -> float:
        try:
            value = float(stated(key))
        except ValueError:
            value = math.nan
        if not 0 < value < math.inf:
            raise ValueError(f"{where}: its header states {key}: {stated(key)[:40]}, which must be a positive number")
        return value

    kind, unit = stated("DATA_TYPE").upper(), stated("UNITS")
    if kind not in QUANTITIES:
        raise ValueError(
            f"{where}: its DATA_TYPE is {kind!r}, which is no time history; known are {', '.join(QUANTITIES)}"
        )
    check_quantity(where, QUANTITIES[kind], unit)
    count = number("NDATA")
    samples = numbers(label, lines, len(header), int(count), "NDATA")
    return Loaded(samples, 1.0 / number("SAMPLING_INTERVAL_S"), unit, _begin(header), notes=_filters(label, header))


def _begin(header: dict[str, str]) -> float:
    """Time of the first sample [s], in UTC; 0 where it is not stated."""
    try:
        found = datetime.strptime(header.get(_FIRST, ""), "%Y%m%d_%H%M%S.%f")
    except ValueError:
        return 0.0
    return found.replace(tzinfo=UTC).timestamp()


def _filters(label: str, header: dict[str, str]) -> tuple[str, ...]:
    """A remark on the band that the archive's processing has left."""
    keys = {"below": "LOW_CUT_FREQUENCY_HZ", "above": "HIGH_CUT_FREQUENCY_HZ"}
    cuts = [(words, header.get(key, "")) for words, key in keys.items()]
    found = [f"{words} {cut} Hz" for words, cut in cuts if re.fullmatch(r"\d*\.?\d+", cut) and float(cut) > 0]
    return (f"{label} was filtered by the archive: motion {' and '.join(found)} is understated",) if found else ()
