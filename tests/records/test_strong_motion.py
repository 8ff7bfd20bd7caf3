"""Strong-motion texts of PEER and of ESM/ITACA, written by hand as the databases do: read, judged, refused by name."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from oracles.records import NOISE, by_axis, motion, read

SAMPLES = NOISE[0] * 1e3
"""Of a size that eight digits hold."""


def peer(
    folder: Path,
    name: str = "a.AT2",
    component: str = "UP",
    holds: str = "ACCELERATION TIME SERIES IN UNITS OF G",
    sampling: str = "NPTS=   5000, DT=   .0050 SEC,",
    samples: np.ndarray = SAMPLES,
) -> Path:
    """A file of the PEER NGA database: four lines of header, five numbers a line."""
    rows = ["".join(f"{v:15.7E}" for v in samples[k : k + 5]) for k in range(0, samples.size, 5)]
    head = ["PEER NGA STRONG MOTION DATABASE RECORD", f"Made Up, 1/5/2026, Station 7, {component}", holds, sampling]
    (folder / name).write_text("\r\n".join([*head, *rows, ""]))
    return folder / name


@pytest.mark.parametrize(
    ("holds", "quantity", "size"),
    [
        ("ACCELERATION TIME SERIES IN UNITS OF G", "acceleration", 9.80665),
        ("ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.2 Hz LP=20.0 Hz", "acceleration", 9.80665),
        ("VELOCITY TIME SERIES IN UNITS OF CM/S", "velocity", 1e-2),
        ("VELOCITY TIME SERIES IN UNITS OF CM/SEC", "velocity", 1e-2),
        ("DISPLACEMENT TIME SERIES IN UNITS OF CM", "displacement", 1e-2),
        ("ACCELERATION TIME SERIES IN UNITS OF CM/SEC/SEC", "acceleration", 1e-2),
    ],
)
def test_peer_files_say_what_they_hold(tmp_path: Path, holds: str, quantity: str, size: float) -> None:
    channel = read(peer(tmp_path, holds=holds)).channels[0]
    assert (channel.quantity, channel.rate, channel.axis) == (quantity, pytest.approx(200.0, rel=1e-12), "z")
    np.testing.assert_allclose(channel.samples, size * SAMPLES, rtol=1e-7, atol=1e-12)  # eight digits


@pytest.mark.parametrize(
    "sampling",
    [
        "NPTS=   5000, DT=   .0050 SEC",
        "NPTS= 5000, DT= 5.0E-03 SEC",
        " 5000    0.0050    NPTS, DT",
        "NPTS=5000 DT=.005 S",
        "NPTS= 5000, DT= .005",
        "NPTS= 5000, DT= 5.0 MSEC",
        "NPTS= 5000, DT= 5.0 ms, LP=20 HZ",
        " 5000    5.0    NPTS, DT (MS)",
    ],
)
def test_peer_headers_of_all_years_state_the_step(tmp_path: Path, sampling: str) -> None:
    assert read(peer(tmp_path, sampling=sampling)).channels[0].rate == pytest.approx(200.0, rel=1e-12)


def test_three_peer_files_are_one_record_and_down_is_turned(tmp_path: Path) -> None:
    for component, sign in (("090", 2.0), ("180", 3.0), ("DWN", 1.0)):
        peer(tmp_path, f"RSN6_{component}.AT2", component, samples=sign * SAMPLES)
    record = read(tmp_path / "RSN6_*.AT2", axes={"090": "x", "180": "y", "Z": "z"})
    for axis, factor in (("x", 2.0), ("y", 3.0), ("z", -1.0)):
        np.testing.assert_allclose(by_axis(record)[axis], factor * 9.80665 * SAMPLES, rtol=1e-7, atol=1e-12)
    assert any("its component is DWN, so that its sign is turned" in note for note in record.notes)


def test_a_peer_file_is_known_by_its_beginning(tmp_path: Path) -> None:
    np.testing.assert_array_equal(
        read(peer(tmp_path, "a.txt")).channels[0].samples, read(peer(tmp_path)).channels[0].samples
    )


HEADER = {
    **{"EVENT_NAME": "MADE_UP", "EVENT_TIME_HHMMSS": "080000", "NETWORK": "IT", "STATION_CODE": "AQG", "LOCATION": ""},
    **{"VS30_M/S": "", "DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS": "20260105_080000.000", "STREAM": "HNZ"},
    **{"SAMPLING_INTERVAL_S": "0.005000", "NDATA": "5000", "UNITS": "cm/s^2", "DATA_TYPE": "ACCELERATION"},
    **{"LOW_CUT_FREQUENCY_HZ": "", "HIGH_CUT_FREQUENCY_HZ": "", "USER4": ""},
}


def esm(folder: Path, name: str = "a.ASC", samples: np.ndarray = SAMPLES, **header: str) -> Path:
    """A file of the ESM database (DYNA 1.2): a header of keys, one number a line."""
    head = [f"{key}: {value}" for key, value in {**HEADER, **header}.items() if value != "-"]
    (folder / name).write_text("\n".join([*head, *(f"{v:.8e}" for v in samples), ""]))
    return folder / name


@pytest.mark.parametrize(
    ("units", "kind", "quantity", "size"),
    [
        ("cm/s^2", "ACCELERATION", "acceleration", 1e-2),
        ("cm/s^2", "UNPROCESSED ACCELERATION", "acceleration", 1e-2),
        ("g", "ACCELERATION", "acceleration", 9.80665),
        ("cm/s", "VELOCITY", "velocity", 1e-2),
        ("cm", "DISPLACEMENT", "displacement", 1e-2),
    ],
)
@pytest.mark.parametrize("name", ["a.ASC", "a.txt"])
def test_esm_files_say_what_they_hold(
    tmp_path: Path, units: str, kind: str, quantity: str, size: float, name: str
) -> None:
    channel = read(esm(tmp_path, name, UNITS=units, DATA_TYPE=kind)).channels[0]
    assert (channel.quantity, channel.axis, channel.name) == (quantity, "z", "IT.AQG..HNZ")
    assert channel.rate == pytest.approx(200.0, rel=1e-12)
    np.testing.assert_allclose(channel.samples, size * SAMPLES, rtol=1e-8)  # nine digits


def test_three_esm_files_are_one_record_on_one_clock(tmp_path: Path) -> None:
    for letter, second in (("E", "00.000"), ("N", "01.500"), ("Z", "00.250")):
        time = {"DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS": f"20260105_0800{second}"}
        esm(tmp_path, f"IT.AQG..HN{letter}.ASC", STREAM=f"HN{letter}", **time)
    record = read(tmp_path / "IT.AQG..HN?.ASC")
    assert {c.axis: c.time for c in record.channels} == pytest.approx({"x": -1.5, "y": 0.0, "z": -1.25})


def test_the_older_itaca_header_names_components(tmp_path: Path) -> None:
    record = read(esm(tmp_path, STREAM="-", COMPONENT="WE"))
    assert record.channels[0].axis == "x"


def test_the_band_that_the_archive_left_is_said(tmp_path: Path) -> None:
    record = read(esm(tmp_path, LOW_CUT_FREQUENCY_HZ="0.200", HIGH_CUT_FREQUENCY_HZ="20.000"))
    assert "a.ASC was filtered by the archive: motion below 0.200 Hz and above 20.000 Hz is understated" in record.notes


FAULTS: dict[str, tuple[dict[str, Any], str]] = {
    "no quantity": ({"holds": "SOMETHING"}, r"its third line must say .*, it says 'SOMETHING'"),
    "no step": ({"sampling": "some numbers"}, r"its fourth line must say .*, it says 'some numbers'"),
    "step of zero": ({"sampling": "NPTS= 5000, DT= .0000 SEC"}, r"states DT = \.0000 SEC; it must be a positive"),
    "rate for a step": (
        {"sampling": "NPTS= 5000, DT= 200 HZ"},
        r"fourth line states DT in 'HZ': 'HZ' is of frequency; .*correct it there",
    ),
    "unit": ({"holds": "ACCELERATION TIME SERIES IN UNITS OF FURLONG"}, r"unit in its header: 'FURLONG' is not a unit"),
    "two quantities": (
        {"holds": "VELOCITY TIME SERIES IN UNITS OF G"},
        r"header says velocity in 'G', which is a unit of acceleration",
    ),
    "truncated": (
        {"sampling": "NPTS= 6000, DT= .0050 SEC"},
        r"holds 5000 samples, .* NPTS = 6000; it may be trunc",
    ),
    "too many": ({"sampling": "NPTS= 4000, DT= .0050 SEC"}, r"holds 5000 samples, and its header states NPTS = 4000"),
    "claims": ({"sampling": f"NPTS= {2**40}, DT= .0050 SEC"}, r"holds 5000 samples, and its header states NPTS"),
    "azimuth": ({"component": "180"}, r"ground\.axes does not say which axis 'a\.AT2' is; .*axes = \{ "),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_peer_faults_are_named(tmp_path: Path, fault: str) -> None:
    options, message = FAULTS[fault]
    peer(tmp_path, **options)
    with pytest.raises(ValueError, match=message):
        motion(tmp_path, "a.AT2")


ESM_FAULTS = {
    "spectrum": ({"DATA_TYPE": "ACCELERATION RESPONSE SPECTRUM"}, r"its DATA_TYPE is .*, which is no time history"),
    "no unit": ({"UNITS": ""}, r"its header states no UNITS; it is no record of ESM or ITACA, or a damaged one"),
    "unit": ({"UNITS": "furlong"}, r"the unit in its header: 'furlong' is not a unit that is known"),
    "two quantities": ({"UNITS": "cm"}, r"its header says acceleration in 'cm', which is a unit of displacement"),
    "no step": ({"SAMPLING_INTERVAL_S": "-"}, r"its header states no SAMPLING_INTERVAL_S"),
    "step": ({"SAMPLING_INTERVAL_S": "-0.005"}, r"SAMPLING_INTERVAL_S: -0\.005, which must be a positive number"),
    "truncated": ({"NDATA": "6000"}, r"holds 5000 samples, .* NDATA = 6000; it may be truncated"),
    "claims": ({"NDATA": "1e300"}, r"holds 5000 samples, and its header states NDATA = "),
}


@pytest.mark.parametrize("fault", ESM_FAULTS)
def test_esm_faults_are_named(tmp_path: Path, fault: str) -> None:
    header, message = ESM_FAULTS[fault]
    esm(tmp_path, **header)
    with pytest.raises(ValueError, match=r"ground\.file = 'a\.ASC'.*" + message):
        motion(tmp_path, "a.ASC")


@pytest.mark.parametrize("write", [peer, esm])
def test_a_word_among_the_numbers_is_named_by_its_line(tmp_path: Path, write: Any) -> None:
    path = write(tmp_path)
    lines = path.read_text().splitlines()
    lines[99] = "*****"
    path.write_text("\n".join(lines))
    with pytest.raises(ValueError, match=r"line 100 holds '\*\*\*\*\*', which is not a number"):
        read(path)


def test_files_that_are_missing_are_named(tmp_path: Path) -> None:
    for name in ("no.AT2", "no*.AT2", "no.ASC"):
        with pytest.raises(ValueError, match=r"ground\.file = 'no.*': there is no such file in"):
            motion(tmp_path, name)
