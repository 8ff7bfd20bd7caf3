"""Damaged seismic files and metadata: a record or a refusal, in no time, and never a number off by a unit."""

import re
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from obspy import read_inventory as obspy_inventory
from oracles.damage import damaged
from oracles.records import read
from oracles.seismic import flat, metadata, trace, write

MANY = 100
"""Damaged files of each kind."""

LONGEST = 5.0
"""Longest time that one of them may take [s]: they take milliseconds, the machine may stall."""

COUNTS = np.round(1e4 * np.sin(np.arange(600) / 7)).astype(np.int32)
SI: dict[str, Any] = {"remove_response": False, "quantity": "velocity"}

FORMATS: dict[str, Callable[[Path], Path]] = {
    "Steim": lambda path: write(path, trace(COUNTS), reclen=512, encoding="STEIM2"),
    "integers": lambda path: write(path, trace(COUNTS), reclen=256, encoding="INT32"),
    "SAC": lambda path: write(path, trace(np.float32(COUNTS)), kind="SAC"),
    "SACXY": lambda path: write(path, trace(np.float32(COUNTS)), kind="SACXY"),
    "SEGY": lambda path: write(path, trace(np.float32(COUNTS)), kind="SEGY"),
    "SU": lambda path: write(path, trace(np.float32(COUNTS)), kind="SU"),
    "SLIST": lambda path: write(path, trace(COUNTS), kind="SLIST"),
    "TSPAIR": lambda path: write(path, trace(COUNTS), kind="TSPAIR"),
    "GSE2": lambda path: write(path, trace(COUNTS), kind="GSE2"),
    "GCF": lambda path: write(path, trace(COUNTS), kind="GCF"),
    "AH": lambda path: write(path, trace(np.float32(COUNTS)), kind="AH"),
}


BY_RECORD = ("Steim", "integers")
"""Formats of miniSEED, which has records that can be left out."""


def outcome(path: Path, **choices: Any) -> str:
    """What becomes of a file: empty for a record, else the refusal."""
    begin, record, said = time.process_time(), None, ""
    try:
        record = read(path, **choices)
    except ValueError as error:
        said = str(error)
    assert time.process_time() - begin < LONGEST
    if record is None:
        assert said.startswith("ground.")
        assert "\n" not in said
        return said
    for channel in record.channels:
        assert channel.rate > 0
        if channel.response is not None:
            assert np.isfinite(channel.response(np.array([1.0, 10.0]))).all()
    return ""


@pytest.mark.parametrize(
    ("kind", "damage"), [*((kind, "refuse") for kind in FORMATS), *((kind, "skip") for kind in BY_RECORD)]
)
def test_damaged_records_are_refused_or_read(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], kind: str, damage: str
) -> None:
    path = FORMATS[kind](tmp_path / "a.rec")
    intact, random, refused = path.read_bytes(), np.random.default_rng(5), 0
    for _ in range(MANY):
        path.write_bytes(damaged(intact, random, 640))
        refused += bool(outcome(path, axes={"1": "z"}, damaged=damage, gaps="interpolate", **SI))
    assert refused > MANY / 20  # the damage does some
    assert "Traceback" not in capfd.readouterr().err


NUMBER = re.compile(r">(-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)<")
ELEMENT = re.compile(r"<(\w+)[^<>]*>[^<>]*</\1>")
BLOCK = re.compile(r"(?s)<(Stage|PolesZeros|Coefficients|FIR|Decimation|StageGain|Zero|Pole|Numerator)\b.*?</\1>")


def mangled(text: str, random: np.random.Generator) -> bytes:
    """Metadata with absurd numbers, or elements that are lost or doubled."""
    kind = random.integers(0, 4)
    if kind == 0:
        return damaged(text.encode(), random, 640)
    pattern = (NUMBER, ELEMENT, BLOCK)[kind - 1]
    for _ in range(int(random.integers(1, 4))):
        places = list(pattern.finditer(text))
        if not places:
            break
        one = places[int(random.integers(0, len(places)))]
        if kind == 1:
            absurd = random.choice(["0", "-1", "1e308", "-1e308", "1e-308", "nan", "inf", "", "2147483648", "x"])
            text = text[: one.start(1)] + absurd + text[one.end(1) :]
        else:
            text = text[: one.start()] + one[0] * int(random.integers(0, 2) * 2) + text[one.end() :]
    return text.encode()


def test_mangled_metadata_are_refused_or_evaluated(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mseed", trace(COUNTS, "EHZ", network="BW", station="RJOB"))
    real = obspy_inventory().select(station="RJOB", channel="EHZ", time=trace(COUNTS).stats.starttime)
    real.write(str(tmp_path / "real.xml"), format="STATIONXML")
    text, random, refused = (tmp_path / "real.xml").read_text(), np.random.default_rng(6), 0
    assert not outcome(path, inventory=str(tmp_path / "real.xml"))
    for _ in range(2 * MANY):
        (tmp_path / "b.xml").write_bytes(mangled(text, random))
        refused += bool(outcome(path, inventory=str(tmp_path / "b.xml"), axes={"EHZ": "z"}))
    assert refused > MANY / 2


POLES = (
    "* NETWORK   (KNETWK): XX\n* STATION    (KSTNM): ONE\n* CHANNEL   (KCMPNM): HHZ\n* START : 2020-01-01T00:00:00\n"
    "* INPUT UNIT        : M\n* OUTPUT UNIT       : COUNTS\nZEROS 3\n0 0\nPOLES 2\n-17 22.6\n-17 -22.6\nCONSTANT 3e7\n"
)


def test_damaged_poles_and_zeros_are_refused_or_evaluated(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mseed", trace(COUNTS))
    random, refused = np.random.default_rng(7), 0
    for _ in range(2 * MANY):
        (tmp_path / "a.pz").write_bytes(damaged(POLES.encode(), random, 640))
        refused += bool(outcome(path, inventory=str(tmp_path / "a.pz")))
    assert refused > MANY / 4


@given(st.text("mMsSnukcgGEC/^*²(){}[]0123.- ·", max_size=9), st.booleans())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=80)
def test_any_unit_is_refused_or_means_one_thing(tmp_path: Path, unit: str, overall: bool) -> None:
    from ehamj.records.units import motion_unit

    path = write(tmp_path / "a.mseed", trace(COUNTS))
    made = flat(1e6, unit or " ")
    if overall:
        made.response_stages = []
    said = outcome(path, inventory=str(metadata(tmp_path / "a.xml", made)))
    try:
        size = motion_unit(unit)[1]
    except ValueError:
        assert said
        return
    if not said:
        (channel,) = read(path, inventory=str(tmp_path / "a.xml")).channels
        assert channel.response is not None
        assert channel.response(np.array([5.0]))[0] == pytest.approx(1e6 / size, rel=1e-9)


@given(st.binary(max_size=700))
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=40)
def test_any_bytes_are_no_record_and_no_response(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.mseed").write_bytes(content)
    assert outcome(tmp_path / "a.mseed", **SI)
    assert outcome(write(tmp_path / "b.mseed", trace(COUNTS)), inventory=str(tmp_path / "a.mseed"))
