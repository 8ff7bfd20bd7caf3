"""Traces of seismic files: what is picked is judged, and nothing else; gaps, overlaps and damage by stated options."""

import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import obspy
import pytest
from obspy import Stream
from obspy.core.inventory import Response
from obspy.core.util import get_example_file
from oracles.records import motion, read
from oracles.seismic import BEGIN, TAU, flat, metadata, trace, write

from ehamj.records import seismic
from ehamj.records.channel import Record
from ehamj.records.formats import Format, read_record, record_format
from ehamj.records.seismic import EXAMPLE, read_seismic

SI: dict[str, Any] = {"remove_response": False, "quantity": "velocity"}
WAVE = np.sin(TAU * np.arange(1000) / 100)
COUNTS = np.round(1000 * np.sin(TAU * 2 * np.arange(4000) / 100)).astype(np.int32)


def samples(record: Record, axis: str = "z") -> np.ndarray:
    (found,) = (channel.samples for channel in record.channels if channel.axis == axis)
    return found


def text_trace(channel: str = "LOG") -> Any:
    return trace(np.frombuffer(b"all is well with this station " * 40, "S1"), channel)


# --- choice before judgement --------------------------------------------------------------------------------------

UNPICKED: dict[str, Callable[[], list[Any]]] = {
    "text": lambda: [text_trace()],
    "a gap": lambda: [trace(WAVE[:400], "HHN"), trace(WAVE[500:], "HHN", begin=5.0)],
    "an overlap": lambda: [trace(WAVE, "HHN"), trace(WAVE + 1, "HHN", begin=5.0)],
    "two rates": lambda: [trace(WAVE, "HHN"), trace(WAVE, "HHN", rate=50.0, begin=60.0)],
    "no number": lambda: [trace(WAVE * np.nan, "HHN")],
    "too few samples": lambda: [trace(WAVE[:5], "HHN")],
    "another station": lambda: [trace(WAVE, "HHZ", station="TWO")],
    "another time": lambda: [trace(WAVE, "HHN", begin=1e6)],
}


@pytest.mark.parametrize("fault", UNPICKED)
def test_what_is_not_picked_is_not_judged(tmp_path: Path, fault: str) -> None:
    path = write(tmp_path / "a.mseed", trace(WAVE), *UNPICKED[fault]())
    record = read(path, axes={"XX.ONE..HHZ": "z"}, **SI)
    assert [channel.axis for channel in record.channels] == ["z"]
    np.testing.assert_array_equal(samples(record), WAVE)


def test_what_is_not_picked_needs_no_response(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mseed", trace(WAVE), trace(WAVE, "HHN"))
    xml = metadata(tmp_path / "a.xml", flat(1e8, "M/S"))
    assert len(read(path, axes={"HHZ": "z"}, inventory=str(xml)).channels) == 1
    with pytest.raises(ValueError, match=r"no response of XX\.ONE\.\.HHN"):
        read(path, inventory=str(xml))


def test_text_is_passed_over_and_named_unless_it_is_picked(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mseed", text_trace(), trace(WAVE))
    record = read(path, **SI)
    np.testing.assert_array_equal(samples(record), WAVE)
    assert any("XX.ONE..LOG holds text: passed over" in note for note in record.notes)
    with pytest.raises(ValueError, match=r"channel XX\.ONE\.\.LOG holds text or the like, not samples"):
        read(path, axes={"LOG": "z"}, **SI)


@pytest.mark.parametrize(("kind", "ending"), [("SU", "su"), ("SEGY", "sgy")])
def test_traces_without_a_name_are_picked_by_number(tmp_path: Path, kind: str, ending: str) -> None:
    traces = [trace(np.float32(k * WAVE), "") for k in (1, 2, 3)]
    for one in traces:
        one.stats.network = one.stats.station = ""
    path = write(tmp_path / f"a.{ending}", *traces, kind=kind)
    record = read(path, axes={"3": "z", "1": "x"}, **SI)
    np.testing.assert_allclose(samples(record, "z"), 3 * WAVE, atol=1e-6)  # single precision
    np.testing.assert_allclose(samples(record, "x"), WAVE, atol=1e-6)
    with pytest.raises(ValueError, match=r"ground\.axes does not say which axis number 1 is; .*\{ 1 = \"x\" \}"):
        read(path, **SI)


# --- traces of one channel ----------------------------------------------------------------------------------------


def test_gaps_are_refused_or_filled(tmp_path: Path) -> None:
    path = write(tmp_path / "gap.mseed", trace(COUNTS[:2000]), trace(COUNTS[2010:], begin=20.1))
    with pytest.raises(ValueError, match=r"'gap\.mseed' has 1 gap, 0\.1 s in total; set ground\.gaps = "):
        read(path, **SI)
    record = read(path, gaps="interpolate", **SI)
    assert any("1 gap, 0.1 s in total, filled with straight lines" in note for note in record.notes)
    filled = samples(record)
    np.testing.assert_array_equal(np.delete(filled, range(2000, 2010)), np.delete(COUNTS, range(2000, 2010)))
    # A straight line from sample 1999 to sample 2010; rounding only.
    np.testing.assert_allclose(filled[1999:2011], np.linspace(COUNTS[1999], COUNTS[2010], 12), atol=1e-9)


def test_a_gap_of_years_takes_no_memory(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mseed", trace(COUNTS), trace(COUNTS, begin=1e9))
    with pytest.raises(ValueError, match="more than it holds"):
        read(path, gaps="interpolate", **SI)


@pytest.mark.parametrize("choice", ["refuse", "first", "last"])
def test_overlaps_that_differ_are_the_users_to_settle(tmp_path: Path, choice: str) -> None:
    path = write(tmp_path / "a.mseed", trace(COUNTS[1990:] + 5, begin=19.9), trace(COUNTS[:2000]))
    axes = {"HHZ": "z"}
    if choice == "refuse":
        with pytest.raises(
            ValueError, match=r"overlap by 0\.1 s and differ .*overlap = \"first\" .*its number: 2 \(2026"
        ):
            read(path, axes=axes, **SI)
        return
    record = read(path, axes=axes, overlap=choice, **SI)
    expected = np.concatenate([COUNTS[:2000], COUNTS[2000:] + 5])
    if choice == "last":
        expected[1990:2000] += 5
    np.testing.assert_array_equal(samples(record), expected)
    assert any(f"overlap by 0.1 s; there the one that begins {choice} counts" in note for note in record.notes)


def test_traces_that_do_not_fit_are_picked_by_number(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mseed", trace(WAVE, "HHN"), trace(WAVE), trace(2 * WAVE, rate=50.0, begin=1.0))
    with pytest.raises(ValueError, match=r"HHZ is sampled at 50, 100 Hz; .*number: 3 \(.* 100 Hz\); 4 \(.* 50 Hz\)"):
        read(path, axes={"HHZ": "z"}, **SI)
    np.testing.assert_array_equal(samples(read(path, axes={"4": "z"}, **SI)), 2 * WAVE)
    np.testing.assert_array_equal(samples(read(path, axes={"3": "z"}, **SI)), WAVE)


def test_what_is_there_twice_is_said(tmp_path: Path) -> None:
    path = write(tmp_path / "a.mseed", trace(COUNTS[:2000]), trace(COUNTS[1990:], begin=19.9))
    record = read(path, **SI)
    np.testing.assert_array_equal(samples(record), COUNTS)
    assert any("0.1 s are there twice, with the same samples" in note for note in record.notes)


def test_a_clock_that_was_set_anew_is_said(tmp_path: Path) -> None:
    write(tmp_path / "a1.sac", trace(np.float32(COUNTS[:2000])), kind="SAC")
    write(tmp_path / "a2.sac", trace(np.float32(COUNTS[2000:]), begin=20.003), kind="SAC")
    record = read(tmp_path / "a?.sac", **SI)
    np.testing.assert_array_equal(samples(record), COUNTS)
    assert any("up to 3 ms off" in note for note in record.notes)


# --- damage -------------------------------------------------------------------------------------------------------


def blocks(path: Path, *broken: int, header: bool = False) -> bytes:
    """Steim-compressed records of 512 bytes with damage in some."""
    noise = (1000 * np.random.default_rng(1).standard_normal(3000)).astype(np.int32)
    write(path, trace(noise), reclen=512, encoding="STEIM2")
    content = bytearray(path.read_bytes())
    for number in broken:
        at = number * 512 + (0 if header else 200)
        content[at : at + 10] = b"\x55" * 10
    path.write_bytes(content)
    return bytes(content)


def test_truncated_miniseed_is_refused_wherever_it_breaks_off(tmp_path: Path) -> None:
    path = tmp_path / "a.mseed"
    noise = np.random.default_rng(1).standard_normal((3, 3000))
    whole = write(path, *(trace(noise[k], f"HH{c}") for k, c in enumerate("ENZ")), reclen=4096).read_bytes()
    for size in (0, 1, 127, 130, 4095, *np.random.default_rng(3).integers(4097, len(whole), 40).tolist()):
        if size % 4096 == 0 and size:
            continue  # at the border of two records nothing in the file says that more should follow
        path.write_bytes(whole[:size])
        with pytest.raises(ValueError, match=r"ground\.file = 'a\.mseed' cannot be read"):
            read_seismic(path)
    path.write_bytes(whole)
    assert len(read(path, **SI).channels) == 3


def test_damaged_miniseed_is_refused(tmp_path: Path) -> None:
    blocks(tmp_path / "a.mseed", 3)
    with pytest.raises(ValueError, match=r"'a\.mseed' cannot be read, .*integrity check.*damaged = \"skip\""):
        read(tmp_path / "a.mseed", **SI)


def test_damage_that_obspy_cannot_even_name_is_refused(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "a.mseed"
    content = bytearray(blocks(path, 3))
    for number in range(len(content) // 512):
        content[512 * number + 8 : 512 * number + 10] = b"\xff\xfe"  # the station, in no encoding
    path.write_bytes(content)
    with pytest.raises(ValueError, match=r"'a\.mseed' cannot be read"):
        read(path, **SI)
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.parametrize("header", [False, True])
def test_damaged_records_are_left_out_as_gaps_and_named(tmp_path: Path, header: bool) -> None:
    path = tmp_path / "a.mseed"
    blocks(path)
    whole = samples(read(path, **SI))
    blocks(path, 2, 4, header=header)
    with pytest.raises(ValueError, match=r"has 2 gaps, .*ground\.gaps"):
        read(path, damaged="skip", **SI)
    record = read(path, damaged="skip", gaps="interpolate", **SI)
    found = samples(record)
    assert found.size == whole.size
    same = found == whole
    assert 0.5 < same.mean() < 0.9  # two of some ten records are lost
    edges = np.flatnonzero(np.diff(same.astype(int)))
    assert len(edges[edges > edges[0]]) >= 3
    (note,) = (note for note in record.notes if "damaged" in note)
    assert "a.mseed: 2 damaged records of" in note
    assert ("2 have no header that can be read" if header else "of XX.ONE..HHZ, from 2026-01-05T00:00:0") in note


def test_a_record_that_breaks_off_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "a.mseed"
    content = blocks(path)
    whole = samples(read(path, **SI))
    path.write_bytes(content[:-300])
    record = read(path, damaged="skip", **SI)
    found = samples(record)
    np.testing.assert_array_equal(found, whole[: found.size])
    assert 0.8 * whole.size < found.size < whole.size
    assert any("1 damaged record of" in note for note in record.notes)


def test_skipping_leaves_whole_files_as_they_are(tmp_path: Path) -> None:
    path = tmp_path / "a.mseed"
    blocks(path)
    plain, skipped = read(path, **SI), read(path, damaged="skip", **SI)
    np.testing.assert_array_equal(samples(plain), samples(skipped))
    assert plain.notes == skipped.notes
    path.write_bytes(b"\x55" * 512 * 4)
    with pytest.raises(ValueError, match="cannot be read"):
        read(path, damaged="skip", **SI)


# --- factors and formats ------------------------------------------------------------------------------------------


def test_a_calibration_factor_is_applied_where_no_response_is_removed(tmp_path: Path) -> None:
    path = write(tmp_path / "a.sac", trace(np.float32(WAVE), calib=2.5), kind="SAC")
    record = read(path, **SI)
    np.testing.assert_allclose(samples(record), 2.5 * WAVE, atol=1e-6)  # single precision
    assert any("calibration factor 2.5 is applied" in note for note in record.notes)
    xml = metadata(tmp_path / "a.xml", flat(1e8, "M/S"))
    record = read(path, inventory=str(xml))
    np.testing.assert_allclose(samples(record), WAVE, atol=1e-6)
    assert any("calibration factor 2.5 is not applied, since the response is removed" in note for note in record.notes)


@pytest.mark.parametrize(("written", "axis"), [("E-W", "x"), ("N-S", "y"), ("U-D", "z")])
def test_knet_directions_are_axes(tmp_path: Path, written: str, axis: str) -> None:
    text = Path(get_example_file("test.knet")).read_text()
    assert text.count("E-W") == 1
    (tmp_path / "a.knet").write_text(text.replace("E-W", written))
    assert [channel.axis for channel in read(tmp_path / "a.knet").channels] == [axis]


def test_knet_states_acceleration_itself() -> None:
    record = read(Path(get_example_file("test.knet")), axes={"1": "z"})
    (channel,) = record.channels
    assert channel.quantity == "acceleration"
    assert channel.response is None
    # Read off the file's head: "Max. Acc. (gal) 4.383", about the record's mean.
    assert np.abs(channel.samples - channel.samples.mean()).max() == pytest.approx(4.383e-2, rel=1e-3)


@pytest.mark.parametrize("rate", [300.0, 1 / 0.003, 51200.0, 12.5])
def test_sac_keeps_the_rate_that_its_interval_means(tmp_path: Path, rate: float) -> None:
    path = write(tmp_path / "a.sac", trace(np.float32(WAVE), rate=rate), kind="SAC")
    assert read(path, axes={"HHZ": "z"}, **SI).channels[0].rate == pytest.approx(rate, rel=1e-12)


def test_sac_without_an_interval_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "a.sac", trace(np.float32(WAVE)), kind="SACXY")
    path.write_text(path.read_text().replace("0.01", "0.00", 1))
    with pytest.raises(ValueError, match=r"'a\.sac' cannot be read.*interval of 0 s"):
        read(path, **SI)


def test_remarks_of_obspy_are_passed_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write(tmp_path / "a.sac", trace(np.float32(WAVE)), kind="SAC")

    def talking(path: Path, form: Format) -> Stream:
        warnings.warn("the tide\n is high", stacklevel=1)
        return read_record(path, form)

    monkeypatch.setattr(seismic, "read_record", talking)
    assert "a.sac: ObsPy says: the tide is high" in read(path, **SI).notes


# --- refusals -----------------------------------------------------------------------------------------------------

FAULTS: dict[str, tuple[list[Any], dict[str, Any], str]] = {
    "no response": ([trace(WAVE)], {}, r"ground\.inventory is missing, .* no response of XX\.ONE\.\.HHZ"),
    "inventory missing": ([trace(WAVE)], {"inventory": "no.xml"}, r"ground\.inventory = 'no\.xml': there is no such"),
    "inventory junk": (
        [trace(WAVE)],
        {"inventory": "junk"},
        r"ground\.inventory = 'junk' cannot be read as a file of responses",
    ),
    "other channel": (
        [trace(WAVE, "HHN")],
        {"inventory": "z.xml"},
        r"ground\.inventory has no response of XX\.ONE\.\.HHN .* it holds XX\.ONE\.\.HHZ",
    ),
    "no units": ([trace(WAVE)], {"inventory": "empty.xml"}, r"XX\.ONE\.\.HHZ have neither stages nor"),
    "wrong quantity": (
        [trace(WAVE)],
        {"inventory": "z.xml", "quantity": "acceleration"},
        r"ground\.quantity = 'acceleration', but the file says that 'XX\.ONE\.\.HHZ' is velocity",
    ),
    "no quantity": ([trace(WAVE)], {"remove_response": False}, r"ground\.quantity = 'auto', but the file does not"),
    "unknown component": (
        [trace(WAVE, "HH1")],
        SI,
        r"ground\.axes does not say which axis 'XX\.ONE\.\.HH1' .* \{ 1 = \"x\"",
    ),
    "axis taken twice": (
        [trace(WAVE), trace(WAVE, "HNZ")],
        SI,
        r"HHZ', 'XX\.ONE\.\.HNZ' are all z; each axis takes one",
    ),
    "two stations": (
        [trace(WAVE), trace(WAVE, "HHN", station="TWO")],
        SI,
        r"several stations: XX\.ONE, XX\.TWO; choose with ground\.axes",
    ),
    "never together": ([trace(WAVE), trace(WAVE, "HHN", begin=60)], SI, r"its channels have no time in common"),
    "infinite": ([trace(np.append(WAVE, np.inf))], SI, r"HHZ holds 1 values that are not finite.* sample 1001 "),
    "too short": ([trace(WAVE)], SI | {"start": 6.0}, r"ask for 11 s, but the record XX\.ONE lasts 10 s"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_named(tmp_path: Path, fault: str) -> None:
    traces, settings, message = FAULTS[fault]
    write(tmp_path / "a.mseed", *traces)
    (tmp_path / "junk").write_text("this is no inventory")
    metadata(tmp_path / "z.xml", flat(1e8, "M/S"))
    metadata(tmp_path / "empty.xml", Response())
    with pytest.raises(ValueError, match=message) as caught:
        motion(tmp_path, "a.mseed", **settings)
    assert "\n" not in str(caught.value)


def test_traces_without_samples_are_no_record(tmp_path: Path) -> None:
    assert not Stream([]).traces
    path = write(tmp_path / "a.sac", trace(np.float32(WAVE[:0]), begin=float(BEGIN - BEGIN)), kind="SAC")
    with pytest.raises(ValueError, match=r"'a\.sac' (holds no samples|cannot be read)"):
        read(path, **SI)


def test_the_example_needs_no_file() -> None:
    assert len(read_seismic(Path(EXAMPLE)).channels) == 3


# --- GSE ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_gse2_is_decoded_as_obspy_encodes_it(tmp_path: Path, seed: int) -> None:
    random = np.random.default_rng(seed)
    counts = (random.standard_normal(997) * 10.0 ** random.uniform(0, 6, 997)).astype(np.int32)
    path = write(tmp_path / "a.gse", trace(counts), kind="GSE2")
    np.testing.assert_array_equal(samples(read(path, **SI)), counts)


@pytest.mark.parametrize("name", ["loc_RJOB20050831023349.z", "loc_STAU20031119011659.z", "twiceCHK2.gse2", "acc.gse"])
def test_real_gse_is_what_obspy_reads(name: str) -> None:
    path = Path(get_example_file(name))
    expected = obspy.read(str(path))
    found = read_record(path, record_format(path))
    for ours, theirs in zip(found, expected, strict=True):
        np.testing.assert_array_equal(ours.data, theirs.data)
        assert (ours.id, ours.stats.starttime, ours.stats.calib) == (
            theirs.id,
            theirs.stats.starttime,
            theirs.stats.calib,
        )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ((rb"CHK2\s+-?\d+", b"CHK2 99999999"), "its checksum is 99999999, its samples make"),
        ((b"CHK2", b"XXX2"), "breaks off before the checksum"),
        ((b"CM6", b"CM8"), "its samples are stored as 'CM8'"),
    ],
)
def test_damaged_gse_is_refused(tmp_path: Path, change: tuple[bytes, bytes], message: str) -> None:
    path = write(tmp_path / "a.gse", trace(COUNTS), kind="GSE2")
    path.write_bytes(re.sub(*change, path.read_bytes()))
    with pytest.raises(ValueError, match=message):
        read(path, **SI)
