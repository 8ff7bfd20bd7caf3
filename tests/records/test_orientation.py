"""Where components point: signs that the metadata state are turned, and what is off its name is said."""

import re
from pathlib import Path

import numpy as np
import obspy
import pytest
from oracles.records import read
from oracles.seismic import flat, metadata, trace, write

WAVE = np.arange(1000, dtype=np.int32) % 97
"""Whose sign shows."""

POINTED = [
    ("HHZ", 0.0, -90.0, 1.0, None),
    ("HHZ", 0.0, 90.0, -1.0, r"the inventory states azimuth 0° and dip 90°, against its name: its sign is turned"),
    ("HHZ", 0.0, 0.0, 1.0, r"dip 0°, 90° off its name: it is taken as named, and not turned"),
    ("HHN", 3.0, 0.0, 1.0, None),
    ("HHN", 180.0, 0.0, -1.0, r"azimuth 180° .*its sign is turned"),
    ("HHE", 90.0, 0.0, 1.0, None),
    ("HHE", 270.0, 0.0, -1.0, r"azimuth 270° .*its sign is turned"),
    ("HHE", 127.0, 0.0, 1.0, r"azimuth 127° and dip 0°, 37° off its name: it is taken as named"),
    ("HH1", 37.0, 0.0, 1.0, r"azimuth 37° and dip 0°; it is taken as ground\.axes says, and not turned"),
]


@pytest.mark.parametrize(("code", "azimuth", "dip", "sign", "said"), POINTED)
@pytest.mark.parametrize("kind", ["inventory", "header"])
def test_components_count_as_their_names_say(
    tmp_path: Path, kind: str, code: str, azimuth: float, dip: float, sign: float, said: str | None
) -> None:
    made = trace(WAVE, code)
    axes = {code: "x"}
    if kind == "inventory":
        xml = metadata(tmp_path / "a.xml", flat(1e8, "M/S"), (code,))
        held = obspy.read_inventory(str(xml))
        held[0][0][0].azimuth, held[0][0][0].dip = azimuth, dip
        held.write(str(xml), format="STATIONXML")
        record = read(write(tmp_path / "a.mseed", made), axes=axes, inventory=str(xml))
    else:
        made.data = WAVE.astype(np.float32)
        made.stats.sac = {"cmpaz": azimuth, "cmpinc": dip + 90.0}
        path = write(tmp_path / "a.sac", made, kind="SAC")
        record = read(path, axes=axes, remove_response=False, unit="m/s")
        said = said and said.replace("the inventory", r"the header \(CMPAZ, CMPINC\)")
    np.testing.assert_array_equal(record.channels[0].samples, sign * WAVE)
    notes = [note for note in record.notes if "states azimuth" in note]
    assert len(notes) == (said is not None)
    if said is not None:
        assert re.search(said, notes[0])


def test_a_header_that_states_nothing_turns_nothing(tmp_path: Path) -> None:
    path = write(tmp_path / "a.sac", trace(WAVE.astype(np.float32)), kind="SAC")
    record = read(path, remove_response=False, unit="m/s")
    np.testing.assert_array_equal(record.channels[0].samples, WAVE)
