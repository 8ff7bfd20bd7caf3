"""Touchstone-like files: an option line such as ``# Hz S RI R 50``, and rows of a frequency and complex numbers.

Only the container is taken: what the numbers are of, the user says. (Touchstone File Format Specification, IBIS Open
Forum, version 1.1.)
"""

import re
from pathlib import Path
from typing import Final

import numpy as np

from ehamj.arrays import ComplexArray
from ehamj.measured.responses.raw import RawResponse
from ehamj.measured.responses.settings import ResponseChoices, ResponsePair
from ehamj.records.lines import lines_of

SIZES: Final = {"HZ": 1.0, "KHZ": 1e3, "MHZ": 1e6, "GHZ": 1e9}
"""Units of frequency [Hz]; GHz is what a file without one means."""
FORMS: Final = ("RI", "MA", "DB")
"""Real and imaginary part; magnitude, or decibels, and phase in degrees, which is what a file without one means."""
PORTS: Final = re.compile(r"\.s(\d+)p$", re.IGNORECASE)


def looks_touchstone(path: Path, head: bytes) -> bool:
    """Whether a file is one, by its ending or its option line."""
    return bool(PORTS.search(path.name)) or bool(re.search(rb"(?im)^\s*#\s*[kmg]?hz\s+[sygzh]\b", head))


def read_touchstone(path: Path, said: ResponseChoices, outputs: list[str], inputs: list[str]) -> list[RawResponse]:
    """The responses that ``said.pair`` names by their number, or the only one.

    Raises:
        ValueError: where the file is not as it must be, or a number is missing or none of it.
    """
    told = f"ground.file = {path.name!r}"
    rows, size, form = [], 1e9, "MA"
    for number, line in enumerate(lines_of(path, "ground.file").lines, 1):
        text = line.partition("!")[0].strip()
        if text.startswith("#"):
            size, form = _options(text, f"{told}: line {number}")
        elif text.startswith("["):
            raise ValueError(f"{told}: line {number} is a keyword of version 2; export it as version 1")
        elif text:
            try:
                rows.append([float(part) for part in text.split()])
            except ValueError:
                raise ValueError(f"{told}: line {number} holds {text[:40]!r}, not numbers") from None
    numbers = _records(rows, told)
    values: ComplexArray = numbers[:, 1::2] + 1j * numbers[:, 2::2]
    if form != "RI":
        magnitude = values.real if form == "MA" else 10.0 ** (values.real / 20.0)
        values = np.asarray(magnitude * np.exp(1j * np.deg2rad(values.imag)), complex)
    count = values.shape[1]
    found = []
    for k, pair in enumerate(said.pair or _only(count, path.name, outputs, inputs)):
        if pair.number is None or pair.number > count:
            raise ValueError(
                f"ground.pair.{k}.number = {pair.number}: {path.name!r} has {count} complex numbers in a row"
            )
        word = f"{pair.output} over {pair.input}"
        column = np.ascontiguousarray(values[:, pair.number - 1])
        found.append(RawResponse(pair.output, pair.input, size * numbers[:, 0], column, word=word))
    return found


def _options(text: str, told: str) -> tuple[float, str]:
    """Unit of frequencies [Hz] and form of numbers that an option line states."""
    parts = text[1:].upper().split()
    size = next((SIZES[part] for part in parts if part in SIZES), 1e9)
    form = next((part for part in parts if part in FORMS), "MA")
    for part in parts:
        plain = part in SIZES or part in FORMS or part in ("S", "Y", "Z", "G", "H", "R")
        if not plain and not re.fullmatch(r"[\d.]+(?:E[-+]?\d+)?", part):
            raise ValueError(f"{told} holds {part!r}; known are {', '.join((*SIZES, *FORMS))}")
    return size, form


def _records(rows: list[list[float]], told: str) -> np.ndarray:
    """Rows of one frequency each: lines with an odd number of values begin one, others go on with it."""
    if not rows:
        raise ValueError(f"{told} holds no numbers")
    found: list[list[float]] = []
    for row in rows:
        if len(row) % 2:
            found.append([*row])
        elif found:
            found[-1] += row
        else:
            raise ValueError(f"{told}: its first row must begin with a frequency, and hold pairs of numbers after it")
    lengths = {len(row) for row in found}
    if len(lengths) > 1 or min(lengths) < 3:
        raise ValueError(f"{told}: its rows hold {', '.join(map(str, sorted(lengths)))} numbers; all must hold as many")
    return np.array(found)


def _only(count: int, label: str, outputs: list[str], inputs: list[str]) -> tuple[ResponsePair, ...]:
    if count != 1 or len(outputs) != 1 or len(inputs) != 1:
        raise ValueError(
            f"ground.pair is missing: {label!r} has {count} complex numbers in a row; state a [[test.pair]] with "
            "output, input and number for each that is wanted"
        )
    return (ResponsePair(output=outputs[0], input=inputs[0], number=1),)
