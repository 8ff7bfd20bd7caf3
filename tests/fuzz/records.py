"""Records of every format that there is a reader for, small, and damaged."""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np
import tomli_w
from obspy import read_inventory
from oracles.damage import damaged
from oracles.seismic import flat, metadata
from oracles.tables import FIELD, sines
from records.test_fuzzed import FORMATS as BINARIES
from records.test_seismic_fuzzed import FORMATS as SEISMIC
from records.test_seismic_fuzzed import POLES

from fuzz.case import Case
from fuzz.values import wild

SCENARIO: dict[str, Any] = {
    "name": "record", "duration": 0.02, "plates": "tied", "output": {"replay": False, "report": False},
}  # fmt: skip
RUN = ("run", "x.toml", "--out", "out", "--json")
HEAD = 640
"""Bytes of a file that tell how the rest is to be read, about."""


class Good(NamedTuple):
    """A file as it should be, and what is stated of it."""

    name: str
    content: bytes
    stated: dict[str, Any]
    also: dict[str, bytes]


@cache
def good_files() -> tuple[Good, ...]:
    """One of each kind."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        return (*_binaries(folder), *_seismic(folder), *_described(folder), *_tables())


def _binaries(folder: Path) -> list[Good]:
    found = []
    for file, write in BINARIES.values():
        path = folder / file
        path.unlink(missing_ok=True)
        write(path)
        stated: dict[str, Any] = {"quantity": "velocity"} if file in ("a.mat", "a.wav") else {}
        stated |= {"full_scale": 1.0, "axes": {"1": "x", "2": "z"}} if file == "a.wav" else {}
        found.append(Good(file, path.read_bytes(), stated, {}))
    return found


def _seismic(folder: Path) -> list[Good]:
    found = []
    for write in SEISMIC.values():
        content = write(folder / "a.rec").read_bytes()
        (folder / "a.rec").unlink()
        stated = {"remove_response": False, "quantity": "velocity", "axes": {"1": "z"}, "gaps": "interpolate"}
        found.append(Good("a.rec", content, stated, {}))
    return found


def _described(folder: Path) -> list[Good]:
    """Counts with what says of which instrument: StationXML, poles and zeros."""
    SEISMIC["Steim"](folder / "a.mseed")
    record = (folder / "a.mseed").read_bytes()
    xml = metadata(folder / "a.xml", flat(1e6, "M/S")).read_bytes()
    long = (folder / "real.xml", read_inventory().select(station="RJOB", channel="EHZ"))
    long[1].write(str(long[0]), format="STATIONXML")
    stated = {"axes": {"HHZ": "z"}}
    return [
        Good("a.xml", xml, {**stated, "file": "a.mseed", "inventory": "a.xml"}, {"a.mseed": record}),
        Good("a.pz", POLES.encode(), {**stated, "file": "a.mseed", "inventory": "a.pz"}, {"a.mseed": record}),
        Good(
            "a.xml", long[0].read_bytes(), {"file": "example:BW.RJOB", "inventory": "a.xml", "axes": {"EHZ": "z"}}, {}
        ),
    ]


def _tables() -> list[Good]:
    return [Good(name, way.bytes(sines(len(way.names), 100, 1e-3)), {}, {}) for name, way in FIELD.items()]


def record(random: Random, kept: Path) -> Case:
    """A record that is damaged, and now and then stated otherwise too."""
    files = good_files()
    one = random.choice(files)
    content, told = _harmed(random, one, files)
    ground = {"kind": "record", "file": one.name, "taper": 0.01, "highpass": 5.0, **one.stated}
    if random.random() < 0.1:
        ground["damaged"] = "skip"
    if random.random() < 0.1:
        ground["table"] = {random.choice(TABLE): wild(random, 1)}
    if random.random() < 0.1:
        ground["unit"] = random.choice(["m/s", "g", "mm", "counts", "V", "µm/s", ""])
    if random.random() < 0.05:
        other = random.choice(files).name
        ground["file"] = other if ground["file"] == one.name else ground["file"]
        told += f", called {other}"
        return _case(ground, {**one.also, other: content}, told)
    return _case(ground, {**one.also, one.name: content}, told)


TABLE = (
    "encoding",
    "delimiter",
    "decimal",
    "thousands",
    "comment",
    "header",
    "unit_line",
    "first_row",
    "columns",
    "rate",
)


def _case(ground: dict[str, Any], files: dict[str, bytes], told: str) -> Case:
    text = tomli_w.dumps({**SCENARIO, "ground": ground}).encode("utf-8", "surrogateescape")
    return Case({"x.toml": text, **files}, (RUN,), ("ground",), told, damaged=True)


Harm = Callable[[Random, bytes, bytes], bytes]


def _cut(random: Random, content: bytes, other: bytes) -> bytes:
    return content[: random.randrange(len(content))]


def _some(random: Random, content: bytes, other: bytes) -> bytes:
    return damaged(content, np.random.default_rng(random.randrange(2**32)), HEAD, texts=True)


def _spliced(random: Random, content: bytes, other: bytes) -> bytes:
    return content[: random.randrange(len(content))] + other[random.randrange(len(other)) :]


def _other_head(random: Random, content: bytes, other: bytes) -> bytes:
    size = random.choice([4, 16, 64, 128, 512])
    return other[:size] + content[size:]


def _doubled(random: Random, content: bytes, other: bytes) -> bytes:
    return content * random.randint(2, 4)


def _turned(random: Random, content: bytes, other: bytes) -> bytes:
    """Some bits of the head."""
    found = bytearray(content)
    for _ in range(random.randint(1, 6)):
        found[random.randrange(min(HEAD, len(found)))] ^= 1 << random.randrange(8)
    return bytes(found)


HARMS: tuple[Harm, ...] = (_cut, _some, _some, _spliced, _other_head, _doubled, _turned, _turned)


def _harmed(random: Random, one: Good, files: tuple[Good, ...]) -> tuple[bytes, str]:
    harm = random.choice(HARMS)
    content = harm(random, one.content, random.choice(files).content)
    return content, f"{one.name}: {harm.__name__.strip('_').replace('_', ' ')}"
