"""Two thousand damaged tables: each is refused in one line, or read as the motion that it held."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from random import Random

import numpy as np
import pytest
from oracles.tables import CLOCKS, HEADERS, RATE, TIME_UNITS, UNITS, Written, sines

from ehamj.records.choices import Choices
from ehamj.records.tables import read_table_record

FILES = 2000
"""Fuzzed files in all, of 2 ms each."""

PARTS = 4
ENCODINGS = ("utf-8", "utf-8-sig", "latin-1", "utf-16", "utf-16-le", "utf-32", "cp850", "utf-7", "cp037")
JUNK = (
    "",
    "nan",
    "OVERLOAD",
    "1.2.3",
    "1,234.5",
    "--",
    "5 mm",
    "0x1F",
    "1_000",
    "١٢",
    "inf",
    "1e999",
    '"',
    "'",
    "\x00",
    "\ufffd",
)


def a_way(random: Random) -> Written:
    """A way to write a table."""
    pick = random.choice
    found = Written(
        pick([",", ";", "\t", "|", " "]),
        pick(".,"),
        pick(HEADERS),
        pick(CLOCKS),
        pick(sorted(TIME_UNITS)),
        pick(sorted(UNITS)),
        pick([("z",), ("x", "y", "z"), ("acc_x", "acc_z")]),
        words=pick([False, False, True]),
        quotes=pick([False, False, True]),
        preamble=pick([(), ("Logger 7", "Serial,0000", "")]),
        footer=pick([(), ("End of data",)]),
    )
    return found if found.possible else a_way(random)


def body(lines: list[str], random: Random) -> int:
    """The number of a line among the rows."""
    return random.randrange(min(5, len(lines) - 1), len(lines))


def cut(text: str, random: Random) -> str:
    return text[: random.randrange(len(text))]


def swap(text: str, random: Random) -> str:
    k = random.randrange(len(text) // 2, len(text) - 1)
    return text[:k] + text[k + 1] + text[k] + text[k + 2 :]


def drop(text: str, random: Random) -> str:
    k = random.randrange(len(text) // 2, len(text))
    return text[:k] + text[k + random.randrange(1, 4) :]


def insert(text: str, random: Random) -> str:
    k = random.randrange(len(text) // 2, len(text))
    return text[:k] + random.choice([*JUNK, ",", ";", ".", "\n", "-", "9"]) + text[k:]


def double_line(text: str, random: Random) -> str:
    lines = text.split("\n")
    k = random.randrange(len(lines))
    return "\n".join([*lines[:k], lines[k], *lines[k:]])


def lose_line(text: str, random: Random) -> str:
    lines = text.split("\n")
    del lines[random.randrange(len(lines))]
    return "\n".join(lines)


def other_cell(text: str, random: Random) -> str:
    lines = text.split("\n")
    k = body(lines, random)
    mark = random.choice(",;\t| ")
    cells = lines[k].split(mark)
    cells[random.randrange(len(cells))] = random.choice(JUNK)
    return "\n".join([*lines[:k], mark.join(cells), *lines[k + 1 :]])


def other_marks(text: str, random: Random) -> str:
    """Other decimal marks in some of the lines, or in all from one on."""
    lines = text.split("\n")
    start, share = random.randrange(len(lines)), random.choice([1.0, 0.5, 0.1])
    old, new = random.sample([".", ",", ";", "\t", " "], 2)
    return "\n".join(
        line.replace(old, new) if k >= start and random.random() < share else line for k, line in enumerate(lines)
    )


def thousands(text: str, random: Random) -> str:
    """Every number a thousand times as large, with a mark of thousands, in all rows: nothing else is a decimal mark."""
    lines = text.split("\n")
    k = body(lines, random)
    return "\n".join([*lines[:k], lines[k].replace("0.", "1,000."), *lines[k + 1 :]])


def shuffle(text: str, random: Random) -> str:
    lines = text.split("\n")
    i, k = random.randrange(len(lines)), random.randrange(len(lines))
    lines[i], lines[k] = lines[k], lines[i]
    return "\n".join(lines)


def twice(text: str, random: Random) -> str:
    return text + text


MUTATIONS: tuple[Callable[[str, Random], str], ...] = (
    *(cut, swap, drop, insert, double_line, lose_line),
    *(other_cell, other_marks, thousands, shuffle, twice),
)


@pytest.mark.parametrize("part", range(PARTS))
def test_fuzzed_tables_are_refused_or_right(tmp_path: Path, part: int) -> None:
    path, read, lines = tmp_path / "a.csv", 0, []
    for number in range(part * FILES // PARTS, (part + 1) * FILES // PARTS):
        random = Random(number)
        way = a_way(random)
        samples = sines(len(way.names), 24)
        text = replace(way, encoding="utf-8").bytes(samples).decode()
        used = random.choices(MUTATIONS, k=random.choice([1, 1, 2, 3]))
        for mutate in used:
            text = mutate(text, random) or "\n"
        content = text.encode(random.choice(ENCODINGS[:5]), errors="replace")
        if random.random() < 0.1:
            content = text.encode(random.choice(ENCODINGS), errors="replace")
        path.write_bytes(content)
        told = f"file {number}: {[mutate.__name__ for mutate in used]}"
        try:
            record = read_table_record(path, Choices(gaps=random.choice(["error", "interpolate"]), damaged="skip"))
        except ValueError as error:
            lines.append(str(error))
            continue
        read += 1
        quantity, size = UNITS[way.unit]
        for channel in record.channels:
            # One damaged cell moves the largest of 24 samples as it likes, and the median by a rank or two.
            assert channel.quantity == quantity, told
            assert channel.rate == pytest.approx(RATE, rel=0.06), told
            middle = float(np.median(np.abs(channel.samples))) / size
            assert 0.35 < middle < 1.0, f"{told}: {middle}"
    assert not any("\n" in line for line in lines)
    assert read > 0.2 * FILES / PARTS  # it is no test of refusals alone
